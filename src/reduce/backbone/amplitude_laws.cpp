// SPDX-License-Identifier: BSD-3-Clause
#include "reduce/backbone/amplitude_laws.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

#include <Eigen/Dense>

namespace culm::reduce {
namespace {

constexpr std::size_t fewest_windows = 5;
constexpr double least_range = 1.2;  ///< of the amplitudes
constexpr double lowest_power = 0.2; ///< below, a power is a constant
constexpr double highest_power = 3.5;
constexpr double power_step = 0.01;

struct ClassText {
    const char* name;
    const char* sentence;
};

/// In the order of AmplitudeClass.
constexpr std::array<ClassText, 6> class_texts{{
    {"linear",
     "Neither damping ratio nor frequency depends on the amplitude: losses are linear (material, "
     "still air, clamp), and masses, stiffness and clamp show in the frequency alone."},
    {"friction",
     "The damping ratio falls with the amplitude, as with dry friction in the clamp or at a "
     "cable."},
    {"drag",
     "The damping ratio grows with the amplitude and the frequency stays, as with drag of the air "
     "or a material whose loss grows with the strain."},
    {"edges or slip",
     "The damping ratio grows and the frequency falls with the amplitude, as with the air at the "
     "edges of a plate or a joint that slips."},
    {"stiffness",
     "The frequency changes with the amplitude and the damping ratio stays, as with a bending "
     "stiffness that is not constant or a large swing."},
    {"beat",
     "The amplitude does not fall steadily, as with two planes of bending, two close modes or a "
     "moving support."},
}};
static_assert(class_texts.size() == static_cast<std::size_t>(AmplitudeClass::Beat) + 1);

/// Values with standard errors at amplitudes over the largest one.
struct Points {
    std::vector<double> amplitudes;
    Eigen::VectorXd values;
    Eigen::VectorXd errors;
};

/// A law linear in its numbers for a given power: columns A⁻¹, 1 and Aᵖ, as they are present.
struct Terms {
    bool has_inverse = false;
    bool has_power = false;

    [[nodiscard]] Eigen::Index count() const {
        return 1 + (has_inverse ? 1 : 0) + (has_power ? 1 : 0);
    }
};

struct Fitted {
    Terms terms;
    double power = 1.0;
    double chi_squared = std::numeric_limits<double>::infinity();
    Eigen::VectorXd numbers;    ///< inverse, constant, power
    Eigen::MatrixXd covariance; ///< for the stated errors
    double lower_power =
        lowest_power; ///< where χ² is 4 scaled units higher; set by with_interval()
    double upper_power = highest_power;

