// SPDX-License-Identifier: BSD-3-Clause
// A material whose relaxation is spread over many decades of time.
#include "physics/effects/effect.hpp"
#include "physics/effects/stem_scales.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace culm::physics {

namespace {

/// Relaxation times relative to 1/ω1 of the first natural frequency. Faster branches carry no load
/// and are omitted; slower ones act as a spring. The times are fixed for a stem, so that the motion
/// is smooth in τ and α.
constexpr int branches_a_decade = 5; // in two decades
constexpr int first_branch = -7;     // 10^-2.8
constexpr int last_branch = 8;       // 10^3.2

/// ∫ H dx from −∞ to x = ln(τ'/τ), of the spectrum of Cole and Cole (1941),
/// H = sin(απ)/(2π (cosh αx + cos απ)): the part of the modulus that relaxes within τ'.
double relaxed_within(double x, double exponent) {
    const double half = 0.5 * std::numbers::pi * exponent;
    return 0.5 + std::atan(std::tan(half) * std::tanh(0.5 * exponent * x)) /
                     (std::numbers::pi * exponent);
}

void apply_fractional_zener(std::span<const double> values, EffectTarget& target) {
    const double fraction = values[0];
    const double time = values[1];
    const double exponent = values[2];
    const double hold_time = values[3];
    const double unit = 1.0 / (2.0 * std::numbers::pi * first_frequency(target.stem));
    const double step = std::numbers::ln10 * 2.0 / branches_a_decade;
    for (int k = first_branch; k <= last_branch; ++k) {
        const double own = unit * std::exp(step * k);
        const double x = std::log(own / time);
        // Each branch represents the part of the spectrum that is nearest to it.
        const double from = relaxed_within(x - 0.5 * step, exponent);
        const double to = k == last_branch ? 1.0 : relaxed_within(x + 0.5 * step, exponent);
        target.model.branches.push_back({.relative_stiffness = fraction * (to - from),
                                         .relaxation_time = own,
                                         .held_share = std::exp(-hold_time / own)});
    }
}

/// From the time at which a branch damps the first mode most to times longer than the record.
std::vector<double> zener_start_times(const StartScales& of) {
    const double shortest = 1.0 / (2.0 * std::numbers::pi * of.first_frequency);
    return {0.1 * shortest, shortest, std::max(of.duration / 3.0, shortest)};
}

} // namespace

EffectPointer fractional_zener() {
    return make_effect(
        {.name = "fractional_zener",
         .family = Family::MaterialDamping,
         .summary = "a material that relaxes over many decades of time",
         .law = "M* = E + ΔE (iωτ)^α/(1 + (iωτ)^α), g = ΔE/E, by 16 Maxwell branches from "
                "1/(630 ω1) to 1600/ω1. Y is the relaxed modulus E. α = 1 would be "
                "relaxation, α toward 0 is hysteretic_damping; held for t_h, each branch has "
                "relaxed by exp(-t_h/τ_k)",
         .source = "Cole & Cole (1941), J. Chem. Phys. 9:341-351 (spectrum); Bagley & Torvik "
                   "(1983), J. Rheol. 27:201-210",
         .signature = "the loss factor grows or falls with a power of the frequency, by α at most; "
                      "the mean position creeps back as a power of time",
         .remedy = "needs at least three frequencies: add a known mass at the tip or change the "
                   "length; vary the time for which the stem is held",
         .energy = "each branch k stores q²/(2 g_k E I) per length and takes out q²/(g_k E I τ_k) "
                   "per second. The energy that the branches store after the hold is part of "
                   "the energy at the release; they supply no other energy",
         .parameters =
             {size_parameter("fraction", "", "g: modulus that relaxes over the relaxed one",
                             {.default_value = 0.05, .lower = 0.0, .upper = 2.0, .scale = 0.02}),
              place_parameter("time_s", "s", "τ: where the loss is largest, 1/ω",
                              {.default_value = 0.01, .lower = 1e-6, .upper = 1e4, .scale = 0.01},
                              zener_start_times, FittedAs::Logarithm),
              place_parameter("exponent", "",
                              "α: width of the spectrum; the loss falls off as (ωτ)^±α",
                              {.default_value = 0.4, .lower = 0.05, .upper = 0.8, .scale = 0.2},
                              [](const StartScales& /*of*/) {
                                  return std::vector{0.3, 0.6};
                              }),
              hold_time_parameter()},
         .excludes = {"relaxation", "hysteretic_damping"},
         .revealed_by = {{"hold the stem ten times as long before the release",
                          {1.0, 1.0, 1.0, 10.0}}}},
        apply_fractional_zener);
}

} // namespace culm::physics
