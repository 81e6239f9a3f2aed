// SPDX-License-Identifier: BSD-3-Clause
#include "reduce/sensitivity.hpp"

#include "core/error.hpp"
#include "reduce/distributions.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <fmt/core.h>

namespace culm::reduce {

namespace {

using Eigen::Index;

/// Exponents of all monomials of `inputs` variables of exactly this degree.
void append_exponents(Index inputs, int degree, std::vector<int>& prefix,
                      std::vector<std::vector<int>>& all) {
    if (static_cast<Index>(prefix.size()) == inputs - 1) {
        all.push_back(prefix);
        all.back().push_back(degree);
        return;
    }
    for (int first = degree; first >= 0; --first) {
        prefix.push_back(first);
        append_exponents(inputs, degree - first, prefix, all);
        prefix.pop_back();
    }
}

constexpr int most_degrees = 12;

using Degrees = std::vector<std::size_t>;

/// Appends the terms whose degrees of the groups from `group` on add up to `degree`; stops when
/// there are more than `most`.
void append_terms(const std::vector<GroupPolynomials>& polynomials, std::size_t group, int degree,
                  std::size_t most, Degrees& term, std::vector<Degrees>& terms) {
    if (terms.size() > most)
        return;
    if (group == polynomials.size()) {
        if (degree == 0)
            terms.push_back(term);
        return;
    }
    append_terms(polynomials, group + 1, degree, most, term, terms);
    const std::vector<int>& degrees = polynomials[group].degrees();
    for (std::size_t k = 0; k < degrees.size() && degrees[k] <= degree; ++k) {
        term[group] = k + 1;
        append_terms(polynomials, group + 1, degree - degrees[k], most, term, terms);
    }
    term[group] = 0;
}

/// Products of the polynomials of several independent groups of inputs, up to a total degree.
class ChaosBasis {
  public:
    /// The largest total degree (at most 12) with at most `most_terms` terms.
    ChaosBasis(const std::vector<InputGroup>& groups, std::size_t most_terms) : groups_(groups) {
        // A single group of several inputs must not have more functions than terms are allowed.
        for (const InputGroup& group : groups) {
            const auto inputs = static_cast<std::size_t>(group.nodes.cols());
            int degree = 0;
            std::size_t functions = 1; // binomial(degree + inputs, inputs)
            while (degree < most_degrees) {
                const auto next = static_cast<std::size_t>(degree) + 1;
                functions = functions * (next + inputs) / next;
                if (functions > most_terms)
                    break;
                ++degree;
            }
            polynomials_.emplace_back(group.nodes, group.weights, degree);
        }
        for (int degree = 0; degree <= most_degrees; ++degree) {
            std::vector<Degrees> more = terms_;
            Degrees term(groups.size(), 0);
            append_terms(polynomials_, 0, degree, most_terms, term, more);
            if (more.size() > most_terms || (degree > 0 && more.size() == terms_.size()))
                break;
            terms_ = std::move(more);
            terms_up_to_.push_back(terms_.size());
        }
    }

    [[nodiscard]] std::size_t terms() const { return terms_.size(); }
    [[nodiscard]] int degree() const { return static_cast<int>(terms_up_to_.size()) - 1; }
    /// Terms of total degree 0 … d; they come first.
    [[nodiscard]] std::size_t terms_up_to(int d) const {
        return terms_up_to_[static_cast<std::size_t>(d)];
    }
    /// Does the term contain the group? Does it contain no other?
    [[nodiscard]] bool contains(std::size_t term, std::size_t group) const {
        return terms_[term][group] > 0;
    }
    [[nodiscard]] bool is_of_one_group(std::size_t term) const {
        return std::ranges::count_if(terms_[term], [](std::size_t k) { return k > 0; }) == 1;
    }

    /// Values at points first … first + count − 1 of the groups: (count, terms).
    [[nodiscard]] Eigen::MatrixXd at_points(Eigen::Index first, Eigen::Index count) const {
        std::vector<Eigen::MatrixXd> functions;
        functions.reserve(groups_.size());
        for (std::size_t g = 0; g < groups_.size(); ++g)
            functions.push_back(polynomials_[g].at(groups_[g].values.middleRows(first, count)));
        Eigen::MatrixXd values =
            Eigen::MatrixXd::Ones(count, static_cast<Eigen::Index>(terms_.size()));
        for (std::size_t k = 0; k < terms_.size(); ++k)
            for (std::size_t g = 0; g < groups_.size(); ++g)
                if (terms_[k][g] > 0)
                    values.col(static_cast<Eigen::Index>(k)).array() *=
                        functions[g].col(static_cast<Eigen::Index>(terms_[k][g] - 1)).array();
        return values;
    }

