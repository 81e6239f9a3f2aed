// SPDX-License-Identifier: BSD-3-Clause
// The motion behind the demonstration video is that of the beam.
#include "beam_generator/beam_stem.hpp"
#include "beam_generator/demo_beam.hpp"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <istream>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace culm::beam {
namespace {

/// Numbers of a table with one line of names.
std::vector<std::vector<double>> numbers_of(std::istream& lines) {
    std::string line;
    std::getline(lines, line);
    std::vector<std::vector<double>> rows;
    while (std::getline(lines, line)) {
        std::istringstream cells(line);
        std::vector<double>& row = rows.emplace_back();
        for (std::string cell; std::getline(cells, cell, ',');)
            row.push_back(std::stod(cell));
    }
    return rows;
}

TEST(DemoBeam, MovesAsItsTableInTheRepository) {
    const auto file = std::filesystem::path(CULM_TEST_DATA_DIR) / "demo-beam" / "axis.csv";
    std::ifstream stored_table(file);
    std::istringstream computed_table(demo_axis_table());
    const auto stored = numbers_of(stored_table);
    const auto computed = numbers_of(computed_table);
    ASSERT_EQ(stored.size(), computed.size());
    for (std::size_t frame = 0; frame < stored.size(); ++frame) {
        ASSERT_EQ(stored[frame].size(), computed[frame].size());
        for (std::size_t k = 0; k < stored[frame].size(); ++k)
            EXPECT_NEAR(stored[frame][k], computed[frame][k], 1.1e-3) << "frame " << frame;
    }
}

TEST(DemoBeam, SwingsAtTheFrequencyOfBeamTheory) {
    std::istringstream table(demo_axis_table());
    const auto rows = numbers_of(table);
    // Zeros of the tip's deflection, half a period apart.
    std::vector<double> zeros;
    for (std::size_t k = 1; k < rows.size(); ++k) {
        const double before = rows[k - 1].back();
        const double after = rows[k].back();
        if (before * after < 0.0)
            zeros.push_back(rows[k - 1][0] +
                            (rows[k][0] - rows[k - 1][0]) * before / (before - after));
    }
    ASSERT_GT(zeros.size(), 10U);
    const double frequency =
        0.5 * static_cast<double>(zeros.size() - 1) / (zeros.back() - zeros.front());
    const BeamStem stem{0.156, 2.83e-3, 125.0, demo_youngs_modulus, demo_damping_time};
    // Large swings, damping and the straight lines between frames change it by less.
    EXPECT_NEAR(frequency / stem.first_frequency(), 1.0, 3e-3);
}

} // namespace
} // namespace culm::beam
