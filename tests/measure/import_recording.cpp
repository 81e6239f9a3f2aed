// SPDX-License-Identifier: BSD-3-Clause
#include "measure/import/import_recording.hpp"

#include "measure/measurement_files.hpp"

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

/// Markers as a converted C3D file has them, m.
std::string recording() {
    std::string text = "t";
    for (const char* marker : {"base", "tip 1", "tip 2"})
        text += fmt::format(",{0} x,{0} y,{0} z", marker);
    for (int i = 0; i < 200; ++i) {
        const double time = i / 200.0;
        const double shake = 0.5 * std::sin(40.0 * time); // mm, motion of the whole set-up
        const double x = level - travel(time) + unevenness(i) + shake;
        text += fmt::format("\n{}", time);
        for (const double value : {level + shake, 3.0, 0.0, x + 5.0, 3.0, 90.0, x - 5.0, 3.0, 95.0})
            text += fmt::format(",{}", 1e-3 * value);
    }
    return text + "\n";
}

const std::string marker_mapping =
    square_stem + "[source]\nfile = \"a.csv\"\n[time]\nrelease_s = 0.2512\nbefore_s = 0.1\n"
                  "after_s = 0.5\n[motion]\naxis = [-2, 0, 0]\nzero = \"before_release\"\n"
                  "[clamp]\nmarkers = \"base\"\n[[height]]\nheight_mm = 100\n"
                  "markers = [\"tip 1\", \"tip 2\"]\n";

TEST(ImportRecording, TakesMarkersAlongAnAxisLessTheMotionOfTheClamp) {
    const Measurement measurement = import_text(marker_mapping, "a.csv", recording());
    EXPECT_NEAR(*measurement.frames_per_second, 200.0, 1e-6);
    ASSERT_EQ(measurement.times.size(), 120U);
    EXPECT_GE(measurement.times.front(), -0.1);
    EXPECT_LE(measurement.times.back(), 0.5);
    for (std::size_t i = 0; i < measurement.times.size(); ++i)
        EXPECT_NEAR(measurement.deflection(i, 0), 1e-3 * travel(measurement.times[i] + release),
                    2e-5); // the unevenness, its mean, and floats of 50 mm
}

const std::string accelerometer_mapping =
    square_stem.substr(0, square_stem.find("[release]")) +
    "[release]\nkind = \"moving\"\n[source]\nfile = \"a.csv\"\n[time]\ncolumn = \"t\"\n"
    "[[sensor]]\ncolumn = \"acc (g)\"\nquantity = \"acceleration\"\nunit = \"g\"\n"
    "height_mm = 90\nmass_g = 5\n";

TEST(ImportRecording, KeepsTheColumnsOfSensorsInSiUnits) {
    const Measurement measurement =
        import_text(accelerometer_mapping, "a.csv", "t,acc (g)\n5,1\n5.1,-2\n5.3,0.5\n");
    ASSERT_EQ(measurement.sensors.size(), 1U);
    EXPECT_EQ(measurement.sensors.front().column, "acc");
    EXPECT_EQ(measurement.stem.added_masses.front().sensor, "acc");
    EXPECT_EQ(measurement.heights, std::vector<double>{0.09});
    EXPECT_EQ(measurement.times, (std::vector{5.0, 5.1, 5.3}));
    EXPECT_NEAR(measurement.deflection(1, 0), -2.0 * 9.80665, 1e-9);
}

