// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/missing_force/term_selection.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include <Eigen/QR>

namespace culm::diagnose {
namespace {

/// Stability selection (Meinshausen & Bühlmann 2010): a term counts if most random halves of the
/// blocks also select it.
constexpr int resamples = 50;
constexpr double least_stability = 0.8;
constexpr std::uint64_t seed = 2019;
/// Smallest reduction of the squared residual, as a share, by a term that is not only noise.
constexpr double least_fall = 0.02;

/// Sums of products over the blocks. Every regression on a subset of blocks follows from them.
class BlockSums {
  public:
    BlockSums(const Eigen::MatrixXd& columns, const Eigen::VectorXd& residual,
              const std::vector<int>& block) {
        const int count = block.empty() ? 0 : 1 + *std::ranges::max_element(block);
        const Eigen::Index terms = columns.cols();
        products_.assign(static_cast<std::size_t>(count), Eigen::MatrixXd::Zero(terms, terms));
        with_residual_.assign(products_.size(), Eigen::VectorXd::Zero(terms));
        squares_.assign(products_.size(), 0.0);
        for (Eigen::Index i = 0; i < residual.size(); ++i) {
            const auto b = static_cast<std::size_t>(block[static_cast<std::size_t>(i)]);
            products_[b] += columns.row(i).transpose() * columns.row(i);
            with_residual_[b] += columns.row(i).transpose() * residual(i);
            squares_[b] += residual(i) * residual(i);
        }
    }
    [[nodiscard]] std::size_t count() const { return products_.size(); }

    /// Coefficients of these terms, fitted to the readings of these blocks.
    [[nodiscard]] Eigen::VectorXd regress(const std::vector<std::size_t>& terms,
                                          const std::vector<std::size_t>& blocks) const {
        if (terms.empty())
            return {};
        const std::vector<Eigen::Index> chosen(terms.begin(), terms.end());
        const auto size = static_cast<Eigen::Index>(terms.size());
        Eigen::MatrixXd products = Eigen::MatrixXd::Zero(size, size);
        Eigen::VectorXd right = Eigen::VectorXd::Zero(size);
        for (const std::size_t b : blocks) {
            products += products_[b](chosen, chosen);
            right += with_residual_[b](chosen);
        }
        return products.completeOrthogonalDecomposition().solve(right);
    }
    /// Squared residual of these terms in these blocks.
    [[nodiscard]] double left(const std::vector<std::size_t>& terms,
                              const Eigen::VectorXd& coefficients,
                              const std::vector<std::size_t>& blocks) const {
        const std::vector<Eigen::Index> chosen(terms.begin(), terms.end());
        double sum = 0.0;
        for (const std::size_t b : blocks)
            sum += terms.empty()
                       ? squares_[b]
                       : squares_[b] - 2.0 * coefficients.dot(with_residual_[b](chosen)) +
                             coefficients.dot(products_[b](chosen, chosen) * coefficients);
        return sum;
    }
    /// Terms in the order in which they reduce the residual most.
    [[nodiscard]] std::vector<std::size_t> forward(const std::vector<std::size_t>& blocks,
                                                   std::size_t most) const {
        std::vector<std::size_t> chosen;
        std::vector<std::size_t> rest(static_cast<std::size_t>(products_.front().cols()));
        std::iota(rest.begin(), rest.end(), 0);
        while (chosen.size() < most && !rest.empty()) {
            std::vector<double> remains;
            for (const std::size_t k : rest) {
                std::vector<std::size_t> with = chosen;
                with.push_back(k);
                remains.push_back(left(with, regress(with, blocks), blocks));
            }
            const auto best = rest.begin() + (std::ranges::min_element(remains) - remains.begin());
            chosen.push_back(*best);
            rest.erase(best);
        }
        return chosen;
    }

