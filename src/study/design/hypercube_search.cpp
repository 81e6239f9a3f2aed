// SPDX-License-Identifier: BSD-3-Clause
#include "study/design/hypercube_search.hpp"

#include "study/design/sampling.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

namespace culm::study {

namespace {

using Point = std::span<const double>;

/// Criteria are Σ_i single(i) + Σ_{i<j} pair(i, j) with points in strata. They use only sums,
/// products and quotients, so every decision is bitwise the same on every processor.
struct MaximinTerms {
    double points;

    static double single(Point) { return 0.0; }
    [[nodiscard]] double pair(Point a, Point b) const {
        double square = 0.0;
        for (std::size_t c = 0; c < a.size(); ++c)
            square += (a[c] - b[c]) * (a[c] - b[c]);
        // (n²/d²)⁸ = (n/d)¹⁶: p = 16 without a root or a power function. The large power makes the
        // sum follow the nearest pair.
        const double closeness = points * points / square;
        const double second = closeness * closeness;
        const double fourth = second * second;
        return fourth * fourth;
    }
};

struct DiscrepancyTerms {
    double points;

    [[nodiscard]] double offset(double stratum) const { return (stratum + 0.5) / points - 0.5; }
    [[nodiscard]] double single(Point a) const {
        double once = 1.0;
        double twice = 1.0;
        for (const double stratum : a) {
            const double z = std::abs(offset(stratum));
            once *= 1.0 + 0.5 * z - 0.5 * z * z;
            twice *= 1.0 + z;
        }
        // Terms of the diagonal of Hickernell's double sum: |z − z| is zero there.
        return -2.0 / points * once + twice / (points * points);
    }
    [[nodiscard]] double pair(Point a, Point b) const {
        double product = 1.0;
        for (std::size_t c = 0; c < a.size(); ++c)
            product *= 1.0 + 0.5 * std::abs(offset(a[c])) + 0.5 * std::abs(offset(b[c])) -
                       0.5 * std::abs(a[c] - b[c]) / points;
        return 2.0 / (points * points) * product;
    }
};

/// Points in strata, row by row.
class Table {
  public:
    explicit Table(const Strata& strata)
        : width_(strata.size()), values_(width_ * strata.front().size()) {
        for (std::size_t c = 0; c < width_; ++c)
            for (std::size_t i = 0; i < strata[c].size(); ++i)
                values_[i * width_ + c] = static_cast<double>(strata[c][i]);
    }
    [[nodiscard]] std::size_t points() const { return values_.size() / width_; }
    [[nodiscard]] Point point(std::size_t i) const {
        return std::span(values_).subspan(i * width_, width_);
    }
    void exchange(std::size_t i, std::size_t k, std::size_t c) {
        std::swap(values_[i * width_ + c], values_[k * width_ + c]);
    }

  private:
    std::size_t width_;
    std::vector<double> values_;
};

/// The criterion's terms that contain point i or k.
template <class Terms>
double terms_of(const Table& table, const Terms& terms, std::size_t i, std::size_t k) {
    const Point a = table.point(i);
    const Point b = table.point(k);
    double sum = terms.single(a) + terms.single(b) + terms.pair(a, b);
    for (std::size_t j = 0; j < table.points(); ++j)
        if (j != i && j != k)
            sum += terms.pair(a, table.point(j)) + terms.pair(b, table.point(j));
    return sum;
}

struct Exchange {
    std::size_t first;
    std::size_t second;
    std::size_t coordinate;
};

template <class Terms>
void search(Strata& strata, const std::vector<std::size_t>& movable, const Terms& terms,
            const SampleKey& key) {
    Table table(strata);
    const std::uint64_t points = table.points();
    RandomKey place = random_key(key, RandomPurpose::HypercubeSearch);
    const auto drawn = [&](std::uint64_t step) {
        const auto below = [&](std::uint64_t part, std::uint64_t bound) {
            place.point = 3 * step + part;
            return random_below(bound, random_bits(place));
        };
        const std::size_t first = below(0, points);
        // The second point is drawn from the other points.
        return Exchange{first, (first + 1 + below(1, points - 1)) % points,
                        movable[below(2, movable.size())]};
    };
    /// Makes the exchange and returns the change of the criterion.
    const auto change_by = [&](const Exchange& e) {
        const double before = terms_of(table, terms, e.first, e.second);
        table.exchange(e.first, e.second, e.coordinate);
        return terms_of(table, terms, e.first, e.second) - before;
    };
    const double size = static_cast<double>(points) * static_cast<double>(strata.size());
    constexpr double most_work = 2.5e8; // numbers that are read: about a second
    const auto exchanges =
        static_cast<std::uint64_t>(std::max(1.0, std::min(100.0 * size, most_work / size)));
    // The initial threshold is the smallest change among a few exchanges: it does not undo the
    // search and needs no constant in the unit of the criterion.
    double threshold = std::numeric_limits<double>::infinity();
    constexpr std::uint64_t trials = 64;
    for (std::uint64_t step = 0; step < trials; ++step) {
        const Exchange e = drawn(exchanges + step);
        threshold = std::min(threshold, std::abs(change_by(e)));
        table.exchange(e.first, e.second, e.coordinate);
    }
    for (std::uint64_t step = 0; step < exchanges; ++step) {
        const Exchange e = drawn(step);
        const double progress = static_cast<double>(step) / static_cast<double>(exchanges);
        // change_by() makes the exchange in the table: a rejected one is undone there, an accepted
        // one is made in the strata too.
        if (change_by(e) > threshold * std::max(0.0, 1.0 - 2.0 * progress))
            table.exchange(e.first, e.second, e.coordinate);
        else
            std::swap(strata[e.coordinate][e.first], strata[e.coordinate][e.second]);
    }
}

} // namespace

void spread_evenly(Strata& strata, const std::vector<bool>& is_movable,
                   HypercubeCriterion criterion, const SampleKey& key) {
    std::vector<std::size_t> movable;
    for (std::size_t c = 0; c < strata.size(); ++c)
        if (is_movable[c])
            movable.push_back(c);
    if (movable.empty() || strata.size() < 2 || strata.front().size() < 3)
        return;
    const auto points = static_cast<double>(strata.front().size());
    if (criterion == HypercubeCriterion::Maximin)
        search(strata, movable, MaximinTerms{points}, key);
    else if (criterion == HypercubeCriterion::CentredDiscrepancy)
        search(strata, movable, DiscrepancyTerms{points}, key);
}

} // namespace culm::study
