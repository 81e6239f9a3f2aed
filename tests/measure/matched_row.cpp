// SPDX-License-Identifier: BSD-3-Clause
// Synthetic rows: a stem at a known position in front of a known background.
#include "measure/track/matched_row.hpp"

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace culm::tests {
namespace {

constexpr int width = 120;
constexpr double reach = 10.0;

/// Contrast of a stem 7 pixels wide behind a lens that blurs by 0.8 pixels.
double contrast(double distance) {
    const double blur = std::numbers::sqrt2 * 0.8;
    return 50.0 * (std::erf((distance + 3.5) / blur) - std::erf((distance - 3.5) / blur));
}

/// Mean over an exposure in which the axis moves by `length` and additionally by `bend` (2τ)². The
/// mean position of the axis is `axis`.
std::vector<float> drawn(double axis, const measure::Path& path) {
    constexpr int parts = 400;
    std::vector<float> row(width, 0.0F);
    for (int c = 0; c < width; ++c) {
        double sum = 0.0;
        for (int k = 0; k < parts; ++k) {
            const double time = (k + 0.5) / parts - 0.5;
            sum += contrast(c - axis - path.length * time - path.bend * (time * time - 1.0 / 12.0));
        }
        row[std::size_t(c)] = static_cast<float>(sum / parts);
    }
    return row;
}

measure::PixelRow pixels(const std::vector<float>& row) {
    return {row.data(), nullptr, width};
}

/// Profile from still stems at many positions, as at the turning points of swings.
measure::StemProfile profile() {
    measure::StemProfile profile(reach);
    for (double axis = 40.0; axis < 80.0; axis += 0.37) {
        const std::vector<float> row = drawn(axis, {});
        profile.add(pixels(row), axis);
    }
    profile.close();
    EXPECT_TRUE(profile.is_known());
    return profile;
}

double error(const measure::StemProfile& of, const measure::Path& path,
             const measure::Path& assumed) {
    constexpr double axis = 61.3;
    const std::vector<float> row = drawn(axis, path);
    const auto found = measure::match_row(of, pixels(row), axis + 0.2, assumed, 1.0);
    EXPECT_TRUE(found);
    return found ? found->axis - axis : std::nan("");
}

TEST(MatchedRow, ReadsATurningStemAtItsMeanPosition) {
    const measure::StemProfile still = profile();
    // An amplitude of 46 pixels at 65 Hz and an exposure of 1 ms: the stem moves and turns.
    const measure::Path turning{9.0, 2.0};
    EXPECT_NEAR(error(still, turning, turning), 0.0, 3e-3);
    EXPECT_GT(std::abs(error(still, turning, {turning.length, 0.0})), 0.05);
    EXPECT_NEAR(error(still, {-9.0, 2.0}, {-9.0, 2.0}), 0.0, 3e-3);
    EXPECT_NEAR(error(still, {0.0, -2.0}, {0.0, -2.0}), 0.0, 3e-3);
}

// A stain behind a stem whose motion decays quickly is visible in few frames only.
TEST(GroundRow, RecoversTextureFromFewFramesAndSuppressesNoise) {
    constexpr double noise = 4.0;
    std::mt19937 dice(1);
    std::normal_distribution<double> grey(0.0, noise);
    std::vector<double> ground(width);
    for (int c = 0; c < width; ++c)
        ground[std::size_t(c)] = 10.0 * std::sin(0.3 * c);
    const auto found = [&](double texture) {
        measure::GroundRow row;
        for (int frame = 0; frame < 200; ++frame) {
            std::vector<float> values;
            for (const double each : ground)
                values.push_back(static_cast<float>(texture * each + grey(dice)));
            row.add(pixels(values), frame < 20 ? 20.0 : 60.0, 8.0);
        }
        return row.mean(noise * noise);
    };
    const std::vector<float> textured = found(1.0);
    const std::vector<float> even = found(0.0);
    double of_textured = 0.0;
    double of_even = 0.0;
    for (std::size_t c = 53; c <= 67; ++c) {
        of_textured += std::pow(textured[c] - ground[c], 2) / 15.0;
        of_even += std::pow(even[c], 2) / 15.0;
    }
    EXPECT_LT(std::sqrt(of_textured), 1.5); // the error of 20 frames is 0.9, of a straight line 7
    EXPECT_LT(std::sqrt(of_even), 0.6);     // without texture the estimate must be near zero
}

} // namespace
} // namespace culm::tests
