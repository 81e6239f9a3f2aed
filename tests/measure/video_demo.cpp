// SPDX-License-Identifier: BSD-3-Clause
// The demonstration video against its true deflections, if the data are available.
#include "measure/folder/measurement_folder.hpp"
#include "measure/track/track.hpp"
#include "measure/track/track_report.hpp"
#include "support/optional_data.hpp"
#include "support/temporary_folder.hpp"

#include <cmath>
#include <fstream>
#include <sstream>

#include <fmt/core.h>
#include <gtest/gtest.h>

namespace culm::measure {
namespace {

/// Writes the demonstration's video.toml with extra settings, and a link to its frames.
std::filesystem::path demo_settings(const std::filesystem::path& data,
                                    const tests::TemporaryFolder& folder,
                                    const std::string& extra) {
    std::ifstream in(data / "video.toml");
    std::ostringstream text;
    text << in.rdbuf();
    std::string settings = text.str();
    const std::string place = "frames = \"";
    settings.replace(settings.find(place), place.size(), fmt::format("{}\n{}demo/", extra, place));
    std::filesystem::create_directory_symlink(std::filesystem::absolute(data), folder / "demo");
    const std::filesystem::path file = folder / "video.toml";
    std::ofstream(file) << settings;
    return file;
}

struct Truth {
    std::vector<double> times;
    std::vector<std::vector<double>> deflections; ///< mm, (frames, heights 16, 32 … 144 mm)
};

Truth read_truth(const std::filesystem::path& file) {
    Truth truth;
    std::ifstream in(file);
    std::string line;
    std::getline(in, line);
    while (std::getline(in, line)) {
        std::istringstream cells(line);
        std::string cell;
        std::getline(cells, cell, ',');
        truth.times.push_back(std::stod(cell));
        truth.deflections.emplace_back();
        while (std::getline(cells, cell, ','))
            truth.deflections.back().push_back(std::stod(cell));
    }
    return truth;
}

TEST(DemonstrationVideo, IsTrackedWithinAQuarterPixel) {
    const auto data = tests::optional_data("video-demo");
    if (!data)
        GTEST_SKIP() << "the data are not available";
    const Truth truth = read_truth(*data / "deflection.csv");
    // A single row, and the default straight line through five rows.
    for (const auto& [rows, limit] : {std::pair{1, 0.08}, std::pair{5, 0.03}}) {
        const tests::TemporaryFolder folder;
        const Track track =
            track_video(read_track_settings(demo_settings(
                            *data, folder,
                            fmt::format("heights_mm = [16, 32, 48, 64, 80, 96, 112, 128, 144]\n"
                                        "rows_per_height = {}",
                                        rows))),
                        {2});
        double sum = 0.0;
        std::size_t count = 0;
        const Measurement& measurement = track.measurement;
        for (std::size_t k = 0; k < measurement.times.size(); ++k)
            for (std::size_t h = 0; h < measurement.heights.size(); ++h)
                if (const double value = measurement.deflection(k, h); !std::isnan(value)) {
                    const double error =
                        (value * 1e3 - truth.deflections[track.first_kept + k][h]) / 0.4;
                    sum += error * error;
                    ++count;
                }
        EXPECT_GT(double(count), 0.99 * double(measurement.deflections.size()));
        // 0.25 pixels are required; the measured errors were 0.050 and 0.024.
        EXPECT_LT(std::sqrt(sum / double(count)), limit) << rows << " rows";
        // The true release lies between two frames; a tenth of a frame is 0.1 ms.
        EXPECT_NEAR(measurement.times.front() * 960.0, truth.times[track.first_kept] * 960.0, 0.1);
    }
}

TEST(DemonstrationVideo, GivesAFolderThatReadsBack) {
    const auto data = tests::optional_data("video-demo");
    if (!data)
        GTEST_SKIP() << "the data are not available";
    const tests::TemporaryFolder folder;
    const Track track = track_video(read_track_settings(demo_settings(*data, folder, "")), {2});
    write_track(folder / "out", track);
    const Measurement read = read_measurement(folder / "out");
    EXPECT_EQ(read.times, track.measurement.times);
    EXPECT_EQ(read.deflections, track.measurement.deflections);
    EXPECT_EQ(read.noise_by_height, track.measurement.noise_by_height);
    EXPECT_GT(std::filesystem::file_size(folder / "out" / "contact_sheet.png"), 100000U);
    EXPECT_TRUE(std::filesystem::exists(folder / "out" / "track.json"));
}

} // namespace
} // namespace culm::measure