TEST(ImportRecording, SortsHeightsAndSensorsTogether) {
    std::string mapping = table_mapping + "[[sensor]]\ncolumn = \"5\"\nquantity = \"velocity\"\n"
                                          "unit = \"mm/s\"\nheight_mm = 70\n";
    std::string text = table(',', false);
    for (std::size_t end = text.find('\n'); end != std::string::npos;
         end = text.find('\n', end + 4))
        text.insert(end, end < 30 ? ",v" : end % 2 == 0 ? ",12" : ",12.5");
    const Measurement measurement = import_text(mapping, "a.txt", text);
    EXPECT_EQ(measurement.heights, (std::vector{0.05, 0.07, 0.1}));
    EXPECT_TRUE(measurement.sensors[0].is_camera());
    EXPECT_NEAR(measurement.deflection(7, 1), 0.01225, 0.00026);
    EXPECT_NEAR(measurement.deflection(60, 2), 1e-3 * travel(60 / 200.0), 1.5e-5);
    EXPECT_NEAR(*measurement.noise, 0.01e-3 / std::numbers::sqrt2, 1e-6);
}

/// A hand that drifts by 3 mm before it releases a swing of 20 mm at 5 Hz, with noise, mm. The
/// release changes neither position nor velocity.
ReleaseOnset onset_after_drift(double release_time, unsigned seed) {
    constexpr double turn = 0.5 * std::numbers::pi;       // of the hand, 1/s
    constexpr double frequency = 10.0 * std::numbers::pi; // of the swing, 1/s
    const double position = 20.0 + 3.0 * std::sin(turn * release_time);
    const double velocity = 3.0 * turn * std::cos(turn * release_time);
    std::mt19937 dice(seed);
    std::normal_distribution<double> noise(0.0, 0.03);
    std::vector<double> times;
    std::vector<double> positions;
    for (int i = 0; i < 400; ++i) {
        const double time = i / 200.0;
        const double since = time - release_time;
        const double swing =
            std::exp(-since) * (position * std::cos(frequency * since) +
                                (velocity + position) / frequency * std::sin(frequency * since));
        times.push_back(time);
        positions.push_back(noise(dice) +
                            (since < 0.0 ? 20.0 + 3.0 * std::sin(turn * time) : swing));
    }
    const std::optional<ReleaseOnset> onset = release_onset(times, positions);
    EXPECT_TRUE(onset);
    return onset.value_or(ReleaseOnset());
}

TEST(ReleaseOnset, IsFoundAfterASlowDriftWithinItsUncertainty) {
    int outside = 0;
    for (unsigned seed = 1; seed <= 40; ++seed) {
        const double release_time = 0.6 + 0.00131 * seed; // at any place between two frames
        const ReleaseOnset onset = onset_after_drift(release_time, seed);
        EXPECT_NEAR(onset.time, release_time, 5e-3); // a frame
        EXPECT_LT(onset.uncertainty, 4e-3);
        outside += std::abs(onset.time - release_time) > 3.0 * onset.uncertainty ? 1 : 0;
    }
    EXPECT_LE(outside, 4);
}

TEST(ReleaseOnset, NeedsFramesBeforeTheMotion) {
    std::vector<double> times;
    std::vector<double> positions;
    for (int i = 0; i < 100; ++i) {
        times.push_back(i / 100.0);
        positions.push_back(std::sin(10.0 * times.back()));
    }
    EXPECT_FALSE(release_onset(times, positions));
}

TEST(ImportRecording, ReportsMistakesWithTheNearestName) {
    const auto complaint = [](std::string mapping, const std::string& from, const std::string& to,
                              const std::string& name, const std::string& content) {
        mapping.replace(mapping.find(from), from.size(), to);
        return refusal([&] { static_cast<void>(import_text(mapping, name, content)); });
    };
    const std::string markers = recording();
    EXPECT_NE(complaint(marker_mapping, "tip 2", "tip2", "a.csv", markers)
                  .find("there is no marker \"tip2\" (did you mean \"tip 2\"?)"),
              std::string::npos);
    EXPECT_NE(complaint(marker_mapping, "0.2512", "7", "a.csv", markers)
                  .find("nothing was recorded after the release"),
              std::string::npos);
    EXPECT_NE(complaint(marker_mapping, "axis = [-2, 0, 0]", "", "a.csv", markers).find("markers"),
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

} // namespace
