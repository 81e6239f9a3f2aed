// SPDX-License-Identifier: BSD-3-Clause
#include "reduce/sensitivity.hpp"

#include "core/error.hpp"
#include "reduce/chaos_basis.hpp"
#include "reduce/distributions.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

#include <Eigen/Cholesky>
#include <fmt/core.h>

namespace culm::reduce {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// The least-squares problem of all degrees at once: terms are ordered by degree, so the Cholesky
/// factor L of the Gram matrix of the highest degree holds those of the others, and the points'
/// values t = L⁻¹φ their fits and leverages as partial sums.
class ChaosFit {
  public:
    ChaosFit(const ChaosBasis& basis, const MatrixXd& responses)
        : basis_(basis), responses_(responses) {
        const auto terms = static_cast<Index>(basis.terms());
        MatrixXd gram = MatrixXd::Zero(terms, terms);
        MatrixXd products = MatrixXd::Zero(terms, responses.cols());
        for_blocks([&](Index first, const MatrixXd& values) {
            gram.selfadjointView<Eigen::Lower>().rankUpdate(values.transpose());
            products += values.transpose() * responses.middleRows(first, values.rows());
        });
        const Eigen::LLT<MatrixXd> cholesky(gram.selfadjointView<Eigen::Lower>());
        factor_ = cholesky.matrixL();
        if (cholesky.info() == Eigen::Success)
            find_usable_degree();
        if (degree_ < 1)
            throw core::NumericalError(core::FailureKind::FitFailed,
                                       "the points do not tell the inputs apart");
        loadings_ = factor_.triangularView<Eigen::Lower>().solve(products);
    }

    /// Highest degree whose terms the points tell apart.
    [[nodiscard]] int degree() const { return degree_; }

    /// Sums of the squared leave-one-out errors: (degrees from 0, responses).
    [[nodiscard]] MatrixXd left_out_errors() const {
        MatrixXd sums = MatrixXd::Zero(degree_ + 1, responses_.cols());
        for_blocks([&](Index first, const MatrixXd& values) {
            const MatrixXd t = whitened(values);
            MatrixXd fitted = MatrixXd::Zero(values.rows(), responses_.cols());
            VectorXd leverage = VectorXd::Zero(values.rows());
            Index from = 0;
            for (int d = 0; d <= degree_; ++d) {
                const Index count = static_cast<Index>(basis_.terms_up_to(d)) - from;
                fitted += t.middleRows(from, count).transpose() * loadings_.middleRows(from, count);
                leverage += t.middleRows(from, count).colwise().squaredNorm().transpose();
                from += count;
                const MatrixXd rest = responses_.middleRows(first, values.rows()) - fitted;
                sums.row(d) += (rest.array().colwise() / free_share(leverage).array())
                                   .square()
                                   .colwise()
                                   .sum()
                                   .matrix();
            }
        });
        return sums;
    }

    struct Solution {
        VectorXd coefficients; ///< (terms of the degree)
        MatrixXd covariance;   ///< HC3
    };
    [[nodiscard]] Solution solve(int degree, Index response) const {
        const auto terms = static_cast<Index>(basis_.terms_up_to(degree));
        const auto lower = factor_.topLeftCorner(terms, terms).triangularView<Eigen::Lower>();
        const VectorXd loadings = loadings_.col(response).head(terms);
        MatrixXd middle = MatrixXd::Zero(terms, terms);
        for_blocks([&](Index first, const MatrixXd& values) {
            MatrixXd t = lower.solve(values.leftCols(terms).transpose());
            const VectorXd leverage = t.colwise().squaredNorm().transpose();
            const VectorXd rest =
                (responses_.col(response).segment(first, values.rows()) - t.transpose() * loadings)
                    .cwiseQuotient(free_share(leverage));
            t = t * rest.asDiagonal();
            middle.selfadjointView<Eigen::Lower>().rankUpdate(t);
        });
        Solution solution;
        solution.coefficients = lower.transpose().solve(loadings);
        const MatrixXd full = middle.selfadjointView<Eigen::Lower>();
        const MatrixXd half = lower.transpose().solve(full);
        solution.covariance = lower.transpose().solve(half.transpose());
        return solution;
    }

  private:
    void for_blocks(const std::function<void(Index, const MatrixXd&)>& visit) const {
        constexpr Index block = 4096;
        for (Index first = 0; first < responses_.rows(); first += block)
            visit(first, basis_.at_points(first, std::min(block, responses_.rows() - first)));
    }

    [[nodiscard]] MatrixXd whitened(const MatrixXd& values) const {
        return factor_.triangularView<Eigen::Lower>().solve(values.transpose());
    }

    /// 1 − leverage; a point that alone decides a term predicts nothing, and counts as far off.
    static VectorXd free_share(const VectorXd& leverage) {
        return (1.0 - leverage.array()).max(1e-6).matrix();
    }