    /// Of the constant; the inverse comes before it and the power last.
    [[nodiscard]] Eigen::Index constant() const { return terms.has_inverse ? 1 : 0; }
    [[nodiscard]] double score(double scale, std::size_t points) const {
        const auto free = static_cast<double>(terms.count() + (terms.has_power ? 1 : 0));
        return chi_squared / scale + free * std::log(static_cast<double>(points));
    }
};

/// Signs that the numbers must have: losses are not negative.
enum class Sign { Any, Positive };

Fitted fitted(const Points& points, const Terms& terms, double power, Sign sign) {
    Fitted out{terms, power, std::numeric_limits<double>::infinity(), {}, {}};
    const auto n = static_cast<Eigen::Index>(points.amplitudes.size());
    Eigen::MatrixXd columns(n, terms.count());
    for (Eigen::Index i = 0; i < n; ++i) {
        const double amplitude = points.amplitudes[static_cast<std::size_t>(i)];
        Eigen::Index k = 0;
        if (terms.has_inverse)
            columns(i, k++) = 1.0 / amplitude;
        columns(i, k++) = 1.0;
        if (terms.has_power)
            columns(i, k) = std::pow(amplitude, power);
    }
    const Eigen::VectorXd weights = points.errors.cwiseInverse();
    const Eigen::MatrixXd weighted = weights.asDiagonal() * columns;
    const Eigen::VectorXd values = weights.cwiseProduct(points.values);
    const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(weighted);
    if (qr.rank() < terms.count())
        return out;
    out.numbers = qr.solve(values);
    if (sign == Sign::Positive && !(out.numbers.minCoeff() >= 0.0) && terms.count() > 1) {
        // A law of Coulomb's or a power alone may leave a constant slightly below zero.
        if (!(out.numbers(out.constant()) < 0.0 &&
              -out.numbers(out.constant()) < 0.3 * points.values.maxCoeff()))
            return out;
        for (Eigen::Index k = 0; k < out.numbers.size(); ++k)
            if (k != out.constant() && out.numbers(k) < 0.0)
                return out;
    }
    out.chi_squared = (values - weighted * out.numbers).squaredNorm();
    out.covariance = (weighted.transpose() * weighted)
                         .ldlt()
                         .solve(Eigen::MatrixXd::Identity(terms.count(), terms.count()));
    return out;
}

Fitted best_power(const Points& points, const Terms& terms, Sign sign) {
    if (!terms.has_power)
        return fitted(points, terms, 1.0, sign);
    Fitted best;
    best.terms = terms;
    for (double power = lowest_power; power <= highest_power; power += power_step)
        if (Fitted next = fitted(points, terms, power, sign); next.chi_squared < best.chi_squared)
            best = std::move(next);
    return best;
}

/// χ² over its degrees of freedom, at least 1: the scatter about the law over the stated errors.
double scale_of(const Fitted& law, std::size_t points) {
    const auto free = static_cast<double>(law.terms.count() + (law.terms.has_power ? 1 : 0));
    return std::max(1.0, law.chi_squared / std::max(1.0, static_cast<double>(points) - free));
}

Fitted best_law(const Points& points, std::span<const Terms> candidates, Sign sign) {
    std::vector<Fitted> laws;
    for (const Terms& terms : candidates)
        laws.push_back(best_power(points, terms, sign));
    const std::size_t n = points.amplitudes.size();
    double scale = std::numeric_limits<double>::infinity();
    for (const Fitted& law : laws)
        scale = std::min(scale, scale_of(law, n));
    Fitted best = std::move(*std::ranges::min_element(
        laws, {}, [&](const Fitted& law) { return law.score(scale, n); }));
    best.covariance *= scale_of(best, n);
    if (best.terms.has_power) {
        const double limit =
            best.chi_squared + normal_quantile_95 * normal_quantile_95 * scale_of(best, n);
        const auto end = [&](double step) {
            double power = best.power;
            while (power + step >= lowest_power && power + step <= highest_power &&
                   fitted(points, best.terms, power + step, sign).chi_squared < limit)
                power += step;
            return power;
        };
        best.lower_power = end(-power_step);
        best.upper_power = end(power_step);
    }
    return best;
}

Points relative_points(std::span<const BackbonePoint> points, double reference,
                       double BackbonePoint::*value, double BackbonePoint::*error) {
    const auto n = static_cast<Eigen::Index>(points.size());
    Points out{{}, Eigen::VectorXd(n), Eigen::VectorXd(n)};
    for (Eigen::Index i = 0; i < n; ++i) {
        const BackbonePoint& point = points[static_cast<std::size_t>(i)];
        out.amplitudes.push_back(point.amplitude / reference);
        out.values[i] = point.*value;
        out.errors[i] = std::numbers::sqrt2 * std::max(point.*error, 1e-300);
    }
    return out;
}

Estimate number_of(const Fitted& law, Eigen::Index k, double unit = 1.0) {
    return normal_estimate(unit * law.numbers(k), std::abs(unit) * std::sqrt(law.covariance(k, k)));
}

Estimate exponent_of(const Fitted& law) {
    return {law.power, (law.upper_power - law.lower_power) / (2.0 * normal_quantile_95),
            law.lower_power, law.upper_power};
}

/// Does the amplitude grow in between, or does a varying damping ratio not follow the amplitude?
/// Points that are known badly do not count.
bool is_unsteady(std::span<const BackbonePoint> all) {
    constexpr double growth = 1.03;
    constexpr double well_known = 0.25; // error over the mean damping ratio
    constexpr double notable = 0.3;     // rms variation of the damping ratio over its mean
    constexpr double least_order = 0.5; // Kendall's rank correlation
    std::vector<BackbonePoint> points;
    double sum = 0.0;
    for (const BackbonePoint& point : all)
        sum += point.damping_ratio / static_cast<double>(all.size());
    for (const BackbonePoint& point : all)
        if (point.damping_error < well_known * std::abs(sum))
            points.push_back(point);
    double mean = 0.0;
    double order = 0.0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        mean += points[i].damping_ratio / static_cast<double>(points.size());
        if (i >= 2 && points[i].amplitude > growth * points[i - 2].amplitude)
            return true;
        for (std::size_t k = 0; k < i; ++k)
            order += (points[i].damping_ratio - points[k].damping_ratio) *
                                 (points[i].amplitude - points[k].amplitude) >
                             0.0
                         ? 1.0
                         : -1.0;
    }
    const auto n = static_cast<double>(points.size());
    double squares = 0.0;
    for (const BackbonePoint& point : points)
        squares += std::pow(point.damping_ratio - mean, 2) / n;
    return n > 3.0 && std::sqrt(squares) > notable * std::abs(mean) &&
           std::abs(order) < least_order * 0.5 * n * (n - 1.0);
}

} // namespace

