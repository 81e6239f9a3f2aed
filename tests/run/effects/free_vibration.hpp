// SPDX-License-Identifier: BSD-3-Clause
// Simulates a stem with effects and measures its turning points, frequency and spectrum.
#pragma once

#include "physics/effects/library.hpp"
#include "physics/effects/selection.hpp"
#include "physics/effects/stem_scales.hpp"
#include "run/simulate.hpp"

#include <cmath>
#include <complex>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

namespace culm::run {

inline constexpr double pi = std::numbers::pi;

inline physics::ActiveEffect active(const std::string& name, std::vector<double> values) {
    return {physics::effect_named(name), std::move(values)};
}

/// A soft stem of eight bonds, so that an explicit integrator needs few steps; the consistent law,
/// without damping.
inline CaseSpec coarse_stem() {
    CaseSpec spec;
    physics::StemParameters<double>& stem = spec.stem;
    stem.sphere_count = 9;
    stem.bond_length = 0.15565 / 8.0;
    stem.sphere_diameter = stem.bond_length;
    stem.density = 5.24e-4 * stem.bond_length / (pi / 6.0 * std::pow(stem.sphere_diameter, 3));
    stem.bond_youngs_modulus = 1e8;
    stem.tip_mass_share = 0.5;
    spec.law = physics::consistent_law();
    return spec;
}

/// A stem so slender that it is an Euler-Bernoulli beam to 1e-5 (shear, rotatory inertia). Its
/// spheres are equal except for half a sphere at its end; the error of the chain is of second order
/// in 1/56. First frequency 1.77 Hz; damped by ζ = 0.5 % in mode 1 and more in the others.
inline CaseSpec slender_case() {
    CaseSpec spec;
    physics::StemParameters<double>& stem = spec.stem;
    stem.sphere_count = 57;
    stem.bond_length = 0.15565 / 56.0;
    stem.sphere_diameter = stem.bond_length;
    stem.bond_outer_diameter = 0.5e-3;
    stem.density = 5.24e-4 * stem.bond_length / (pi / 6.0 * std::pow(stem.sphere_diameter, 3));
    stem.tip_mass_share = 0.5;
    stem.bond_damping = 25.0;
    spec.law = physics::consistent_law();
    spec.integrator.relative_tolerance = 1e-8;
    spec.tip_deflection = 1e-3;
    return spec;
}

/// The chain's last sphere is half a sphere: mass per length L is n − 1 spheres.
inline double angular_frequency(const CaseSpec& spec) {
    return 2.0 * pi * physics::first_frequency(spec.stem);
}

/// Has the law of the effect a kink where the stem turns back or passes its straight line?
inline bool is_kinked(const std::string& effect) {
    return effect == "clamp_slip" || effect == "plate_air" || effect == "amplitude_damping";
}

/// The stem with one effect of the library and its default parameters; a strip for an effect of
/// edges.
inline CaseSpec with_default_effect(CaseSpec spec, const std::string& name) {
    const physics::EffectPointer effect = physics::effect_named(name);
    if (effect->needs_edges) {
        spec.stem.width_across_motion = 0.012;
        spec.stem.rectangle_depth = 2e-3;
    }
    spec.effects = {physics::with_defaults(
        {effect, std::vector<std::optional<double>>(effect->parameters.size())}, spec.stem)};
    return spec;
}

/// Sets β so that mode 1 of the uniform stem has the damping `ratio`, and mode n ω_n/ω_1 times it.
inline void set_damping_ratio(CaseSpec& spec, double ratio) {
    spec.stem.bond_damping = 1.0;
    const auto bond = physics::make_bond_coefficients(spec.stem, spec.law);
    const double time = bond.bending_damping / bond.bending_stiffness;
    spec.stem.bond_damping = 2.0 * ratio / (2.0 * pi * physics::first_frequency(spec.stem) * time);
}

struct TurningPoint {
    double time;
    double value;
};

/// A recorded tip.
struct Swing {
    std::vector<double> times;
    std::vector<double> values;

    /// Turning points of the motion, from parabolas through three samples.
    [[nodiscard]] std::vector<TurningPoint> turning_points() const {
        std::vector<TurningPoint> points;
        for (std::size_t i = 1; i + 1 < values.size(); ++i) {
            const double before = values[i] - values[i - 1];
            const double after = values[i + 1] - values[i];
            if (before * after > 0.0 || before == 0.0)
                continue;
            const double place = 0.5 * (before + after) / (before - after);
            points.push_back({times[i] + place * (times[1] - times[0]),
                              values[i] + 0.25 * (before + after) * place});
        }
        return points;
    }

    /// Magnitude of the Fourier integral at `frequency` under a Hann window.
    [[nodiscard]] double spectrum(double frequency) const {
        std::complex<double> sum = 0.0;
        const double last = times.back();
        for (std::size_t i = 0; i < times.size(); ++i)
            sum += values[i] * (1.0 - std::cos(2.0 * pi * times[i] / last)) *
                   std::polar(1.0, -2.0 * pi * frequency * times[i]);
        return std::abs(sum) / static_cast<double>(times.size());
    }

    /// The largest spectrum within `share` of `frequency`.
    [[nodiscard]] double peak_near(double frequency, double share = 0.05) const {
        double best = frequency;
        for (double step = share / 50.0; step > 1e-7; step /= 10.0) {
            const double middle = best;
            const double reach = step == share / 50.0 ? 50.0 : 12.0;
            for (double k = -reach; k <= reach; k += 1.0)
                if (const double f = middle + k * step * frequency; spectrum(f) > spectrum(best))
                    best = f;
        }
        return best;
    }
};

/// `cycles` of the uniform stem's first mode, 200 samples each.
inline Swing swing(CaseSpec spec, double cycles) {
    const double period = 1.0 / physics::first_frequency(spec.stem);
    spec.sample_interval = period / 200.0;
    spec.duration = spec.sample_interval * std::round(200.0 * cycles);
    const CaseOutcome outcome = simulate(spec);
    if (const auto* failure = std::get_if<CaseFailure>(&outcome))
        throw std::runtime_error(failure->reason);
    Swing out;
    out.values = std::get<CaseResult>(outcome).tip_deflection;
    for (std::size_t i = 0; i < out.values.size(); ++i)
        out.times.push_back(static_cast<double>(i) * spec.sample_interval);
    return out;
}

/// Frequency and decay between two turning points, counted from the release.
struct Swinging {
    double frequency;       ///< Hz
    double decay_per_cycle; ///< negative
};

inline Swinging swinging(const Swing& swing, std::size_t from, std::size_t to) {
    const auto points = swing.turning_points();
    const double cycles = 0.5 * static_cast<double>(to - from);
    // Half the difference of neighbours is the amplitude between them, without the offset.
    const auto height = [&](std::size_t k) {
        return std::abs(points.at(k).value - points.at(k + 1).value);
    };
    return {cycles / (points.at(to).time - points.at(from).time),
            std::log(height(to) / height(from)) / cycles};
}

} // namespace culm::run