    void find_usable_degree() {
        constexpr double smallest_pivot = 1e-4; // root of the share of an independent column
        const double scale = std::sqrt(static_cast<double>(responses_.rows()));
        for (int d = 1; d <= basis_.degree(); ++d) {
            const auto terms = static_cast<Index>(basis_.terms_up_to(d));
            if (factor_.diagonal().head(terms).minCoeff() < smallest_pivot * scale)
                return;
            degree_ = d;
        }
    }

    const ChaosBasis& basis_;
    const MatrixXd& responses_;
    MatrixXd factor_;   ///< L
    MatrixXd loadings_; ///< L⁻¹Φᵀy: (terms, responses)
    int degree_ = 0;
};

/// Shares of the variance Σ c² with their variances: c is normal with this covariance.
class Shares {
  public:
    explicit Shares(const ChaosFit::Solution& solution, std::size_t freedom)
        : c_(solution.coefficients), v_(solution.covariance), factor_(student_t_factor(freedom)) {
        // The constant explains nothing.
        c_(0) = 0.0;
        v_.row(0).setZero();
        v_.col(0).setZero();
        variance_ = std::max(0.0, (c_.cwiseAbs2() - v_.diagonal()).sum());
    }

    [[nodiscard]] double variance() const { return variance_; }

    /// Of the terms for which `is_member` is 1 (others 0).
    [[nodiscard]] Share of(const VectorXd& is_member) const {
        const double part = is_member.dot((c_.cwiseAbs2() - v_.diagonal()));
        const double share = std::clamp(part / variance_, 0.0, 1.0);
        const VectorXd slope = (is_member.array() - share).matrix() / variance_;
        const VectorXd weighted = slope.cwiseProduct(c_);
        // Variance of the quadratic form Σ slope c²: the delta method, and the term of second
        // order that remains where coefficients vanish.
        const double of_first_order = 4.0 * weighted.dot(v_ * weighted);
        const double of_second_order = 2.0 * slope.dot(v_.cwiseAbs2() * slope);
        const double half =
            factor_ * std::sqrt(std::max(0.0, of_first_order) + std::max(0.0, of_second_order));
        return {share, {std::max(0.0, share - half), std::min(1.0, share + half)}};
    }

  private:
    VectorXd c_;
    MatrixXd v_;
    double factor_;
    double variance_ = 0.0;
};

void fill_shares(Sensitivity& result, const ChaosBasis& basis, const ChaosFit::Solution& solution) {
    const Shares shares(solution, result.points - result.terms);
    result.mean = solution.coefficients(0);
    result.standard_deviation = std::sqrt(shares.variance());
    double alone = 0.0;
    for (std::size_t g = 0; g < result.groups.size(); ++g) {
        VectorXd is_first = VectorXd::Zero(static_cast<Index>(result.terms));
        VectorXd is_total = is_first;
        for (std::size_t k = 0; k < result.terms; ++k) {
            if (!basis.contains(k, g))
                continue;
            is_total(static_cast<Index>(k)) = 1.0;
            if (basis.is_of_one_group(k))
                is_first(static_cast<Index>(k)) = 1.0;
        }
        result.groups[g].first_order = shares.of(is_first);
        result.groups[g].total = shares.of(is_total);
        alone += result.groups[g].first_order.value;
    }
    result.interactions = std::max(0.0, 1.0 - alone);
}

/// The smallest degree whose error is the least but for rounding; 0 for a constant response.
int best_degree(const VectorXd& errors) {
    constexpr double rounding = 1e-24; // squared, as a share of the response's own variance
    const double least = errors.minCoeff() * (1.0 + 1e-9) + rounding * errors(0);
    Index degree = 0;
    while (errors(degree) > least)
        ++degree;
    return static_cast<int>(degree);
}

/// Two points for every term, and no more work than some 5e9 multiplications.
std::size_t most_terms(Index points) {
    constexpr double most_work = 5e9;
    const auto n = static_cast<double>(points);
    return static_cast<std::size_t>(std::min(0.5 * n, std::sqrt(most_work / n)));
}

} // namespace

std::vector<Sensitivity> analyse_sensitivity(const std::vector<InputGroup>& groups,
                                             const MatrixXd& responses) {
    const ChaosBasis basis(groups, most_terms(responses.rows()));
    if (basis.degree() < 1)
        throw core::NumericalError(
            core::FailureKind::FitFailed,
            fmt::format("{} points are too few for {} inputs", responses.rows(), groups.size()));
    const ChaosFit fit(basis, responses);
    const MatrixXd errors = fit.left_out_errors();
    std::vector<Sensitivity> results;
    for (Index response = 0; response < responses.cols(); ++response) {
        Sensitivity result;
        result.points = static_cast<std::size_t>(responses.rows());
        for (const InputGroup& group : groups)
            result.groups.push_back({group.name, {}, {}});
        result.degree = best_degree(errors.col(response));
        result.terms = basis.terms_up_to(result.degree);
        if (result.degree > 0)
            result.predicted_share = 1.0 - errors(result.degree, response) / errors(0, response);
        if (result.degree > 0)
            fill_shares(result, basis, fit.solve(result.degree, response));
        else
            result.mean = responses.col(response).mean();
        results.push_back(std::move(result));
    }
    return results;
}

} // namespace culm::reduce