double AmplitudeLaws::damping_at(double amplitude) const {
    const double x = amplitude / reference;
    return (coulomb ? coulomb->value / x : 0.0) + (linear ? linear->value : 0.0) +
           (power ? power->value * std::pow(x, power_exponent->value) : 0.0);
}

double AmplitudeLaws::frequency_at(double amplitude) const {
    return frequency.value *
           (1.0 - (softening ? softening->value *
                                   std::pow(amplitude / reference, softening_exponent->value)
                             : 0.0));
}

std::optional<AmplitudeLaws> amplitude_laws(std::span<const BackbonePoint> points) {
    if (points.size() < fewest_windows)
        return std::nullopt;
    const auto ends = std::ranges::minmax(points, {}, &BackbonePoint::amplitude);
    if (!(ends.max.amplitude > least_range * ends.min.amplitude))
        return std::nullopt;
    AmplitudeLaws laws;
    laws.reference = ends.max.amplitude;
    const std::vector<Terms> losses{{}, {true, false}, {false, true}, {true, true}};
    const Points ratios = relative_points(points, laws.reference, &BackbonePoint::damping_ratio,
                                          &BackbonePoint::damping_error);
    const Fitted damping = best_law(ratios, losses, Sign::Positive);
    Fitted decrement = fitted(ratios, {false, true}, 1.0, Sign::Any);
    if (damping.numbers.size() == 0 || decrement.numbers.size() == 0)
        return std::nullopt;
    decrement.covariance *= scale_of(decrement, points.size());
    laws.decrement = number_of(decrement, 0, 2.0 * std::numbers::pi);
    laws.quadratic_decrement = number_of(decrement, 1, 2.0 * std::numbers::pi);
    if (damping.terms.has_inverse)
        laws.coulomb = number_of(damping, 0);
    laws.linear = number_of(damping, damping.constant());
    if (damping.terms.has_power) {
        laws.power = number_of(damping, damping.terms.count() - 1);
        laws.power_exponent = exponent_of(damping);
    }
    const std::vector<Terms> shifts{{}, {false, true}};
    const Fitted frequency =
        best_law(relative_points(points, laws.reference, &BackbonePoint::frequency,
                                 &BackbonePoint::frequency_error),
                 shifts, Sign::Any);
    laws.frequency = number_of(frequency, 0);
    if (frequency.terms.has_power) {
        laws.softening = number_of(frequency, 1, -1.0 / frequency.numbers(0));
        laws.softening_exponent = exponent_of(frequency);
    }
    return laws;
}

std::string to_string(AmplitudeClass of) {
    return class_texts[static_cast<std::size_t>(of)].name;
}

std::string sentence(AmplitudeClass of) {
    return class_texts[static_cast<std::size_t>(of)].sentence;
}

AmplitudeClass amplitude_class(std::span<const BackbonePoint> points, const AmplitudeLaws& laws,
                               double negligible_shift) {
    if (is_unsteady(points))
        return AmplitudeClass::Beat;
    const auto ends = std::ranges::minmax(points, {}, &BackbonePoint::amplitude);
    const auto change = [&](const auto& law) {
        return law(ends.max.amplitude) - law(ends.min.amplitude);
    };
    const double damping_change =
        change([&](double amplitude) { return laws.damping_at(amplitude); });
    const double size = std::max(laws.damping_at(ends.max.amplitude), 1e-12);
    constexpr double notable = 0.12; // of the damping ratio
    const bool has_loss = (laws.coulomb || laws.power) && std::abs(damping_change) > notable * size;
    const double shift = change([&](double amplitude) { return laws.frequency_at(amplitude); }) /
                         laws.frequency.value;
    const bool has_shift = laws.softening && std::abs(shift) > negligible_shift;
    if (has_loss && damping_change < 0.0)
        return AmplitudeClass::Friction;
    if (has_loss)
        return has_shift && shift < 0.0 ? AmplitudeClass::EdgesSlip : AmplitudeClass::Drag;
    return has_shift ? AmplitudeClass::Stiffness : AmplitudeClass::Linear;
}

} // namespace culm::reduce
