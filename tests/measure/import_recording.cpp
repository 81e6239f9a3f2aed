// SPDX-License-Identifier: BSD-3-Clause
#include "measure/import/import_recording.hpp"

#include "measure/c3d_example.hpp"
#include "measure/measurement_files.hpp"
#include "support/optional_data.hpp"

#include <cmath>
#include <numbers>
#include <random>

#include <fmt/format.h>
#include <gtest/gtest.h>

namespace {

using namespace culm;
using namespace culm::measure;
using namespace culm::tests;

const std::string square_stem =
    "[stem]\nid = \"beam\"\nlength_mm = 100\ndensity_kg_m3 = 1070\n[section]\n"
    "shape = \"rectangle\"\nwidth_mm = 30\nheight_mm = 30\n[release]\nkind = \"held_straight\"\n"
    "[measurement]\nreading = \"material\"\ngravity_direction = \"transverse\"\n";

constexpr double release = 0.2512; // s, between two frames of 1/200 s
constexpr double level = 50.0;     // mm

/// Position in mm: held at a level, then swinging about 10 mm below it.
double travel(double time) {
    const double t = time - release;
    return t <= 0.0
               ? 0.0
               : 10.0 * (1.0 - std::exp(-3.0 * t) * std::cos(2.0 * std::numbers::pi * 5.0 * t));
}

/// A small repeatable unevenness of up to 0.01 mm.
double unevenness(int i) {
    return 0.01 * std::sin(37.0 * i + 1.0);
}

Measurement import_text(const std::string& mapping, const std::string& name,
                        const std::string& recording) {
    const TemporaryFolder folder;
    write_file(folder / "mapping.toml", mapping);
    write_file(folder / name, recording);
    return import_recording(read_import_mapping(folder / "mapping.toml"));
}

const std::string table_mapping =
    square_stem +
    "[source]\nfile = \"a.txt\"\n[time]\ncolumn = \"t\"\nunit = \"ms\"\n"
    "release_s = \"detect\"\n[motion]\nunit = \"cm\"\nsign = -1\n"
    "zero = \"before_release\"\n[[height]]\nheight_mm = 100\ncolumns = [\"tip1\", \"4\"]\n"
    "[[height]]\nheight_mm = 50\ncolumns = \"middle\"\n";

std::string table(char delimiter, bool has_decimal_comma) {
    std::string text = fmt::format("t{0}tip1{0}middle{0}tip 2\n", delimiter);
    for (int i = 0; i < 200; ++i) {
        const double time = i / 200.0;
        const double x = level - travel(time) + unevenness(i);
        std::string line =
            fmt::format("{1}{0}{2}{0}{3}{0}{4}\n", delimiter, 1e3 * time, 0.1 * (x + 1.0),
                        0.1 * (level - 0.3 * travel(time) + unevenness(i + 1000)), 0.1 * (x - 1.0));
        for (char& c : line)
            if (c == '.' && has_decimal_comma)
                c = ',';
        text += line;
    }
    return text;
}

void expect_the_beam(const Measurement& measurement) {
    ASSERT_EQ(measurement.heights, (std::vector<double>{0.05, 0.1}));
    ASSERT_EQ(measurement.times.size(), 200U);
    // The release lies between frames 50 and 51; noise determines the last frame at rest.
    const double found = -measurement.times.front();
    EXPECT_NEAR(found, release, 1.0 / 200.0);
    for (std::size_t i = 0; i < 200; ++i) {
        const double expected = 1e-3 * travel(measurement.times[i] + found);
        EXPECT_NEAR(measurement.deflection(i, 1), expected, 1.5e-5); // the unevenness and its mean
        EXPECT_NEAR(measurement.deflection(i, 0), 0.3 * expected, 1.5e-5);
    }
    ASSERT_EQ(measurement.noise_by_height.size(), 2U);
    EXPECT_NEAR(measurement.noise_by_height[1], 0.01e-3 / std::numbers::sqrt2, 1e-6);
    EXPECT_NE(measurement.noise_source.find("frames before the release"), std::string::npos);
    EXPECT_EQ(measurement.reading, Reading::Material);
}

TEST(ImportRecording, TakesTablesWithAnyDelimiterAndDecimalSign) {
    expect_the_beam(import_text(table_mapping, "a.txt", table(',', false)));
    expect_the_beam(import_text(table_mapping, "a.txt", table('\t', false)));
    std::string german = table_mapping;
    german.replace(german.find("[time]"), 0, "decimal = \",\"\n");
    expect_the_beam(import_text(german, "a.txt", table(';', true)));
}

C3dExample recording() {
    C3dExample file;
    file.labels = {"base", "tip 1", "tip 2"};
    file.frames = 200;
    for (int i = 0; i < 200; ++i) {
        const double time = i / 200.0;
        const double shake = 0.5 * std::sin(40.0 * time); // mm, motion of the whole set-up
        const double x = level - travel(time) + unevenness(i) + shake;
        for (const double value : {level + shake, 3.0, 0.0, x + 5.0, 3.0, 90.0, x - 5.0, 3.0, 95.0})
            file.positions.push_back(static_cast<float>(value));
    }
    return file;
}

const std::string marker_mapping =
    square_stem + "[source]\nfile = \"a.c3d\"\n[time]\nrelease_s = 0.2512\nbefore_s = 0.1\n"
                  "after_s = 0.5\n[motion]\naxis = [-2, 0, 0]\nzero = \"before_release\"\n"
                  "[clamp]\nmarkers = \"base\"\n[[height]]\nheight_mm = 100\n"
                  "markers = [\"tip 1\", \"tip 2\"]\n";

TEST(ImportRecording, TakesMarkersAlongAnAxisLessTheMotionOfTheClamp) {
    const Measurement measurement = import_text(marker_mapping, "a.c3d", recording().bytes());
    EXPECT_EQ(measurement.frames_per_second, 200.0);
    ASSERT_EQ(measurement.times.size(), 120U);
    EXPECT_GE(measurement.times.front(), -0.1);
    EXPECT_LE(measurement.times.back(), 0.5);
    for (std::size_t i = 0; i < measurement.times.size(); ++i)
        EXPECT_NEAR(measurement.deflection(i, 0), 1e-3 * travel(measurement.times[i] + release),
                    2e-5); // the unevenness, its mean, and floats of 50 mm
}

TEST(ImportRecording, ReportsMistakesWithTheNearestName) {
    const auto complaint = [](std::string mapping, const std::string& from, const std::string& to,
                              const std::string& name, const std::string& content) {
        mapping.replace(mapping.find(from), from.size(), to);
        return refusal([&] { static_cast<void>(import_text(mapping, name, content)); });
    };
    const std::string c3d = recording().bytes();
    EXPECT_NE(complaint(marker_mapping, "tip 2", "tip2", "a.c3d", c3d)
                  .find("there is no marker \"tip2\" (did you mean \"tip 2\"?)"),
              std::string::npos);
    EXPECT_NE(complaint(marker_mapping, "0.2512", "7", "a.c3d", c3d)
                  .find("nothing was recorded after the release"),
              std::string::npos);
    EXPECT_NE(complaint(marker_mapping, "axis = [-2, 0, 0]", "", "a.c3d", c3d)
                  .find("motion.axis is missing"),
              std::string::npos);
    EXPECT_NE(complaint(table_mapping, "middle", "midle", "a.txt", table(',', false))
                  .find("there is no column \"midle\" (did you mean \"middle\"?)"),
              std::string::npos);
    EXPECT_NE(complaint(table_mapping, "\"ms\"", "\"frame\"", "a.txt", table(',', false))
                  .find("frame numbers need [camera] fps"),
              std::string::npos);
    EXPECT_NE(complaint(table_mapping, "\"detect\"", "0", "a.txt", "t,tip1,middle,tip 2\n0,1,2,x\n")
                  .find("a.txt:2: column 4: \"x\" is not a number"),
              std::string::npos);
}

TEST(ImportRecording, BoundsTheNumberOfHeightsAndColumns) {
    const auto complaint = [](const std::string& mapping) {
        return refusal([&] { static_cast<void>(import_text(mapping, "a.txt", "t\n")); });
    };
    std::string many = table_mapping;
    for (int i = 0; i < 10000; ++i)
        many += "[[height]]\nheight_mm = 1\ncolumns = \"middle\"\n";
    EXPECT_NE(complaint(many).find("10002 tables; at most 10000 are allowed"), std::string::npos);
    std::string wide = table_mapping + "[[height]]\nheight_mm = 1\ncolumns = [";
    for (int i = 0; i < 1001; ++i)
        wide += "\"middle\",";
    EXPECT_NE(complaint(wide + "]\n").find("1001 names; at most 1000 are allowed"),
              std::string::npos);
}

TEST(ImportRecording, RefusesToGuessAnAbsentRelease) {
    std::string still = "t,tip1,middle,tip 2\n";
    for (int i = 0; i < 100; ++i)
        still += fmt::format("{},{},{},{}\n", 5 * i, 5.0 + 0.1 * unevenness(i), 5.0, 5.0);
    EXPECT_NE(refusal([&] {
                  static_cast<void>(import_text(table_mapping, "a.txt", still));
              }).find("no release was found"),
              std::string::npos);
}

/// A swing of 14 mm and 5 Hz with noise, 400 frames at 200/s; the mapping states a release in
/// frame 179, in the middle of the swing.
std::string swinging_table(double amplitude) {
    std::mt19937 generator(3);
    std::normal_distribution<double> noise(0.0, 0.01); // mm
    std::string text = "t;tip1;4;middle\n";
    for (int i = 0; i < 400; ++i) {
        const double time = i / 200.0;
        const double swing = amplitude * std::cos(2.0 * std::numbers::pi * 5.0 * time);
        const double tip = 0.1 * (swing + noise(generator));
        text += fmt::format("{};{};{};{}\n", 1e3 * time, tip, tip,
                            0.1 * (0.3 * swing + noise(generator)));
    }
    return text;
}

std::string mapping_with_release() {
    std::string mapping = table_mapping;
    const std::string detect = "release_s = \"detect\"";
    return mapping.replace(mapping.find(detect), detect.size(), "release_s = 0.895");
}

TEST(ImportRecording, EstimatesNoNoiseFromFramesThatMove) {
    const Measurement measurement =
        import_text(mapping_with_release(), "a.txt", swinging_table(14.1));
    EXPECT_TRUE(measurement.noise_by_height.empty());
    EXPECT_EQ(measurement.noise_source, "");
    ASSERT_EQ(measurement.remarks.size(), 1U);
    EXPECT_EQ(
        measurement.remarks.front(),
        "the stem moves in the 179 frames before the release: the recording begins in the "
        "middle of a swing (then write [release] kind = \"moving\"), or release_s is wrong. No "
        "noise is estimated from these frames, "
        "and their mean is not a valid zero: set zero = \"at_rest\" or \"as_given\"");
}

TEST(ImportRecording, EstimatesNoiseFromFramesWithoutMotion) {
    const Measurement measurement =
        import_text(mapping_with_release(), "a.txt", swinging_table(0.0));
    EXPECT_EQ(measurement.noise_source, "scatter of 179 frames before the release");
    ASSERT_EQ(measurement.noise_by_height.size(), 2U);
    EXPECT_NEAR(measurement.noise_by_height.front(), 0.01e-3, 0.002e-3);
}

TEST(TimeGaps, AreWhereFramesAreMissing) {
    std::vector<double> times;
    for (int i = 0; i < 100; ++i)
        if (i != 20 && (i < 50 || i >= 54))
            times.push_back(0.01 * i + 1e-4 * (i % 2)); // a camera's jitter
    const TimeGaps gaps = time_gaps(times);
    EXPECT_EQ(gaps.count, 2U);
    EXPECT_NEAR(gaps.longest, 0.05, 2e-4);
    EXPECT_NEAR(gaps.begin_of_longest, 0.49, 2e-4);
    EXPECT_EQ(time_gaps(std::vector{0.0, 0.1, 0.2}).count, 0U);
}

TEST(ImportRecording, TakesThePublicSiliconeBeam) {
    const auto file = optional_data("real/silicone-cantilever/beam_gravity_V2_a.c3d");
    if (!file)
        GTEST_SKIP() << "the public recording is not available";
    const TemporaryFolder place;
    write_file(place / "mapping.toml",
               square_stem + "[time]\nrelease_s = \"detect\"\n[motion]\naxis = [-1, 0, 0]\n"
                             "zero = \"before_release\"\n[[height]]\nheight_mm = 100\n"
                             "markers = [\"Tip - 1\", \"Tip - 2\", \"Tip - 3\"]\n");
    const Measurement measurement =
        import_recording(read_import_mapping(place / "mapping.toml", *file));
    EXPECT_EQ(measurement.times.size(), 500U);
    EXPECT_EQ(measurement.frames_per_second, 100.0);
    // Its README: release at 0.44 … 0.71 s, rest noise 3 … 10 µm.
    EXPECT_NEAR(-measurement.times.front(), 0.71, 0.011);
    EXPECT_GT(measurement.noise_by_height.at(0), 3e-6);
    EXPECT_LT(measurement.noise_by_height.at(0), 10e-6);
}

} // namespace
