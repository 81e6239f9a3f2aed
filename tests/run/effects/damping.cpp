// SPDX-License-Identifier: BSD-3-Clause
// Effects that dissipate energy, against averaged and exact solutions.
#include "beam_theory.hpp"
#include "free_vibration.hpp"
#include "physics/effects/stem_scales.hpp"
#include "run/modes.hpp"

#include <gtest/gtest.h>

namespace culm::run {
namespace {

double mass_per_length(const CaseSpec& spec) {
    return physics::mass_per_length(spec.stem);
}

TEST(BareStem, IsAnEulerBernoulliBeam) {
    CaseSpec spec = slender_case();
    set_damping_ratio(spec, 0.005);
    const Swinging found = swinging(swing(spec, 20.0), 10, 36);
    // The error of a chain of 56 bonds is of order (1/56)² = 3e-4.
    EXPECT_NEAR(found.frequency / physics::first_frequency(spec.stem), 1.0, 3e-4);
    EXPECT_NEAR(found.decay_per_cycle, -2.0 * pi * 0.005, 2e-4 * pi);
}

TEST(ViscousDrag, AddsTheSameDecayRateToEveryMode) {
    CaseSpec spec = slender_case();
    set_damping_ratio(spec, 0.005);
    const Swinging bare = swinging(swing(spec, 20.0), 10, 36);
    const double ratio = 0.01;
    const double coefficient = 2.0 * ratio * mass_per_length(spec) * angular_frequency(spec);
    spec.effects = {active("viscous_drag", {coefficient})};
    const Swinging damped = swinging(swing(spec, 20.0), 10, 36);
    const double rate =
        damped.decay_per_cycle * damped.frequency - bare.decay_per_cycle * bare.frequency;
    // −c/(2m'), exact for any mode; the frequency falls by ζ²/2. The difference is 0.06 per cycle
    // over 14 cycles; parabolas determine the amplitudes to about 1e-5.
    EXPECT_NEAR(rate / (-coefficient / (2.0 * mass_per_length(spec))), 1.0, 1e-3);
}

TEST(QuadraticDrag, DecaysAsTheAveragedEquationSays) {
    // dA/dt = −δA − cA² with c = (4/3π) ω D/M, D = ½ρC_d d L∫φ³, M = m'L∫φ², has the solution
    // 1/A = (1/A0 + c/δ) exp(δt) − c/δ. Deflections are small, so that the beam is linear;
    // a large coefficient compensates for this.
    CaseSpec spec = slender_case();
    set_damping_ratio(spec, 0.004);
    const double drag_coefficient = 60.0;
    spec.effects = {active("quadratic_drag", {drag_coefficient})};
    spec.tip_deflection = 2e-3;
    const auto points = swing(spec, 40.0).turning_points();
    const BeamMode mode;
    const double share = integral([&](double s) { return std::pow(std::abs(mode.value(s)), 3); }) /
                         integral([&](double s) { return std::pow(mode.value(s), 2); });
    const double drag = 0.5 * 1.2 * drag_coefficient * spec.stem.bond_outer_diameter;
    const double omega = angular_frequency(spec);
    const double c = 4.0 / (3.0 * pi) * omega * drag / mass_per_length(spec) * share;
    const double decay = 0.004 * omega;
    const auto& start = points.at(12); // mode 2 is gone after six cycles
    double lost_to_drag = 0.0;
    for (std::size_t k = 14; k < points.size(); ++k) {
        const double t = points[k].time - start.time;
        const double expected =
            1.0 / ((1.0 / std::abs(start.value) + c / decay) * std::exp(decay * t) - c / decay);
        // Averaging is of first order in the loss per cycle, which is below 2 %. The error of the
        // amplitude is the square of this loss, over some thirty cycles.
        EXPECT_NEAR(std::abs(points[k].value) / expected, 1.0, 3e-3) << k;
        lost_to_drag = std::abs(start.value) * std::exp(-decay * t) / expected;
    }
    EXPECT_GT(lost_to_drag, 1.2); // or the test says nothing
}

TEST(PowerDrag, DecaysAsTheAveragedEquationSays) {
    // dA/dt = −δA − cA^p has the solution A^(1−p) = (A0^(1−p) + c/δ) exp((p−1)δt) − c/δ. The power
    // D |v|^(p+1) per length, averaged over a cycle of E = ½ω²A² M, gives c = ω^(p−1) (D/M) m with
    // the mean m of |cos|^(p+1), D ~ ∫|φ|^(p+1), M = m'∫φ².
    for (const double p : {1.25, 5.0 / 3.0}) {
        CaseSpec spec = slender_case();
        set_damping_ratio(spec, 0.002);
        const double drag_coefficient = p < 1.5 ? 0.35 : 1.9; // takes 2 % of a cycle at first
        spec.effects = {active("power_drag", {drag_coefficient, p})};
        spec.tip_deflection = 2e-3;
        const auto points = swing(spec, 40.0).turning_points();
        const BeamMode mode;
        const double share =
            integral([&](double s) { return std::pow(std::abs(mode.value(s)), p + 1.0); }) /
            integral([&](double s) { return std::pow(mode.value(s), 2); });
        const double mean =
            std::tgamma(0.5 * p + 1.0) / (std::sqrt(pi) * std::tgamma(0.5 * p + 1.5));
        const double drag = 0.5 * 1.2 * drag_coefficient * spec.stem.bond_outer_diameter;
        const double omega = angular_frequency(spec);
        const double c = std::pow(omega, p - 1.0) * drag / mass_per_length(spec) * mean * share;
        const double decay = 0.002 * omega;
        const auto& start = points.at(12); // mode 2 is gone after six cycles
        double lost_to_drag = 0.0;
        for (std::size_t k = 14; k < points.size(); ++k) {
            const double t = points[k].time - start.time;
            const double expected =
                std::pow((std::pow(std::abs(start.value), 1.0 - p) + c / decay) *
                                 std::exp((p - 1.0) * decay * t) -
                             c / decay,
                         1.0 / (1.0 - p));
            // The tolerance is that of quadratic drag.
            EXPECT_NEAR(std::abs(points[k].value) / expected, 1.0, 4e-3) << p << " at " << k;
            lost_to_drag = std::abs(start.value) * std::exp(-decay * t) / expected;
        }
        EXPECT_GT(lost_to_drag, 1.2) << p; // or the test says nothing
    }
}

TEST(HystereticDamping, LosesTheSamePerCycleAtEveryFrequency) {
    CaseSpec spec = slender_case();
    spec.stem.bond_damping = 1e-6;
    const double loss = 0.04;
    const double stem_mass = mass_per_length(spec) * spec.stem.free_length();
    for (const double tip : {0.0, 0.5}) {
        spec.effects = {active("hysteretic_damping", {loss})};
        if (tip > 0.0)
            spec.effects.push_back(active("tip_mass", {tip * stem_mass}));
        const Swinging found = swinging(swing(spec, 40.0), 14, tip > 0.0 ? 40 : 70);
        // ζ = η/2 gives −πη per cycle. The storage modulus grows as 2η/π times the logarithm
        // of the frequency, which adds a share η/π. The six branches keep η within 0.3 % here.
        EXPECT_NEAR(found.decay_per_cycle / (-pi * loss * (1.0 + loss / pi)), 1.0, 5e-3) << tip;
    }
}

/// Slowest complex pair of (1 + sτ)(s² + ω² (1 + 2ζs/ω)) + ω² g s τ = 0, by Newton's method.
std::complex<double> relaxing_mode(double omega, double ratio, double fraction, double time) {
    std::complex<double> s(0.0, omega);
    const auto f = [&](std::complex<double> z) {
        return (1.0 + z * time) * (z * z + omega * omega + 2.0 * ratio * omega * z) +
               omega * omega * fraction * z * time;
    };
    for (int i = 0; i < 50; ++i) {
        const double step = 1e-6 * omega;
        s -= f(s) * 2.0 * step / (f(s + step) - f(s - step));
    }
    return s;
}

class Relaxation : public testing::TestWithParam<double> {};

TEST_P(Relaxation, VibratesAsTheStandardLinearSolid) {
    CaseSpec spec = slender_case();
    const double ratio = 0.005;
    set_damping_ratio(spec, ratio);
    const Swinging bare = swinging(swing(spec, 20.0), 10, 36);
    const double omega = 2.0 * pi * bare.frequency / std::sqrt(1.0 - ratio * ratio);
    const double fraction = 0.2;
    const double time = GetParam() / omega;
    spec.effects = {active("relaxation", {fraction, time, 1e3 * time})};
    const Swinging found = swinging(swing(spec, 20.0), 10, 36);
    const std::complex<double> exact =
        relaxing_mode(omega, -bare.decay_per_cycle / (2.0 * pi), fraction, time);
    // Turning points are accurate to 1e-4 while the offset still drifts.
    EXPECT_NEAR(2.0 * pi * found.frequency / exact.imag(), 1.0, 2e-4);
    EXPECT_NEAR(found.decay_per_cycle * found.frequency / exact.real(), 1.0, 5e-3);
    // The first order in the loss, which is at most g/2.
    const integrate::VibrationMode light = lightly_damped_mode(spec);
    EXPECT_NEAR(light.frequency / found.frequency, 1.0, fraction * fraction);
    EXPECT_NEAR(light.decay_rate / exact.real(), 1.0, 2.0 * fraction * fraction);
}
INSTANTIATE_TEST_SUITE_P(OmegaTau, Relaxation, testing::Values(0.1, 1.0, 10.0));

TEST(RelaxationAfterAHold, DriftsBackFromTheSideOfTheHold) {
    // Between fast and slow (ωτ ≫ 1) the mean is g (1 − h)/(1 + g) of the hold and decays with the
    // time (1 + g)τ; h is the remaining share of the branch, and the shape is the static one.
    CaseSpec spec = slender_case();
    set_damping_ratio(spec, 0.01);
    const double omega = angular_frequency(spec);
    const double time = 100.0 / omega;
    const double fraction = 0.1;
    for (const double hold : {0.7 * time, 20.0 * time}) {
        spec.effects = {active("relaxation", {fraction, time, hold})};
        const auto points = swing(spec, 40.0).turning_points();
        const double held = std::exp(-hold / time);
        for (std::size_t k = 20; k + 2 < points.size(); k += 10) {
            const double mean =
                0.25 * (points[k].value + 2.0 * points[k + 1].value + points[k + 2].value);
            const double expected = spec.tip_deflection * fraction * (1.0 - held) /
                                    (1.0 + fraction) *
                                    std::exp(-points[k + 1].time / ((1.0 + fraction) * time));
            // The error of the three-point mean is (ζπ)²/4 = 2.5e-4 of the amplitude, which is
            // below a half here; terms of order 1/(ωτ)² = 1e-4 are neglected.
            EXPECT_NEAR(mean, expected, 2e-4 * spec.tip_deflection) << k;
        }
    }
}

} // namespace
} // namespace culm::run
