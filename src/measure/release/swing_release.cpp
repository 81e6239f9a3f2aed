// SPDX-License-Identifier: BSD-3-Clause
#include "measure/release/swing_release.hpp"

#include "core/error.hpp"
#include "core/order_statistics.hpp"
#include "measure/release/release_curve.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/Dense>

namespace culm::measure {

namespace {
constexpr double pi = std::numbers::pi;
constexpr double infinity = std::numeric_limits<double>::infinity();
/// Share of the period by which t₀ of a stem differs from that of a uniform beam.
constexpr double least_share = 0.002;

/// A history without gaps.
struct Readings {
    std::vector<double> times;
    std::vector<double> values;

    Readings(std::span<const double> all_times, std::span<const double> all_values) {
        for (std::size_t i = 0; i < all_times.size(); ++i)
            if (!std::isnan(all_values[i])) {
                times.push_back(all_times[i]);
                values.push_back(all_values[i]);
            }
    }
    [[nodiscard]] std::size_t size() const { return times.size(); }
    /// Index of the first reading that is not before a time.
    [[nodiscard]] std::size_t at(double time) const {
        return std::size_t(std::ranges::lower_bound(times, time) - times.begin());
    }
};

/// Standard deviation of a reading, from second differences, which a resolved motion hardly
/// changes. The quietest tenth of the record counts: a coarsely sampled swing is not noise.
double noise_of(const Readings& readings) {
    constexpr std::size_t windows = 10;
    const std::size_t width = std::max<std::size_t>(8, readings.size() / windows);
    double quietest = infinity;
    for (std::size_t begin = 0; begin + width <= readings.size(); begin += width) {
        std::vector<double> differences;
        for (std::size_t i = begin + 2; i < begin + width; ++i)
            differences.push_back(readings.values[i] - 2.0 * readings.values[i - 1] +
                                  readings.values[i - 2]);
        quietest = std::min(quietest, core::robust_deviation(differences) / std::sqrt(6.0));
    }
    return std::isfinite(quietest) ? quietest : 0.0;
}

/// The middle between the largest and the smallest of the readings from an index on, less outliers.
double middle_of(const Readings& readings, std::size_t begin) {
    const std::vector<double> late(readings.values.begin() + std::ptrdiff_t(begin),
                                   readings.values.end());
    return 0.5 * (core::quantile(late, 0.02) + core::quantile(late, 0.98));
}

/// Passages through `rest`; a side counts once the position is further away than `least`.
std::vector<double> passages(const Readings& readings, double rest, double least) {
    std::vector<double> found;
    double side = 0.0;
    std::size_t last_on_side = 0;
    for (std::size_t i = 0; i < readings.size(); ++i) {
        const double away = readings.values[i] - rest;
        if (std::abs(away) <= least)
            continue;
        const double now = away > 0.0 ? 1.0 : -1.0;
        if (side * now < 0.0) {
            const double before = std::abs(readings.values[last_on_side] - rest);
            const double share = before / (before + std::abs(away));
            found.push_back(readings.times[last_on_side] +
                            share * (readings.times[i] - readings.times[last_on_side]));
        }
        side = now;
        last_on_side = i;
    }
    return found;
}

/// Where the stem was held: between two passages, of which the second is that of the first swing.
struct Hold {
    double begin = 0.0; ///< of the time on the held side
    double period = 0.0;
    double decay_per_cycle = 0.0; ///< of the amplitude, logarithmic
    std::vector<double> swings{}; ///< passages through the final position after the release
};

/// Largest distance from `rest` between two times.
double amplitude_between(const Readings& readings, double begin, double end, double rest) {
    double largest = 0.0;
    for (std::size_t i = readings.at(begin); i < readings.at(end); ++i)
        largest = std::max(largest, std::abs(readings.values[i] - rest));
    return largest;
}

/// Logarithmic decrement over the swings between passages; the first still contains other modes.
double decay_of(const Readings& readings, std::span<const double> passed, double rest) {
    if (passed.size() < 4)
        return 0.0;
    const std::size_t last = passed.size() - 1;
    const double first = amplitude_between(readings, passed[1], passed[2], rest);
    const double end = amplitude_between(readings, passed[last - 1], passed[last], rest);
    const double cycles = 0.5 * double(last - 2);
    return first > 0.0 && end > 0.0 && cycles > 0.0
               ? std::clamp(std::log(first / end) / cycles, 0.0, 3.0)
               : 0.0;
}

/// Longest time between two readings of an interval.
double longest_gap(const Readings& readings, double begin, double end) {
    double longest = 0.0;
    for (std::size_t i = readings.at(begin) + 1; i <= readings.at(end) && i < readings.size(); ++i)
        longest = std::max(longest, readings.times[i] - readings.times[i - 1]);
    return longest;
}

/// The passages from the i-th on, seven at most: those of the first swings.
std::span<const double> first_passages(std::span<const double> passed, std::size_t i) {
    return passed.subspan(i, std::min<std::size_t>(7, passed.size() - i));
}

/// The interval before the passage i, of two or more.
Hold hold_before(const Readings& readings, const std::vector<double>& passed, std::size_t i,
                 double rest) {
    const std::span<const double> first = first_passages(passed, i);
    const double begin = i == 0 ? readings.times.front() : passed[i - 1];
    const std::vector<double> swings(passed.begin() + std::ptrdiff_t(i), passed.end());
    return {begin, mean_period(first), decay_of(readings, first, rest), swings};
}

/// Index of the passage that ends the hold: the first after the last held reading or, if that is
/// not known, the last that comes more than half a period after the one before. Passages are not
/// seen in gaps, and not of swings that hardly exceed `least`, the distance from which a side
/// counts.
std::optional<std::size_t> end_of_hold(const Readings& readings, const std::vector<double>& passed,
                                       double rest, double least, std::optional<double> last_held) {
    constexpr double longer = 1.3; // than half a period; a beat changes it by less
    if (last_held) {
        const auto after =
            std::size_t(std::ranges::upper_bound(passed, *last_held) - passed.begin());
        return after + 2 <= passed.size() ? std::optional(after) : std::nullopt;
    }
    for (std::size_t i = std::max<std::size_t>(1, passed.size()) - 1; i-- > 0;) {
        const double half = 0.5 * mean_period(first_passages(passed, i));
        if (i == 0 || (passed[i] - passed[i - 1] > longer * half &&
                       longest_gap(readings, passed[i - 1], passed[i]) < 0.5 * half &&
                       amplitude_between(readings, passed[i - 1], passed[i], rest) > 3.0 * least))
            return i;
    }
    return std::nullopt;
}

/// A curve of the motion after a release, from the time at which the hand begins to open.
struct Candidate {
    double opening = 0.0; ///< duration
    double step = 0.0;    ///< of time between the values
    std::vector<double> values{};