  private:
    const std::vector<InputGroup>& groups_;
    std::vector<GroupPolynomials> polynomials_;
    /// For each term the function of each group, counted from 1; 0 is the constant.
    std::vector<std::vector<std::size_t>> terms_;
    std::vector<std::size_t> terms_up_to_;
};

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// The least-squares problem of all degrees at once: terms are ordered by degree, so the Cholesky
/// factor L of the Gram matrix of the highest degree contains those of the others. Partial sums
/// over t = L⁻¹φ of a point give its fits and leverages.
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
                                       "the points do not distinguish the inputs");
        loadings_ = factor_.triangularView<Eigen::Lower>().solve(products);
    }

    /// Highest degree whose terms the points distinguish.
    [[nodiscard]] int degree() const { return degree_; }

    /// Sums of the squared leave-one-out errors: (degrees from 0, responses).
    [[nodiscard]] MatrixXd left_out_errors() const {
        MatrixXd sums = MatrixXd::Zero(degree_ + 1, responses_.cols());
        for_blocks([&](Index first, const MatrixXd& values) {
            const MatrixXd t = factor_.triangularView<Eigen::Lower>().solve(values.transpose());
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

    /// 1 − leverage, bounded below: a point that alone determines a term then has a large error.
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

    /// Share of the terms for which `is_member` is 1 (others 0).
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

/// The smallest degree whose error is the minimum up to rounding; 0 for a constant response.
int best_degree(const VectorXd& errors) {
    constexpr double rounding = 1e-24; // squared, as a share of the response's own variance
    const double least = errors.minCoeff() * (1.0 + 1e-9) + rounding * errors(0);
    Index degree = 0;
    while (errors(degree) > least)
        ++degree;
    return static_cast<int>(degree);
}

/// Terms that two points each and about 5e9 multiplications in total allow.
std::size_t most_terms(Index points) {
    constexpr double most_work = 5e9;
    const auto n = static_cast<double>(points);
    return static_cast<std::size_t>(std::min(0.5 * n, std::sqrt(most_work / n)));
}

} // namespace

GroupPolynomials::GroupPolynomials(const Eigen::MatrixXd& nodes, const Eigen::VectorXd& weights,
                                   int largest_degree) {
    centre_ = weights.transpose() * nodes;
    const Eigen::MatrixXd centred = nodes.rowwise() - centre_;
    scale_ = (weights.transpose() * centred.cwiseAbs2()).cwiseSqrt();
    for (double& scale : scale_)
        scale = scale > 0.0 ? scale : 1.0;
    std::vector<int> monomial_degrees;
    for (int degree = 0; degree <= largest_degree; ++degree) {
        std::vector<int> prefix;
        append_exponents(nodes.cols(), degree, prefix, exponents_);
        monomial_degrees.resize(exponents_.size(), degree);
    }
    // Gram-Schmidt with each step twice is orthogonal to rounding for any set of monomials (Giraud
    // et al. 2005). A remainder below this share of its monomial is rounding.
    constexpr double independent_share = 1e-8;
    const Eigen::VectorXd roots = weights.cwiseSqrt();
    const Eigen::MatrixXd raw = roots.asDiagonal() * monomials(nodes);
    const Index count = raw.cols();
    Eigen::MatrixXd basis(raw.rows(), count);
    Eigen::MatrixXd recipes = Eigen::MatrixXd::Zero(count, count);
    Index kept = 0;
    for (Index k = 0; k < count; ++k) {
        Eigen::VectorXd column = raw.col(k);
        Eigen::VectorXd recipe = Eigen::VectorXd::Unit(count, k);
        const double norm = column.norm();
        for (int pass = 0; pass < 2; ++pass) {
            const Eigen::VectorXd along = basis.leftCols(kept).transpose() * column;
            column -= basis.leftCols(kept) * along;
            recipe -= recipes.leftCols(kept) * along;
        }
        const double rest = column.norm();
        if (!(rest > independent_share * norm))
            continue;
        basis.col(kept) = column / rest;
        recipes.col(kept) = recipe / rest;
        if (kept > 0)
            degrees_.push_back(monomial_degrees[static_cast<std::size_t>(k)]);
        ++kept;
    }
    coefficients_ = recipes.middleCols(1, kept - 1);
}

Eigen::MatrixXd GroupPolynomials::monomials(const Eigen::MatrixXd& places) const {
    const Eigen::MatrixXd standard =
        (places.rowwise() - centre_).array().rowwise() / scale_.array();
    Eigen::MatrixXd values =
        Eigen::MatrixXd::Ones(places.rows(), static_cast<Index>(exponents_.size()));
    for (Index k = 0; k < values.cols(); ++k)
        for (Index input = 0; input < places.cols(); ++input)
            for (int power = 0;
                 power < exponents_[static_cast<std::size_t>(k)][static_cast<std::size_t>(input)];
                 ++power)
                values.col(k).array() *= standard.col(input).array();
    return values;
}

Eigen::MatrixXd GroupPolynomials::at(const Eigen::MatrixXd& places) const {
    return monomials(places) * coefficients_;
}

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
