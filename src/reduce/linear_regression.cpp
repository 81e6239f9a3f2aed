// SPDX-License-Identifier: BSD-3-Clause
#include "reduce/linear_regression.hpp"

#include "core/error.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/QR>
#include <fmt/format.h>

namespace culm::reduce {

namespace {

// Columns of unit length whose independent part is smaller than this are taken as dependent.
constexpr double rank_threshold = 1e-10;

[[noreturn]] void fail(const std::string& sentence) {
    throw core::NumericalError(core::FailureKind::FitFailed, sentence);
}

void check_input(const Eigen::MatrixXd& design, const Eigen::Ref<const Eigen::VectorXd>& response,
                 std::span<const std::string> names) {
    if (design.rows() <= design.cols())
        fail(fmt::format("a regression with {} coefficients needs at least {} points, there are {}",
                         design.cols(), design.cols() + 1, design.rows()));
    if (!response.allFinite())
        fail("a response of the regression is not finite");
    for (Eigen::Index j = 0; j < design.cols(); ++j)
        if (!design.col(j).allFinite())
            fail(fmt::format("the regressor \"{}\" has a value that is not finite",
                             names[static_cast<std::size_t>(j)]));
}

bool has_constant_column(const Eigen::MatrixXd& design) {
    for (Eigen::Index j = 0; j < design.cols(); ++j)
        if (design(0, j) != 0.0 && (design.col(j).array() == design(0, j)).all())
            return true;
    return false;
}

/// R² and its adjustment for the number of coefficients.
void set_quality(const Eigen::Ref<const Eigen::VectorXd>& response, bool about_mean,
                 LinearRegression& result) {
    const double centre = about_mean ? response.mean() : 0.0;
    const double total = (response.array() - centre).square().sum();
    const auto total_freedom = static_cast<double>(response.size() - (about_mean ? 1 : 0));
    const auto freedom = static_cast<double>(result.degrees_of_freedom);
    // A constant response has no variance, so no share of it is explained.
    if (total <= result.rounding_sum_of_squares)
        return;
    result.r_squared = 1.0 - result.residual_sum_of_squares / total;
    result.adjusted_r_squared =
        1.0 - (result.residual_sum_of_squares / freedom) / (total / total_freedom);
}

void set_coefficients(const Eigen::VectorXd& values, std::span<const std::string> names,
                      LinearRegression& result) {
    const double factor = student_t_factor(result.degrees_of_freedom);
    for (Eigen::Index j = 0; j < values.size(); ++j) {
        const Estimate found = estimate(values[j], result.covariance(j, j), factor);
        const double t = values[j] == 0.0 ? 0.0 : values[j] / found.standard_error;
        result.coefficients.push_back({found, names[static_cast<std::size_t>(j)],
                                       student_t_p_value(t, result.degrees_of_freedom)});
    }
}

} // namespace

LinearRegression regress(Eigen::MatrixXd design, std::span<const double> response,
                         std::span<const std::string> names) {
    const Eigen::Map<const Eigen::VectorXd> observed(response.data(),
                                                     static_cast<Eigen::Index>(response.size()));
    check_input(design, observed, names);
    // Columns of length one: the rank then does not depend on the units of the regressors.
    const Eigen::VectorXd scale = design.colwise().norm();
    for (Eigen::Index j = 0; j < scale.size(); ++j)
        if (scale[j] == 0.0)
            fail(fmt::format("the regressor \"{}\" is zero everywhere",
                             names[static_cast<std::size_t>(j)]));
    const bool about_mean = has_constant_column(design);
    design.array().rowwise() /= scale.transpose().array();
    // In place: a study has millions of rows.
    Eigen::ColPivHouseholderQR<Eigen::Ref<Eigen::MatrixXd>> qr(design);
    qr.setThreshold(rank_threshold);
    if (qr.rank() < design.cols()) {
        const Eigen::Index dependent = qr.colsPermutation().indices()[qr.rank()];
        fail(fmt::format("the regressor \"{}\" depends linearly on the others: its coefficient is "
                         "not identifiable from this design",
                         names[static_cast<std::size_t>(dependent)]));
    }
    const auto triangle = qr.matrixR().topRows(design.cols()).triangularView<Eigen::Upper>();
    // Qᵀy: the first numbers give the coefficients, the others the residuals.
    Eigen::VectorXd residuals = observed;
    residuals.applyOnTheLeft(qr.householderQ().adjoint());
    const Eigen::VectorXd values = scale.cwiseInverse().cwiseProduct(
        qr.colsPermutation() * triangle.solve(residuals.head(design.cols())));
    residuals.head(design.cols()).setZero();
    residuals.applyOnTheLeft(qr.householderQ());

    LinearRegression result;
    result.residuals.assign(residuals.begin(), residuals.end());
    result.residual_sum_of_squares = residuals.squaredNorm();
    result.degrees_of_freedom = static_cast<std::size_t>(design.rows() - design.cols());
    // Sums of squares below this consist of rounding errors: 64 ulp of the largest response in
    // every residual. F-tests of exact laws would otherwise divide rounding by rounding.
    const double ulp =
        64.0 * std::numeric_limits<double>::epsilon() * observed.cwiseAbs().maxCoeff();
    result.rounding_sum_of_squares = static_cast<double>(design.rows()) * ulp * ulp;
    const double variance =
        result.residual_sum_of_squares / static_cast<double>(result.degrees_of_freedom);
    result.sigma = std::sqrt(variance);
    // (XᵀX)⁻¹ = (R⁻¹)(R⁻¹)ᵀ of X = QR, without ever forming XᵀX, whose condition is squared.
    Eigen::MatrixXd root = Eigen::MatrixXd::Identity(design.cols(), design.cols());
    triangle.solveInPlace(root);
    root = scale.cwiseInverse().asDiagonal() * (qr.colsPermutation() * root);
    result.covariance = variance * root * root.transpose();
    set_quality(observed, about_mean, result);
    set_coefficients(values, names, result);
    return result;
}

Prediction predict(const LinearRegression& regression, std::span<const double> regressors) {
    const Eigen::Map<const Eigen::VectorXd> row(regressors.data(),
                                                static_cast<Eigen::Index>(regressors.size()));
    double value = 0.0;
    for (std::size_t j = 0; j < regressors.size(); ++j)
        value += regression.coefficients[j].value * regressors[j];
    // A new observation has the variance of the law, xᵀ Cov x, plus that of one response about it.
    const double mean_variance = std::max(row.dot(regression.covariance * row), 0.0);
    return {estimate(value, mean_variance + regression.sigma * regression.sigma,
                     student_t_factor(regression.degrees_of_freedom)),
            std::sqrt(mean_variance)};
}

NestedTest nested_f_test(const LinearRegression& reduced, const LinearRegression& full) {
    NestedTest test;
    test.numerator_degrees_of_freedom = reduced.degrees_of_freedom - full.degrees_of_freedom;
    test.denominator_degrees_of_freedom = full.degrees_of_freedom;
    const double gain = reduced.residual_sum_of_squares - full.residual_sum_of_squares;
    if (gain > full.rounding_sum_of_squares)
        test.f_statistic = (gain / static_cast<double>(test.numerator_degrees_of_freedom)) /
                           (full.sigma * full.sigma);
    test.p_value = fisher_f_p_value(test.f_statistic, test.numerator_degrees_of_freedom,
                                    test.denominator_degrees_of_freedom);
    return test;
}

} // namespace culm::reduce