    /// Deflection over the held one at a time ≥ 0.
    [[nodiscard]] double at(double time) const {
        const double position = time / step;
        const auto k = std::min(std::size_t(position), values.size() - 2);
        return values[k] + (position - double(k)) * (values[k + 1] - values[k]);
    }
};

/// That of a cantilever that is let go at once, or one damped mode that starts at rest.
Candidate sudden_release(const ReleaseCurve& curve, bool is_beam) {
    constexpr int points = 2000;
    Candidate sudden{.step = 0.45 * curve.period / points};
    const double decay = curve.decay_per_cycle;
    for (int k = 0; k <= points; ++k) {
        const double t = k * sudden.step;
        const double angle = 2.0 * pi * t / curve.period;
        const double one_mode = std::exp(-decay * t / curve.period) *
                                (std::cos(angle) + decay / (2.0 * pi) * std::sin(angle));
        sudden.values.push_back(is_beam ? curve.at(t) : one_mode);
    }
    return sudden;
}

/// The mean of a curve over releases within the opening.
Candidate opened(const Candidate& sudden, double opening) {
    if (opening == 0.0)
        return sudden;
    Candidate integral{.step = sudden.step, .values = {0.0}};
    for (std::size_t k = 1; k < sudden.values.size(); ++k)
        integral.values.push_back(integral.values.back() +
                                  0.5 * sudden.step * (sudden.values[k - 1] + sudden.values[k]));
    Candidate result{.opening = opening, .step = sudden.step};
    for (std::size_t k = 0; k < sudden.values.size(); ++k) {
        const double begin = double(k) * sudden.step - opening;
        const double held = std::max(0.0, -begin); // before the release the curve is 1
        result.values.push_back((integral.values[k] - integral.at(std::max(0.0, begin)) + held) /
                                opening);
    }
    return result;
}

class HeldFit {
  public:
    /// `last_held`: the index of the last reading before the release, if it is known.
    HeldFit(const Readings& readings, const Hold& hold, double rest, double relative_height,
            std::optional<std::size_t> last_held)
        : readings_(readings),
          rest_(rest), curve_{relative_height, hold.period, hold.decay_per_cycle},
          passage_(hold.swings.front()), begin_(std::max(hold.begin, passage_ - 1.5 * hold.period)),
          last_held_(last_held) {}

