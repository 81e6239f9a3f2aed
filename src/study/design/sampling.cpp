// SPDX-License-Identifier: BSD-3-Clause
#include "study/design/sampling.hpp"

#include "core/error.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <boost/math/distributions/normal.hpp>
#include <boost/random/sobol.hpp>
#include <fmt/format.h>

namespace culm::study {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;

double normal_score(double u) {
    return boost::math::quantile(boost::math::normal{}, u);
}

double normal_share(double z) {
    return std::clamp(boost::math::cdf(boost::math::normal{}, z),
                      std::numeric_limits<double>::min(), 1.0 - 0x1p-53);
}

/// Normal correlations for rank correlations times `share`, off the diagonal.
MatrixXd normal_correlations(const MatrixXd& rank, double share) {
    // Pearson (1907): r = 2 sin(π ρ/6), exact for a normal copula.
    MatrixXd normal = (2.0 * (rank.array() * (share * std::numbers::pi / 6.0)).sin()).matrix();
    normal.diagonal().setOnes();
    return normal;
}

double smallest_eigenvalue(const MatrixXd& matrix) {
    return Eigen::SelfAdjointEigenSolver<MatrixXd>(matrix, Eigen::EigenvaluesOnly)
        .eigenvalues()
        .minCoeff();
}

/// Variables nearer to a linear dependence than this are treated as dependent.
constexpr double least_eigenvalue = 1e-8;

/// The largest share of the correlations that is possible, rounded down to three digits.
double possible_share(const MatrixXd& rank) {
    double low = 0.0;
    double high = 1.0;
    // At a share of zero the matrix is the identity. Forty halvings reach the rounding of double.
    for (int halving = 0; halving < 40; ++halving) {
        const double middle = 0.5 * (low + high);
        (smallest_eigenvalue(normal_correlations(rank, middle)) > least_eigenvalue ? low : high) =
            middle;
    }
    return std::floor(low * 1000.0) / 1000.0;
}

/// Indices of the values in ascending order.
std::vector<std::size_t> order_of(std::span<const double> values) {
    std::vector<std::size_t> order(values.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::ranges::stable_sort(order, {}, [&](std::size_t i) { return values[i]; });
    return order;
}

} // namespace

/// The key of the sample's first random number for a purpose.
static RandomKey random_key(const SampleKey& key, RandomPurpose purpose) {
    return {key.seed, purpose, factor_id(key.factor), static_cast<std::uint64_t>(key.replicate), 0};
}

/// In random order (Fisher & Yates; Durstenfeld 1964).
std::vector<std::int64_t> latin_hypercube_strata(const SampleKey& key, std::int64_t points) {
    RandomKey step = random_key(key, RandomPurpose::Permutation);
    std::vector<std::int64_t> order(static_cast<std::size_t>(points));
    std::iota(order.begin(), order.end(), std::int64_t{0});
    for (std::size_t i = order.size(); i > 1; --i) {
        step.point = i;
        std::swap(order[i - 1], order[random_below(i, random_bits(step))]);
    }
    return order;
}

std::vector<double> places_in_strata(const SampleKey& key,
                                     const std::vector<std::int64_t>& strata) {
    RandomKey place = random_key(key, RandomPurpose::StratumPlace);
    const auto count = static_cast<double>(strata.size());
    std::vector<double> coordinate(strata.size());
    for (std::size_t i = 0; i < strata.size(); ++i) {
        place.point = i;
        const auto stratum = static_cast<double>(strata[i]);
        const double u = (stratum + random_uniform(place)) / count;
        // Rounding must not carry the value into the next stratum.
        coordinate[i] = std::min(u, std::nextafter((stratum + 1.0) / count, 0.0));
    }
    return coordinate;
}

std::vector<std::uint64_t> sobol_digits(std::int64_t points, std::size_t dimensions) {
    boost::random::sobol sequence(dimensions); // starts after the origin
    std::vector<std::uint64_t> digits(static_cast<std::size_t>(points) * dimensions, 0);
    for (std::size_t i = dimensions; i < digits.size(); ++i)
        digits[i] = sequence();
    return digits;
}

std::vector<double> sobol_points(std::int64_t points, std::size_t dimensions) {
    const std::vector<std::uint64_t> digits = sobol_digits(points + 1, dimensions);
    std::vector<double> coordinates(digits.size() - dimensions);
    for (std::size_t i = 0; i < coordinates.size(); ++i)
        coordinates[i] = open_unit_interval(digits[i + dimensions]);
    return coordinates;
}

double rotated(double u, const SampleKey& key) {
    // A rotation modulo 1 (Cranley & Patterson 1976) keeps the evenness of the sequence and makes
    // each point uniform. Zero is excluded: inverse distribution functions are infinite there.
    const double shifted = u + random_uniform(random_key(key, RandomPurpose::SequenceRotation));
    const double fraction = shifted - std::floor(shifted);
    return std::max(fraction, std::numeric_limits<double>::min());
}

DigitScrambler::DigitScrambler(Scrambling scrambling, const SampleKey& key, std::int64_t points)
    : key_(key), scrambling_(scrambling) {
    if (scrambling == Scrambling::None)
        return;
    // Beyond log2(points) digits no two points of the sequence share a node of the tree.
    levels_ = static_cast<int>(std::bit_width(static_cast<std::uint64_t>(points)));
    flips_.resize(std::max<std::size_t>(1, (std::size_t{1} << levels_) / 64));
    RandomKey random = random_key(key, RandomPurpose::SequenceScrambling);
    for (std::uint64_t& word : flips_) {
        word = random_bits(random);
        ++random.point;
    }
}

std::uint64_t DigitScrambler::operator()(std::uint64_t digits) const {
    if (scrambling_ == Scrambling::None)
        return digits;
    std::uint64_t flipped = digits;
    std::uint64_t node = 1;
    for (int level = 0; level < levels_; ++level) {
        const std::uint64_t digit = (digits >> (63 - level)) & 1U;
        const std::uint64_t flip = (flips_[node / 64] >> (node % 64)) & 1U;
        // The flip depends on the preceding digits of the unscrambled sequence, not on the flipped
        // ones.
        flipped ^= flip << (63 - level);
        node = 2 * node + digit;
    }
    // The following digits belong to this point alone, so all their bits are independent.
    RandomKey tail = random_key(key_, RandomPurpose::ScrambledTail);
    tail.point = node;
    return flipped ^ (random_bits(tail) >> levels_);
}

RankCorrelation::RankCorrelation(std::size_t variables, std::vector<double> rank)
    : variables_(variables), rank_(std::move(rank)) {
    const auto n = static_cast<Index>(variables);
    const MatrixXd given = Eigen::Map<const MatrixXd>(rank_.data(), n, n);
    const MatrixXd normal = normal_correlations(given, 1.0);
    const double smallest = smallest_eigenvalue(normal);
    if (!(smallest > least_eigenvalue))
        throw core::InputError(fmt::format(
            "not positive definite (smallest eigenvalue {:.2g}): no quantities can be correlated "
            "like that; the correlations times {} or less are possible",
            smallest, possible_share(given)));
    factor_ = Eigen::LLT<MatrixXd>(normal).matrixL();
}

void RankCorrelation::correlate(std::span<double> u) const {
    std::vector<double> z(variables_);
    std::ranges::transform(u, z.begin(), normal_score);
    for (std::size_t i = 1; i < variables_; ++i) {
        const auto row = factor_.row(static_cast<Index>(i)).head(static_cast<Index>(i) + 1);
        // A variable that does not depend on earlier ones keeps its coordinate bit for bit.
        if (row[row.size() - 1] == 1.0)
            continue;
        // z' = L z has the correlations L Lᵀ when the z are independent.
        u[i] = normal_share(std::inner_product(row.begin(), row.end(), z.begin(), 0.0));
    }
}

void RankCorrelation::reorder(std::vector<std::vector<double>>& columns) const {
    const auto n = static_cast<Index>(columns.front().size());
    const auto k = static_cast<Index>(variables_);
    MatrixXd scores(n, k);
    for (Index j = 0; j < k; ++j)
        for (Index i = 0; i < n; ++i)
            scores(i, j) = normal_score(columns[std::size_t(j)][std::size_t(i)]);
    const MatrixXd centred = scores.rowwise() - scores.colwise().mean();
    const MatrixXd covariance = centred.transpose() * centred / static_cast<double>(n);
    const Eigen::LLT<MatrixXd> by_chance(covariance);
    // Chance correlations of the sample are removed first if there are enough points to estimate
    // them.
    MatrixXd target = centred.transpose();
    if (by_chance.info() == Eigen::Success && n > 2 * k)
        by_chance.matrixL().solveInPlace(target);
    target = factor_ * target;
    for (std::size_t j = 0; j < variables_; ++j) {
        const Eigen::VectorXd wanted = target.row(static_cast<Index>(j));
        const auto order = order_of({wanted.data(), static_cast<std::size_t>(n)});
        // Iman & Conover: the k-th smallest value moves to the position of the k-th smallest target
        // score. Each column keeps its values, so a hypercube stays one.
        std::vector<double> sorted = columns[j];
        std::ranges::sort(sorted);
        for (std::size_t place = 0; place < order.size(); ++place)
            columns[j][order[place]] = sorted[place];
    }
}

} // namespace culm::study
