// SPDX-License-Identifier: BSD-3-Clause
// Effects that change stiffness, mass and shape along the stem, against beam theory.
#include "beam_theory.hpp"
#include "free_vibration.hpp"

#include <gtest/gtest.h>

namespace culm::run {
namespace {

/// Frequency of mode 1 over that without the effects. The error of the chain cancels except for a
/// small part.
double relative_frequency(const std::vector<physics::ActiveEffect>& effects) {
    CaseSpec spec = slender_case();
    set_damping_ratio(spec, 0.005);
    const double bare = swinging(swing(spec, 20.0), 12, 34).frequency;
    spec.effects = effects;
    return swinging(swing(spec, 30.0), 12, 28).frequency / bare;
}

double one(double) {
    return 1.0;
}

class Taper : public testing::TestWithParam<double> {};

TEST_P(Taper, HasTheFrequencyOfTheTaperedBeam) {
    const double change = GetParam();
    const auto diameter = [&](double s) { return 1.0 + change * (s - 0.5); };
    const double expected = frequency_ratio([&](double s) { return std::pow(diameter(s), 4); },
                                            [&](double s) { return std::pow(diameter(s), 2); });
    // The discretisation by 56 bonds has an error of a few times (1/56)².
    EXPECT_NEAR(relative_frequency({active("taper", {change})}) / expected, 1.0, 5e-4);
    EXPECT_GT(std::abs(expected - 1.0), 0.1);
}
INSTANTIATE_TEST_SUITE_P(BothWays, Taper, testing::Values(-0.5, 0.3));

TEST(StiffnessGradient, HasTheFrequencyOfTheGradedBeam) {
    const double expected = frequency_ratio([](double s) { return 1.0 - 0.8 * (s - 0.5); }, one);
    EXPECT_NEAR(relative_frequency({active("stiffness_gradient", {-0.8})}) / expected, 1.0, 5e-4);
    EXPECT_GT(std::abs(expected - 1.0), 0.05);
}

TEST(LocalDefect, LowersTheFrequencyByTheSquareOfTheCurvatureThere) {
    // First order in the extra compliance: Δω²/ω² = −(1/f − 1) 0.03 φ''(s0)²/∫φ''².
    const BeamMode mode;
    const double square = integral([&](double s) { return std::pow(mode.curvature(s), 2); });
    const double length = slender_case().stem.free_length();
    const double factor = 0.8;
    for (const double place : {0.2, 0.5}) {
        const double share =
            (1.0 / factor - 1.0) * 0.03 * std::pow(mode.curvature(place), 2) / square;
        const double shift =
            relative_frequency({active("local_defect", {place * length, factor})}) - 1.0;
        // The second order is 3/8 of the share (up to 2 %), and the curve's width of half a bond
        // averages the curvature: a few per cent of a shift of up to 1 %.
        EXPECT_NEAR(shift / (-0.5 * share), 1.0, 0.03) << place;
    }
}

TEST(TipMass, HasTheFrequencyOfTheLoadedBeam) {
    const CaseSpec spec = slender_case();
    const double stem_mass = physics::mass_per_length(spec.stem) * spec.stem.free_length();
    for (const double ratio : {0.02, 0.5}) {
        const double x = root(
            [&](double y) {
                return 1.0 + std::cos(y) * std::cosh(y) +
                       ratio * y * (std::cos(y) * std::sinh(y) - std::sin(y) * std::cosh(y));
            },
            0.5, clamped_1 + 1e-9);
        const double expected = std::pow(x / clamped_1, 2);
        EXPECT_NEAR(relative_frequency({active("tip_mass", {ratio * stem_mass})}) / expected, 1.0,
                    2e-4);
    }
}

TEST(BendingNonlinearity, ShiftsTheFrequencyAlongTheBackbone) {
    // V = ½EI∫κ² + ¼EIγ∫κ⁴ gives Δω/ω = (3/8) γ A² ∫φ''⁴/∫φ''² /L⁴ for mode 1.
    CaseSpec spec = slender_case();
    set_damping_ratio(spec, 0.004);
    spec.tip_deflection = 2e-3;
    const Swing bare = swing(spec, 30.0);
    const auto points = bare.turning_points();
    const BeamMode mode;
    const double length = spec.stem.free_length();
    const double ratio = integral([&](double s) { return std::pow(mode.curvature(s), 4); }) /
                         integral([&](double s) { return std::pow(mode.curvature(s), 2); }) /
                         std::pow(length, 4);
    double mean_square = 0.0;
    for (std::size_t k = 12; k < 40; ++k)
        mean_square += points.at(k).value * points.at(k + 1).value / -28.0;
    for (const double shift : {-0.01, 0.01}) {
        const double gamma = shift / (0.375 * ratio * mean_square);
        spec.effects = {active("bending_nonlinearity", {gamma})};
        const double found =
            swinging(swing(spec, 30.0), 12, 40).frequency / swinging(bare, 12, 40).frequency - 1.0;
        // The next order of the backbone is the square of the shift, and mode 2 is also excited:
        // 3 % of a shift of 1 %.
        EXPECT_NEAR(found / shift, 1.0, 0.05) << shift;
    }
}

TEST(OutOfPlane, BeatsWithTheDifferenceOfTheTwoFrequencies) {
    CaseSpec spec = slender_case();
    set_damping_ratio(spec, 0.004);
    spec.dimensions = 3;
    const auto bare = swing(spec, 60.0).turning_points();
    const double frequency = 59.0 / 2.0 / (bare.at(73).time - bare.at(14).time);
    const double split = 0.03;
    const double difference =
        frequency * (std::sqrt(1.0 + 0.5 * split) - std::sqrt(1.0 - 0.5 * split));
    spec.effects = {active("out_of_plane", {split, 45.0})};
    const Swing seen = swing(spec, 60.0);
    double smallest = 1.0;
    for (const TurningPoint& point : bare) {
        if (point.time < 6.0 / frequency || point.time > 57.0 / frequency)
            continue;
        // cos²α cos ω1 t + sin²α cos ω2 t at 45 degrees: an envelope |cos(πΔf t)|.
        double largest = 0.0;
        for (std::size_t i = 0; i < seen.times.size(); ++i)
            if (std::abs(seen.times[i] - point.time) < 0.25 / frequency)
                largest = std::max(largest, std::abs(seen.values[i]));
        const double envelope = largest / std::abs(point.value);
        const double expected = std::abs(std::cos(pi * difference * point.time));
        // Within half a cycle the envelope itself changes by π Δf/(4 f) = 1.2 %.
        EXPECT_NEAR(envelope, expected, 0.015) << point.time;
        smallest = std::min(smallest, envelope);
    }
    EXPECT_LT(smallest, 0.05); // half a beat was seen
}

/// Rest position of the stem after a release straight above the clamp.
double deflection_at_rest(const std::vector<physics::ActiveEffect>& effects) {
    CaseSpec spec = slender_case();
    set_damping_ratio(spec, 0.7);
    spec.release = Release::HeldStraight;
    spec.effects = effects;
    return swing(spec, 12.0).values.back(); // exp(−0.7 · 2π · 12) of the motion remains
}

TEST(Precurvature, IsTheShapeAtRest) {
    const double length = slender_case().stem.free_length();
    const double base = 0.12;
    const double tip = -0.05;
    // ∫(L − s) κ0(s) ds; the cubes of the small slopes are 1e-5 of them. The error of 56
    // hinges instead of a curve is (1/56)².
    const double expected = length * length * (base / 2.0 + (tip - base) / 6.0);
    EXPECT_NEAR(deflection_at_rest({active("precurvature", {base, tip})}) / expected, 1.0, 5e-4);
}

TEST(Gravity, BendsALyingStemAsAUniformLoad) {
    const CaseSpec spec = slender_case();
    const double length = spec.stem.free_length();
    const double acceleration = 0.01; // bends this very soft stem by 1 mm
    const double expected = physics::mass_per_length(spec.stem) * acceleration *
                            std::pow(length, 4) / (8.0 * physics::bending_rigidity(spec.stem));
    // The error of 56 point loads and hinges is a few times (1/56)².
    EXPECT_NEAR(deflection_at_rest({active("gravity", {0.0, acceleration})}) / expected, 1.0, 1e-3);
}

TEST(Gravity, SoftensAStandingStemAndStiffensAHangingOne) {
    // First order: Δω²/ω² = ± m'g ∫(1 − s) φ'² L³/(E I ∫φ''²).
    const CaseSpec spec = slender_case();
    const BeamMode mode;
    const double share =
        integral([&](double s) { return (1.0 - s) * std::pow(mode.slope(s), 2); }) /
        integral([&](double s) { return std::pow(mode.curvature(s), 2); });
    const double length = spec.stem.free_length();
    for (const double acceleration : {-0.05, 0.05}) {
        const double change = physics::mass_per_length(spec.stem) * acceleration *
                              std::pow(length, 3) / physics::bending_rigidity(spec.stem) * share;
        const double found = relative_frequency({active("gravity", {acceleration, 0.0})});
        // The change is 4 %; its second order is about a hundredth of it.
        EXPECT_NEAR((found * found - 1.0) / change, 1.0, 0.02) << acceleration;
    }
}

} // namespace
} // namespace culm::run