    [[nodiscard]] const ReleaseCurve& curve() const { return curve_; }

    struct Fit {
        double time = 0.0;
        double squares = infinity;
        double held = 0.0;
        std::size_t held_count = 0;
        std::size_t count = 0;
    };

    /// Least squares over the line and the time of the release.
    [[nodiscard]] Fit best(const Candidate& candidate) const {
        const double period = curve_.period;
        const double guess = passage_ - curve_.first_passage() - 0.5 * candidate.opening;
        const double earliest =
            last_held_ ? readings_.times[*last_held_] : std::max(guess - 0.2 * period, begin_);
        const double latest = last_held_ ? readings_.times[*last_held_ + 1] : guess + 0.15 * period;
        double low = earliest;
        double high = latest;
        constexpr int steps = 40;
        Fit best;
        for (int round = 0; round < 4; ++round) {
            best = {};
            for (int k = 0; k <= steps; ++k)
                if (const Fit fit = at(low + (high - low) * k / steps, candidate);
                    fit.squares < best.squares)
                    best = fit;
            const double step = (high - low) / steps;
            low = std::max(earliest, best.time - step);
            high = std::min(latest, best.time + step);
        }
        return best;
    }

    /// The line for a time of release, and the sum of the squared residuals per reading.
    [[nodiscard]] Fit at(double time, const Candidate& candidate) const {
        const double period = curve_.period;
        // A window of fixed ends, so that sums of different times can be compared.
        const std::size_t begin = std::min(
            readings_.at(begin_ + (begin_ > readings_.times.front() ? 0.25 * period : 0.0)),
            last_held_.value_or(readings_.size()));
        const std::size_t end =
            std::min(readings_.at(passage_ - 0.08 * period) + 1, readings_.size());
        const std::size_t stride = std::max<std::size_t>(1, (end - std::min(begin, end)) / 3000);
        Eigen::Matrix2d normal = Eigen::Matrix2d::Zero();
        Eigen::Vector2d right = Eigen::Vector2d::Zero();
        double total = 0.0;
        Fit fit{.time = time};
        for (std::size_t i = begin; i < end; i += stride) {
            const double since = readings_.times[i] - time;
            const Eigen::Vector2d basis = since < 0.0 ? Eigen::Vector2d(1.0, since / period)
                                                      : Eigen::Vector2d(candidate.at(since), 0.0);
            const double value = readings_.values[i] - rest_;
            normal += basis * basis.transpose();
            right += basis * value;
            total += value * value;
            fit.held_count += since < 0.0 ? stride : 0;
            fit.count += 1;
        }
        // Few held readings determine a level, but no line.
        if (fit.held_count < 6) {
            normal(0, 1) = normal(1, 0) = right(1) = 0.0;
            normal(1, 1) = 1.0;
        }
        const Eigen::Vector2d line = normal.ldlt().solve(right);
        fit.held = rest_ + line[0];
        fit.squares = std::max(0.0, total - line.dot(right));
        return fit;
    }