  private:
    std::vector<Eigen::MatrixXd> products_;
    std::vector<Eigen::VectorXd> with_residual_;
    std::vector<double> squares_;
};

std::vector<std::size_t> all_blocks(const BlockSums& sums) {
    std::vector<std::size_t> blocks(sums.count());
    std::iota(blocks.begin(), blocks.end(), 0);
    return blocks;
}

/// Squared residual in blocks that were left out, by the number of terms, and the standard error of
/// the smallest.
struct Validation {
    std::vector<double> left;
    double standard_error = 0.0;
};

/// Leave-one-block-out cross-validation. It leaves out blocks, not single readings, because
/// neighbouring residuals are similar.
Validation validate(const BlockSums& sums, std::size_t most) {
    const std::vector<std::size_t> all = all_blocks(sums);
    std::vector<std::vector<double>> by_block(most + 1);
    for (const std::size_t out : all) {
        std::vector<std::size_t> rest = all;
        std::erase(rest, out);
        const std::vector<std::size_t> order = sums.forward(rest, most);
        for (std::size_t count = 0; count <= most; ++count) {
            const std::vector<std::size_t> terms(
                order.begin(),
                order.begin() + static_cast<std::ptrdiff_t>(std::min(count, order.size())));
            by_block[count].push_back(sums.left(terms, sums.regress(terms, rest), {out}));
        }
    }
    Validation out;
    for (const std::vector<double>& squares : by_block)
        out.left.push_back(std::accumulate(squares.begin(), squares.end(), 0.0));
    const auto best =
        static_cast<std::size_t>(std::ranges::min_element(out.left) - out.left.begin());
    const auto count = static_cast<double>(all.size());
    const double mean = out.left[best] / count;
    double scatter = 0.0;
    for (const double square : by_block[best])
        scatter += (square - mean) * (square - mean);
    out.standard_error = std::sqrt(scatter * count / std::max(count - 1.0, 1.0));
    return out;
}

std::vector<double> stabilities(const BlockSums& sums, const std::vector<std::size_t>& terms) {
    std::mt19937_64 engine(seed);
    std::vector<double> counts(terms.size(), 0.0);
    std::vector<std::size_t> blocks = all_blocks(sums);
    for (int sample = 0; sample < resamples; ++sample) {
        for (std::size_t k = blocks.size(); k > 1; --k) // Fisher and Yates, the same everywhere
            std::swap(blocks[k - 1], blocks[engine() % k]);
        const std::vector<std::size_t> half(
            blocks.begin(), blocks.begin() + static_cast<std::ptrdiff_t>((blocks.size() + 1) / 2));
        const std::vector<std::size_t> chosen = sums.forward(half, terms.size());
        for (std::size_t k = 0; k < terms.size(); ++k)
            if (std::ranges::find(chosen, terms[k]) != chosen.end())
                counts[k] += 1.0 / resamples;
    }
    return counts;
}

} // namespace

SelectedTerms select_terms(const Eigen::MatrixXd& columns, const Eigen::VectorXd& residual,
                           const std::vector<int>& block, std::size_t most) {
    SelectedTerms out;
    const double total = residual.squaredNorm();
    out.left = out.validation = 1.0;
    if (columns.cols() == 0 || !(total > 0.0))
        return out;
    const BlockSums sums(columns, residual, block);
    const Validation validation = validate(sums, most);
    const double best = *std::ranges::min_element(validation.left);
    // The smallest number of terms within one standard error of the best (Breiman et al. 1984).
    std::size_t count = 0;
    while (count < most && validation.left[count] > best + validation.standard_error)
        ++count;
    const std::vector<std::size_t> all = all_blocks(sums);
    std::vector<std::size_t> terms = sums.forward(all, count);
    const std::vector<double> stability = stabilities(sums, terms);
    double before = total;
    for (std::size_t k = 0; k < terms.size(); ++k) {
        std::vector<std::size_t> with = out.columns;
        with.push_back(terms[k]);
        const double remains = sums.left(with, sums.regress(with, all), all);
        if (stability[k] < least_stability || remains > (1.0 - least_fall) * before)
            continue;
        before = remains;
        out.columns = std::move(with);
        out.stability.push_back(stability[k]);
    }
    out.coefficients = sums.regress(out.columns, all);
    out.left = before / total;
    out.validation = validation.left[count] / total;
    return out;
}

} // namespace culm::diagnose
