// SPDX-License-Identifier: BSD-3-Clause
// Effects whose loss or frequency depends on the amplitude, and the air around a stem that swings
// little, against averaged solutions. A cycle of the amplitude A loses W of the energy
// ½ M ω² A², so dA/dt = −W/(2π M ω A); a mass or a softening shifts the frequency by the first
// order of its share of the energies.
#include "beam_theory.hpp"
#include "free_vibration.hpp"
#include "physics/effects/air.hpp"
#include "physics/effects/stem_scales.hpp"
#include "run/modes.hpp"

#include <gtest/gtest.h>

namespace culm::run {
namespace {

/// A strip that is much wider than deep.
CaseSpec strip() {
    CaseSpec spec = slender_case();
    spec.stem.width_across_motion = 4e-3;
    spec.stem.rectangle_depth = 0.5e-3;
    set_damping_ratio(spec, 0.002);
    spec.tip_deflection = 3e-3;
    return spec;
}

/// Amplitudes (of neighbouring turning points without their offset) and frequency over some cycles.
struct Piece {
    double first; ///< amplitude, m
    double last;
    double time; ///< between them, s
    double frequency;
    double decay_rate; ///< positive, 1/s

    /// In the middle of the cycles.
    [[nodiscard]] double amplitude() const { return std::sqrt(first * last); }
    /// That of the same time and first amplitude, for dA/dt = −rate A − loss(A).
    [[nodiscard]] double expected_decay(double rate,
                                        const std::function<double(double)>& loss) const {
        constexpr int steps = 2000;
        double amplitude = first;
        for (int k = 0; k < steps; ++k) { // the midpoint rule
            const double half =
                amplitude - 0.5 * time / steps * (rate * amplitude + loss(amplitude));
            amplitude -= time / steps * (rate * half + loss(half));
        }
        return std::log(first / amplitude) / time;
    }
};

Piece piece(const Swing& swing, std::size_t from, std::size_t to) {
    const auto points = swing.turning_points();
    const Swinging found = swinging(swing, from, to);
    const auto height = [&](std::size_t k) {
        return 0.5 * std::abs(points.at(k).value - points.at(k + 1).value);
    };
    return {height(from), height(to), points.at(to).time - points.at(from).time, found.frequency,
            -found.decay_per_cycle * found.frequency};
}

/// ∫ |φ|^p over ∫ φ².
double mode_ratio(double power) {
    const BeamMode mode;
    return integral([&](double s) { return std::pow(std::abs(mode.value(s)), power); }) /
           integral([&](double s) { return std::pow(mode.value(s), 2); });
}

TEST(PlateAir, LosesWhatGrahamsCoefficientTakes) {
    CaseSpec spec = strip();
    const Piece bare = piece(swing(spec, 40.0), 16, 60);
    spec.effects = {active("plate_air", {8.0, 0.0})};
    const Piece found = piece(swing(spec, 40.0), 16, 60);
    // A section of the amplitude a = Aφ loses ½ρ W C_d(a) (aω)³ 8/3/ω in a cycle.
    const double width = *spec.stem.width_across_motion;
    const double omega = angular_frequency(spec);
    const auto loss = [&](double amplitude) {
        const double coefficient = 8.0 * std::pow(2.0 * pi * amplitude / width, -1.0 / 3.0);
        return 0.5 * 1.2 * width * coefficient * amplitude * amplitude * omega * (8.0 / 3.0) /
               (2.0 * pi * physics::mass_per_length(spec.stem)) * mode_ratio(8.0 / 3.0);
    };
    const double expected = found.expected_decay(bare.decay_rate, loss) - bare.decay_rate;
    EXPECT_NEAR((found.decay_rate - bare.decay_rate) / expected, 1.0, 0.01);
    EXPECT_GT(expected, bare.decay_rate); // or the test says nothing
}

TEST(PlateAir, LowersTheFrequencyByItsAddedMass) {
    CaseSpec spec = strip();
    const Piece bare = piece(swing(spec, 40.0), 16, 60);
    spec.effects = {active("plate_air", {0.0, 0.1})};
    const Piece found = piece(swing(spec, 40.0), 16, 60);
    const double width = *spec.stem.width_across_motion;
    const double mass = 0.25 * pi * 1.2 * width * width * 0.1 *
                        std::pow(2.0 * pi * found.amplitude() / width, 2.0 / 3.0) *
                        mode_ratio(8.0 / 3.0);
    const double share = mass / physics::mass_per_length(spec.stem);
    EXPECT_NEAR((bare.frequency / found.frequency - 1.0) / (std::sqrt(1.0 + share) - 1.0), 1.0,
                0.01);
}

TEST(StillAir, AddsTheMassAndTheLossOfStokes) {
    for (const bool is_plate : {false, true}) {
        CaseSpec spec = strip();
        if (!is_plate) {
            spec.stem.width_across_motion.reset();
            spec.stem.rectangle_depth.reset();
            spec.stem.bond_outer_diameter = 3e-3; // 10.6 Hz
            spec.stem.bond_youngs_modulus *= 1e-3;
            set_damping_ratio(spec, 0.002);
        }
        const Piece bare = piece(swing(spec, 50.0), 16, 60);
        spec.effects = {active("still_air", {1.2, 1.5e-5})};
        const Piece found = piece(swing(spec, 50.0), 16, 60);
        const double omega = angular_frequency(spec);
        const double width = spec.stem.width_in_air();
        const auto function =
            physics::hydrodynamic_function(omega * width * width / 6e-5, is_plate);
        const double displaced =
            0.25 * pi * 1.2 * width * width / physics::mass_per_length(spec.stem);
        // ω ~ (1 + share)^(−1/2), and the rate is c/2 over the sum of the masses.
        const double share = displaced * function.real();
        // Half the square of the damping ratio lowers the frequency, too.
        const double damping_ratio = found.decay_rate / (2.0 * pi * found.frequency);
        const double undamped = found.frequency * (1.0 + 0.5 * damping_ratio * damping_ratio);
        EXPECT_NEAR((bare.frequency / undamped - 1.0) / (std::sqrt(1.0 + share) - 1.0), 1.0, 0.01)
            << is_plate;
        const double rate = 0.5 * displaced * omega * function.imag() / (1.0 + share);
        EXPECT_NEAR((found.decay_rate - bare.decay_rate / (1.0 + share)) / rate, 1.0, 0.01)
            << is_plate;
    }
}

TEST(AmplitudeDamping, HasALossFactorThatGrowsWithTheStrain) {
    for (const double power : {1.0, 2.0}) {
        CaseSpec spec = slender_case();
        set_damping_ratio(spec, 0.002);
        const Piece bare = piece(swing(spec, 40.0), 16, 60);
        // Strain per deflection of the tip, at the clamp.
        const double length = spec.stem.free_length();
        const double fibre = 0.5 * spec.stem.bond_outer_diameter;
        const BeamMode mode;
        const auto strain = [&](double s) {
            return fibre * std::abs(mode.curvature(s)) / (length * length);
        };
        const double loss = 0.02 * std::pow(1e-3 / (strain(0.0) * spec.tip_deflection), power);
        spec.effects = {active("amplitude_damping", {loss, power})};
        const Piece found = piece(swing(spec, 40.0), 16, 60);
        // The energy ½ E I κ² at the turning points; a cycle loses π η E I κ², so δ = ω η/2.
        const double mean =
            integral([&](double s) {
                return std::pow(mode.curvature(s), 2) * std::pow(strain(s) / 1e-3, power);
            }) /
            integral([&](double s) { return std::pow(mode.curvature(s), 2); });
        const double expected = found.expected_decay(bare.decay_rate, [&](double amplitude) {
            return 0.5 * angular_frequency(spec) * loss * mean * std::pow(amplitude, 1.0 + power);
        }) - bare.decay_rate;
        EXPECT_NEAR((found.decay_rate - bare.decay_rate) / expected, 1.0, 0.01) << power;
        EXPECT_GT(expected, 0.5 * bare.decay_rate);
    }
}

TEST(ClampCompliance, LosesItsLossFactor) {
    CaseSpec spec = slender_case();
    set_damping_ratio(spec, 0.002);
    const double stiffness = 10.0 * physics::stiffness_scale(spec.stem);
    const auto decay = [&](double loss_factor) {
        spec.effects = {active("clamp_compliance", {stiffness, loss_factor})};
        return -lightly_damped_mode(spec).decay_rate;
    };
    // Half the loss factor times the spring's share of the energy, which is the share of 1/ω²,
    // 1 + kL/EI, by Dunkerley to first order; here from the change of frequency with k.
    const auto frequency = [&](double factor) {
        spec.effects = {active("clamp_compliance", {factor * stiffness, 0.0})};
        return lightly_damped_mode(spec).frequency;
    };
    const double share = 2.0 * std::log(frequency(1.001) / frequency(0.999)) / 0.002;
    const double omega = 2.0 * pi * frequency(1.0);
    // The card's ω1 is that of the clamped stem.
    const double rate = 0.5 * 0.08 * share * omega * omega / angular_frequency(spec);
    EXPECT_NEAR((decay(0.08) - decay(0.0)) / rate, 1.0, 0.01);
}

/// The loop of a joint whose moment swings between ±z: dz/dθ = k (1 − s zⁿ) while it grows.
struct Loop {
    double half_turn; ///< θ, rad
    double loss;      ///< J
};

Loop loop_of(double stiffness, double slip, double power, double moment) {
    const double grows =
        integral([&](double x) { return 1.0 / (1.0 - slip * std::pow(x * moment, power)); }) *
        moment / stiffness;
    const double work =
        integral([&](double x) { return x / (1.0 - slip * std::pow(x * moment, power)); }) *
        moment * moment / stiffness;
    return {0.5 * (moment / stiffness + grows), 2.0 * (work - 0.5 * moment * moment / stiffness)};
}

TEST(ClampSlip, SoftensAndLosesAsItsLoopSays) {
    for (const double power : {0.7, 1.0, 1.5}) {
        CaseSpec spec = slender_case();
        set_damping_ratio(spec, 0.002);
        const double spring = 20.0;
        const double stiffness = spring * physics::stiffness_scale(spec.stem);
        const double reference =
            physics::bending_rigidity(spec.stem) * 1e-3 / spec.stem.outer_fibre();
        const double pulled = 3.0 * physics::bending_rigidity(spec.stem) * spec.tip_deflection /
                              std::pow(spec.stem.free_length(), 2);
        const double share = 0.03 * std::pow(reference / pulled, power);
        spec.effects = {active("clamp_slip", {0.0, stiffness, power})};
        const Piece bare = piece(swing(spec, 40.0), 16, 60);
        spec.effects = {active("clamp_slip", {share, stiffness, power})};
        const Piece found = piece(swing(spec, 40.0), 16, 60);
        // Mode 1 of a beam on the spring; its moment at the clamp is k φ'(0)/L per deflection.
        const double x = root(
            [&](double y) {
                return spring * (1.0 + std::cos(y) * std::cosh(y)) +
                       y * (std::cos(y) * std::sinh(y) - std::sin(y) * std::cosh(y));
            },
            0.1, clamped_1 + 1e-9);
        const BeamMode mode(x, spring);
        const double length = spec.stem.free_length();
        const double turn = mode.slope(0.0) / length;
        const double modal_mass = physics::mass_per_length(spec.stem) * length *
                                  integral([&](double s) { return std::pow(mode.value(s), 2); });
        const double omega = angular_frequency(spec) * std::pow(x / clamped_1, 2);
        const auto loop = [&](double amplitude) {
            return loop_of(stiffness, share * std::pow(reference, -power), power,
                           stiffness * turn * amplitude);
        };
        const double expected = found.expected_decay(bare.decay_rate, [&](double amplitude) {
            return loop(amplitude).loss / (2.0 * pi * modal_mass * omega * amplitude);
        }) - bare.decay_rate;
        EXPECT_NEAR((found.decay_rate - bare.decay_rate) / expected, 1.0, 0.01) << power;
        // The secant stiffness z/θ is lower than k; the spring's share of the stiffness is
        // k φ'²/(M ω²).
        const double moment = stiffness * turn * found.amplitude();
        const double secant = moment / loop(found.amplitude()).half_turn / stiffness;
        const double spring_share = stiffness * turn * turn / (modal_mass * omega * omega);
        const double shift = 0.5 * spring_share * (1.0 - secant);
        EXPECT_NEAR((1.0 - found.frequency / bare.frequency) / shift, 1.0, 0.3) << power;
    }
}

} // namespace
} // namespace culm::run