  private:
    const Readings& readings_;
    double rest_;
    ReleaseCurve curve_;
    double passage_;
    double begin_;
    std::optional<std::size_t> last_held_;
};

/// The variance of t₀ from the curvature of the sum of squares.
double variance_of_time(const HeldFit& fitted, const HeldFit::Fit& fit, const Candidate& candidate,
                        double period, double variance) {
    const double step = 0.01 * period;
    const double curvature = (fitted.at(fit.time - step, candidate).squares - 2.0 * fit.squares +
                              fitted.at(fit.time + step, candidate).squares) /
                             (step * step);
    return curvature > 0.0 ? 2.0 * variance / curvature : period * period;
}

/// The mean over the candidates, each weighted by its likelihood.
SwingRelease averaged(const HeldFit& fitted, double period, double noise) {
    constexpr std::array openings{0.0, 0.005, 0.01, 0.02, 0.03, 0.05, 0.07, 0.1, 0.14, 0.2};
    std::vector<Candidate> candidates;
    for (const bool is_beam : {true, false}) {
        const Candidate sudden = sudden_release(fitted.curve(), is_beam);
        for (const double opening : openings)
            candidates.push_back(opened(sudden, opening * period));
    }
    std::vector<HeldFit::Fit> fits;
    for (const Candidate& candidate : candidates)
        fits.push_back(fitted.best(candidate));
    const auto best = std::ranges::min_element(fits, {}, &HeldFit::Fit::squares);
    const double freedom = std::max(1.0, double(best->count) - 3.0);
    // A misfit beyond the noise is a smooth curve with some eight independent values.
    const double white = noise * noise;
    const double misfit = std::max(0.0, best->squares / freedom - white);
    const double variance = white + misfit * std::max(1.0, freedom / 8.0);
    SwingRelease release{.held = best->held,
                         .noise = std::sqrt(white + misfit),
                         .held_count = best->held_count,
                         .period = period};
    double sum = 0.0;
    double mean = 0.0;
    double square = 0.0;
    for (std::size_t k = 0; k < fits.size(); ++k) {
        const double weight = variance > 0.0
                                  ? std::exp(-0.5 * (fits[k].squares - best->squares) / variance)
                                  : (&fits[k] == &*best ? 1.0 : 0.0);
        const double opening = candidates[k].opening;
        const double time = fits[k].time + 0.5 * opening;
        sum += weight;
        mean += weight * time;
        square += weight * (time * time + opening * opening / 6.0 +
                            variance_of_time(fitted, fits[k], candidates[k], period, variance));
    }
    release.time = mean / sum;
    release.uncertainty = std::hypot(
        least_share * period, std::sqrt(std::max(0.0, square / sum - release.time * release.time)));
    return release;
}

/// The first reading of those before the release that are within a distance of the held position.
double begin_of_hold(const Readings& readings, const SwingRelease& release, double distance) {
    std::size_t first = readings.at(release.time);
    while (first > 0 && std::abs(readings.values[first - 1] - release.held) <= distance)
        --first;
    return readings.times[std::min(first, readings.size() - 1)];
}

/// One sine and a constant; its amplitude is exp(−αt) times a straight line.
struct SineFit {
    double centre = 0.0;
    double squares = 0.0;
};

SineFit fit_sine(const Readings& readings, std::size_t begin, double angular_frequency,
                 double decay) {
    const double reference = readings.times[begin];
    const double span = readings.times.back() - reference;
    Eigen::Matrix<double, 5, 5> normal = Eigen::Matrix<double, 5, 5>::Zero();
    Eigen::Matrix<double, 5, 1> right = Eigen::Matrix<double, 5, 1>::Zero();
    double total = 0.0;
    const double level = readings.values[begin];
    const std::size_t stride = std::max<std::size_t>(1, (readings.size() - begin) / 20000);
    for (std::size_t i = begin; i < readings.size(); i += stride) {
        const double t = readings.times[i] - reference;
        const double envelope = std::exp(-decay * t);
        const double cosine = envelope * std::cos(angular_frequency * t);
        const double sine = envelope * std::sin(angular_frequency * t);
        const Eigen::Matrix<double, 5, 1> basis{1.0, cosine, sine, t / span * cosine,
                                                t / span * sine};
        const double value = readings.values[i] - level;
        normal += basis * basis.transpose();
        right += basis * value;
        total += value * value;
    }
    const Eigen::Matrix<double, 5, 1> solution = normal.ldlt().solve(right);
    return {level + solution[0], std::max(0.0, total - solution.dot(right))};
}

/// The best of frequencies about that of the period.
SineFit best_sine(const Readings& readings, std::size_t begin, double period, double decay) {
    SineFit best{0.0, infinity};
    for (double factor = 0.9; factor < 1.1; factor += 0.004)
        if (const SineFit fit = fit_sine(readings, begin, 2.0 * pi * factor / period, decay);
            fit.squares < best.squares)
            best = fit;
    return best;
}

} // namespace

double mean_period(std::span<const double> passages) {
    return 2.0 * (passages.back() - passages.front()) / double(passages.size() - 1);
}

double centre_of_swing(std::span<const double> times, std::span<const double> positions,
                       double begin, double expected_period) {
    const Readings readings(times, positions);
    if (readings.size() == 0)
        return std::numeric_limits<double>::quiet_NaN();
    const std::size_t first = std::min(readings.at(begin), readings.size() - 1);
    const std::size_t count = readings.size() - first;
    const double noise = noise_of(readings);
    double level = 0.0;
    std::vector<double> passed;
    std::size_t quarter = first;
    // The last part is nearest to the rest, but a short record needs all of its few swings.
    for (const std::size_t part : {count / 4, count / 2, count}) {
        quarter = readings.size() - std::max(part, std::min<std::size_t>(count, 12));
        level = middle_of(readings, quarter);
        double widest = 0.0;
        double mean = 0.0;
        for (std::size_t i = quarter; i < readings.size(); ++i) {
            widest = std::max(widest, std::abs(readings.values[i] - level));
            mean += readings.values[i] / double(readings.size() - quarter);
        }
        // At rest the readings of a few hundred frames are within five standard deviations.
        if (count < 12 || widest < 5.0 * noise)
            return mean;
        passed = passages(readings, level, std::max(3.0 * noise, 0.2 * widest));
        std::erase_if(passed, [&](double time) { return time < readings.times[quarter]; });
        if (passed.size() >= 4)
            break;
    }
    const std::vector<double> last(passed.end() - std::min<std::ptrdiff_t>(9, std::ssize(passed)),
                                   passed.end());
    const double period = last.size() > 2 || (last.size() == 2 && expected_period == 0.0)
                              ? mean_period(last)
                              : expected_period;
    if (period == 0.0)
        return level;
    const std::size_t from =
        std::max(first, std::min(quarter, readings.at(readings.times.back() - 6.0 * period)));
    return best_sine(readings, from, period, decay_of(readings, last, level) / period).centre;
}

double scatter_about_swing(std::span<const double> times, std::span<const double> positions,
                           double begin, double period, double decay_per_cycle) {
    const Readings readings(times, positions);
    if (readings.size() == 0)
        return std::numeric_limits<double>::quiet_NaN();
    const std::size_t from =
        std::max(readings.at(begin), readings.at(readings.times.back() - 3.0 * period));
    const double count = double(readings.size()) - double(from);
    return count < 12.0
               ? std::numeric_limits<double>::quiet_NaN()
               : std::sqrt(best_sine(readings, from, period, decay_per_cycle / period).squares /
                           (count - 6.0));
}

SwingRelease find_swing_release(std::span<const double> times, std::span<const double> positions,
                                double relative_height, std::optional<double> last_held) {
    const Readings readings(times, positions);
    if (readings.size() < 12)
        throw core::InputError("fewer than 12 readings are left, so no release can be found");
    const double noise = noise_of(readings);
    double rest = middle_of(readings, readings.size() / 2);
    const double widest = amplitude_between(readings, -infinity, infinity, rest);
    Hold hold;
    for (int round = 0; round < 2; ++round) { // the centre needs the time of the release
        const double least = std::max(5.0 * noise, 0.05 * widest);
        const std::vector<double> passed = passages(readings, rest, least);
        const auto end = end_of_hold(readings, passed, rest, least, last_held);
        if (!end)
            throw core::InputError(
                "no release was found: the stem is not held away from its final position, or does "
                "not swing through it twice afterwards");
        hold = hold_before(readings, passed, *end, rest);
        rest = centre_of_swing(times, positions, hold.swings.front(), hold.period);
    }
    std::optional<std::size_t> held_index;
    if (last_held)
        held_index =
            std::max<std::size_t>(1, readings.at(std::nextafter(*last_held, infinity))) - 1;
    const HeldFit fitted(readings, hold, rest, relative_height, held_index);
    SwingRelease release = averaged(fitted, hold.period, noise);
    release.rest = rest;
    release.decay_per_cycle = hold.decay_per_cycle;
    release.passages = hold.swings;
    // A turning point in place of a hold is short and no straight line.
    const double pull = std::abs(release.held - rest);
    const double still = release.time - std::max(hold.begin, readings.times.front());
    const bool is_line = release.noise <= std::max(0.01 * pull, std::min(1.5 * noise, 0.03 * pull));
    release.held_begin =
        begin_of_hold(readings, release, std::max(5.0 * release.noise, 0.01 * pull));
    if (!last_held && (release.held_count < 2 || still < 0.05 * hold.period ||
                       (still < 0.35 * hold.period && !is_line) || pull < 5.0 * release.noise))
        throw core::InputError("no release was found: the record begins in the middle of a swing");
    return release;
}

} // namespace culm::measure
