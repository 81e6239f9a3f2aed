// SPDX-License-Identifier: BSD-3-Clause
#include "measure/folder/measurement_folder.hpp"

#include "measure/folder/measurement_files.hpp"
#include "measure/measurement_files.hpp"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <numbers>
#include <random>

#include <fmt/format.h>
#include <gtest/gtest.h>

namespace {

using namespace culm;
using namespace culm::measure;
using namespace culm::tests;

const std::filesystem::path examples = std::filesystem::path(CULM_TEST_DATA_DIR) / "measurements";

void expect_same(const Measurement& a, const Measurement& b) {
    EXPECT_EQ(a.stem.id, b.stem.id);
    EXPECT_EQ(a.stem.length, b.stem.length);
    EXPECT_EQ(a.stem.density, b.stem.density);
    EXPECT_EQ(a.stem.poissons_ratio, b.stem.poissons_ratio);
    EXPECT_EQ(a.stem.spheres, b.stem.spheres);
    EXPECT_EQ(a.stem.section.index(), b.stem.section.index());
    EXPECT_EQ(section_area(a.stem.section), section_area(b.stem.section));
    EXPECT_EQ(second_moment_of_area(a.stem.section), second_moment_of_area(b.stem.section));
    ASSERT_EQ(a.stem.added_masses.size(), b.stem.added_masses.size());
    for (std::size_t i = 0; i < a.stem.added_masses.size(); ++i) {
        EXPECT_EQ(a.stem.added_masses[i].height, b.stem.added_masses[i].height);
        EXPECT_EQ(a.stem.added_masses[i].mass, b.stem.added_masses[i].mass);
        EXPECT_EQ(a.stem.added_masses[i].mass_uncertainty, b.stem.added_masses[i].mass_uncertainty);
    }
    EXPECT_EQ(a.uncertainties.length, b.uncertainties.length);
    EXPECT_EQ(a.uncertainties.diameter, b.uncertainties.diameter);
    EXPECT_EQ(a.uncertainties.wall, b.uncertainties.wall);
    EXPECT_EQ(a.uncertainties.section_width, b.uncertainties.section_width);
    EXPECT_EQ(a.uncertainties.section_height, b.uncertainties.section_height);
    EXPECT_EQ(a.uncertainties.section_area, b.uncertainties.section_area);
    EXPECT_EQ(a.uncertainties.second_moment, b.uncertainties.second_moment);
    EXPECT_EQ(a.uncertainties.density, b.uncertainties.density);
    EXPECT_EQ(a.uncertainties.frames_per_second, b.uncertainties.frames_per_second);
    EXPECT_EQ(a.uncertainties.scale, b.uncertainties.scale);
    EXPECT_EQ(a.uncertainties.clamp, b.uncertainties.clamp);
    EXPECT_EQ(a.specimen, b.specimen);
    EXPECT_EQ(a.rig, b.rig);
    EXPECT_EQ(a.exposure, b.exposure);
    EXPECT_EQ(a.row_time, b.row_time);
    EXPECT_EQ(a.release, b.release);
    EXPECT_EQ(a.gravity_direction, b.gravity_direction);
    EXPECT_EQ(a.reading, b.reading);
    EXPECT_EQ(a.hold_time, b.hold_time);
    EXPECT_EQ(a.frames_per_second, b.frames_per_second);
    EXPECT_EQ(a.noise, b.noise);
    EXPECT_EQ(a.noise_by_height, b.noise_by_height);
    EXPECT_EQ(a.noise_source, b.noise_source);
    EXPECT_EQ(a.times, b.times);
    EXPECT_EQ(a.heights, b.heights);
    ASSERT_EQ(a.deflections.size(), b.deflections.size());
    for (std::size_t i = 0; i < a.deflections.size(); ++i)
        EXPECT_TRUE(a.deflections[i] == b.deflections[i] ||
                    (std::isnan(a.deflections[i]) && std::isnan(b.deflections[i])))
            << i;
}

/// Numbers with all their digits, as a tracker computes them.
Measurement computed(const Section& section, bool is_shifted) {
    std::mt19937_64 random(11);
    std::uniform_real_distribution<double> share(0.1, 0.9);
    Measurement measurement;
    measurement.stem = {.id = "B \"2\" \\ ä",
                        .length = 0.1 + 0.01 * share(random),
                        .section = section,
                        .density = 1070.0 * share(random),
                        .poissons_ratio = 0.499,
                        .spheres = 41,
                        .added_masses = {{0.05 * share(random), 1e-3 * share(random)}}};
    measurement.release = is_shifted ? ReleaseKind::HeldStraight : ReleaseKind::TipPull;
    measurement.gravity_direction =
        is_shifted ? GravityDirection::Transverse : GravityDirection::Axial;
    measurement.reading = is_shifted ? Reading::Material : Reading::Row;
    if (is_shifted)
        measurement.hold_time = 10.0 * share(random);
    measurement.frames_per_second = 1000.0 / 3.0;
    measurement.stem.added_masses[0].mass_uncertainty = 1e-5 * share(random);
    measurement.uncertainties.length = 1e-3 * share(random);
    measurement.uncertainties.density = share(random);
    measurement.uncertainties.scale = share(random);
    measurement.uncertainties.clamp = 1e-3 * share(random);
    if (const auto* circle = std::get_if<CircularSection>(&section)) {
        measurement.uncertainties.diameter = 1e-5 * share(random);
        if (circle->wall)
            measurement.uncertainties.wall = 1e-5 * share(random);
    } else if (std::holds_alternative<RectangularSection>(section)) {
        measurement.uncertainties.section_width = 1e-5 * share(random);
        measurement.uncertainties.section_height = 1e-5 * share(random);
    } else {
        measurement.uncertainties.section_area = 1e-8 * share(random);
        measurement.uncertainties.second_moment = 1e-14 * share(random);
    }
    measurement.specimen = "S\"07\"";
    measurement.rig = "A";
    measurement.exposure = 5e-4;
    measurement.row_time = 1.1e-5;
    measurement.noise = 1e-5 * share(random);
    measurement.noise_source = "40 frames at rest";
    for (int i = 0; i < 40; ++i)
        measurement.times.push_back((i - 5) / (1000.0 / 3.0));
    for (int j = 0; j < 4; ++j) {
        measurement.heights.push_back(0.02 * (j + share(random)));
        measurement.noise_by_height.push_back(1e-5 * share(random));
    }
    for (int i = 0; i < 160; ++i)
        measurement.deflections.push_back(i % 7 == 3 ? std::numeric_limits<double>::quiet_NaN()
                                                     : 0.02 * (share(random) - 0.5));
    return measurement;
}

TEST(MeasurementFolder, ReadsTheLaboratorysFormat) {
    const Measurement measurement = read_measurement(examples / "T1-null");
    EXPECT_EQ(measurement.stem.id, "T1");
    EXPECT_EQ(measurement.stem.length, 0.157);
    EXPECT_EQ(std::get<CircularSection>(measurement.stem.section).diameter, 2.83e-3);
    EXPECT_FALSE(std::get<CircularSection>(measurement.stem.section).wall);
    EXPECT_EQ(measurement.stem.density, 125.0);
    EXPECT_EQ(measurement.frames_per_second, 960.0);
    EXPECT_EQ(measurement.noise, 5e-5);
    EXPECT_EQ(measurement.gravity_direction, GravityDirection::Axial);
    EXPECT_EQ(measurement.reading, Reading::Row);
    EXPECT_EQ(measurement.release, ReleaseKind::TipPull);
    ASSERT_EQ(measurement.heights.size(), 10U);
    EXPECT_EQ(measurement.heights[9], 0.148);
    EXPECT_EQ(measurement.times[0], -0.00625);
    EXPECT_EQ(measurement.deflection(0, 9), 17.6338e-3);
    EXPECT_EQ(measurement.remarks, std::vector<std::string>{});
}

TEST(MeasurementFolder, WrittenAndReadAgainIsTheSameBitForBit) {
    const std::vector<Section> sections{
        CircularSection{2.83e-3 / 3.0, {}}, CircularSection{2.83e-3, 0.34e-3 / 7.0},
        RectangularSection{0.03, 0.01 / 3.0}, GeneralSection{1e-6 / 3.0, 1e-13 / 7.0}};
    for (const Section& section : sections)
        for (const bool is_shifted : {false, true}) {
            const TemporaryFolder folder;
            const Measurement written = computed(section, is_shifted);
            write_measurement(folder.path(), written);
            expect_same(written, read_measurement(folder.path()));
        }
}

TEST(MeasurementFolder, WrittenNumbersAreAsShortAsTheyCanBe) {
    const TemporaryFolder folder;
    write_measurement(folder.path(), read_texts(plain_stem, plain_table));
    EXPECT_EQ(file_text(folder / "deflection.csv"), plain_table);
    EXPECT_EQ(file_text(folder / "stem.toml"),
              "[stem]\nid = \"A\"\nlength_mm = 157\ndiameter_mm = 2.83\ndensity_kg_m3 = 125\n\n"
              "[release]\nkind = \"tip_pull\"\n\n[measurement]\ngravity_direction = \"none\"\n"
              "reading = \"row\"\n");
}

TEST(MeasurementFolder, SortsHeightsAndTheirNoise) {
    const Measurement measurement =
        read_texts(plain_stem + "[measurement]\nnoise_by_height_mm = [0.3, 0.1, 0.2]\n",
                   "time_s,h=148mm,h=14mm,h=100mm\n0,3,1,2\n0.001,,11,12\n");
    EXPECT_EQ(measurement.heights, (std::vector<double>{0.014, 0.1, 0.148}));
    EXPECT_EQ(measurement.noise_by_height, (std::vector<double>{1e-4, 2e-4, 3e-4}));
    EXPECT_EQ(measurement.deflection(0, 0), 1e-3);
    EXPECT_EQ(measurement.deflection(1, 1), 12e-3);
    EXPECT_TRUE(std::isnan(measurement.deflection(1, 2)));
}

TEST(MeasurementFolder, UnitOfTheHeaderIsThatOfTheDeflections) {
    const Measurement measurement =
        read_texts(plain_stem, "time_s,h=0.014m,h=0.148m\n0,0.0001,0.0176\n0.001,0,0\n");
    EXPECT_EQ(measurement.heights, (std::vector<double>{0.014, 0.148}));
    EXPECT_EQ(measurement.deflection(0, 1), 0.0176);
}

TEST(MeasurementFolder, AcceptsHarmlessAdditionsOfSpreadsheets) {
    const Measurement expected = read_texts(plain_stem, plain_table);
    const std::string bom = "\xEF\xBB\xBF";
    expect_same(expected, read_texts(bom + plain_stem, bom + plain_table));
    expect_same(expected,
                read_texts(plain_stem, "time_s,h=14mm,h=148mm,,\r\n-0.001,0.182,17.6,,\r\n"
                                       "0,\"0.18\", 17.5 ,,\r\n0.001,0.17,NaN,,\r\n,,,,\r\n\r\n"));
    expect_same(expected, read_texts(plain_stem, "# tracked by hand\n" + plain_table));
}

TEST(MeasurementFolder, RemarksOnACameraThatDisagrees) {
    const Measurement measurement = read_texts(plain_stem + "[camera]\nfps = 700\n", plain_table);
    ASSERT_EQ(measurement.remarks.size(), 1U);
    EXPECT_NE(measurement.remarks[0].find("fps = 700 means 0.00142857 s"), std::string::npos);
}

/// Four statements of the mass of a round stem of 157 mm and 2.83 mm.
TEST(MeasurementFolder, TakesTheMassInFourForms) {
    const auto stem_with = [](const std::string& keys) {
        std::string text = plain_stem;
        const std::string density = "density_kg_m3 = 125.0";
        return read_texts(text.replace(text.find(density), density.size(), keys), plain_table);
    };
    // A chain of touching spheres of the density ρ has π ρ d²/6 per length, a rod π ρ d²/4.
    const double per_length = 125.0 * std::numbers::pi / 6.0 * 2.83e-3 * 2.83e-3;
    for (const std::string& keys :
         {fmt::format("linear_density_kg_m = {}\nlinear_density_uncertainty_kg_m = {}\n",
                      per_length, 0.01 * per_length),
          fmt::format("material_density_kg_m3 = {}\nmaterial_density_uncertainty_kg_m3 = {}\n",
                      125.0 / 1.5, 1.25 / 1.5),
          fmt::format("mass_mg = {}\nmass_uncertainty_mg = {}\n", 0.157e6 * per_length,
                      0.00157e6 * per_length)}) {
        const Measurement measurement = stem_with(keys);
        EXPECT_NEAR(mass_per_length(measurement.stem), per_length, 1e-12) << keys;
        EXPECT_NEAR(measurement.uncertainties.density.value_or(0.0), 1.25, 1e-9) << keys;
    }
    EXPECT_NE(refusal([&] {
                  static_cast<void>(stem_with("mass_mg = 1\ndensity_kg_m3 = 125\n"));
              }).find("one of them is enough"),
              std::string::npos);
    EXPECT_NE(refusal([&] { static_cast<void>(stem_with("")); }).find("material_density_kg_m3"),
              std::string::npos);
}

TEST(MeasurementFolder, TakesStatedUncertaintiesInEachForm) {
    const auto length_of = [](const std::string& keys) {
        return read_texts(plain_stem + keys, plain_table).uncertainties.length.value_or(-1.0);
    };
    EXPECT_EQ(length_of("length_uncertainty_mm = 0.4\n"), 4e-4);
    EXPECT_EQ(length_of("length_uncertainty_m = 0.0004\n"), 4e-4);
    EXPECT_DOUBLE_EQ(length_of("length_expanded_uncertainty_mm = 0.8\ncoverage_factor = 2\n"),
                     4e-4);
    EXPECT_NEAR(length_of("length_limits_mm = [156.5, 157.5]\n"), 5e-4 / std::sqrt(3.0), 1e-15);
    EXPECT_EQ(length_of(""), -1.0);
    const Measurement in_kg =
        read_texts(plain_stem + "[[added_mass]]\nheight_mm = 9\nmass_kg = 1e-3\n"
                                "mass_limits_kg = [0.9e-3, 1.1e-3]\n",
                   plain_table);
    EXPECT_NEAR(in_kg.stem.added_masses.at(0).mass_uncertainty.value_or(0.0), 1e-4 / std::sqrt(3.0),
                1e-15);
    const Measurement all = read_texts(
        plain_stem + "diameter_uncertainty_mm = 0.02\ndensity_uncertainty_kg_m3 = 1.3\n"
                     "specimen = \"S07\"\nrig = \"A\"\n[[added_mass]]\nheight_mm = 156\n"
                     "mass_g = 0.05\nmass_uncertainty_g = 0.0005\n[camera]\nfps_uncertainty = 0.0\n"
                     "scale_uncertainty = 0.004\nclamp_uncertainty_mm = 0.2\nexposure_ms = 0.5\n"
                     "row_time_us = -20\nrow_height_mm = 0.4\n",
        plain_table);
    EXPECT_EQ(all.uncertainties.diameter, 2e-5);
    EXPECT_EQ(all.uncertainties.density, 1.3);
    EXPECT_EQ(all.uncertainties.frames_per_second, 0.0);
    EXPECT_EQ(all.uncertainties.scale, 0.004);
    EXPECT_EQ(all.uncertainties.clamp, 2e-4);
    EXPECT_EQ(all.stem.added_masses.at(0).mass_uncertainty, 5e-7);
    EXPECT_EQ(all.exposure, 5e-4);
    EXPECT_EQ(all.row_time, -2e-5);
    EXPECT_EQ(all.row_height, 4e-4);
    EXPECT_EQ(all.specimen, "S07");
    EXPECT_EQ(all.rig, "A");
    EXPECT_TRUE(all.remarks.empty()); // the fit uses all of them
    const Measurement without =
        read_texts(plain_stem + "[camera]\nrow_time_us = 20\n", plain_table);
    ASSERT_EQ(without.remarks.size(), 1U);
    EXPECT_NE(without.remarks.front().find("without row_height_mm"), std::string::npos);
}

TEST(MeasurementFolder, KeepsTheZerosAtTheEndOfAMass) {
    for (const std::string mass : {"0.050", "0.05", "2", "2.0", "0.00074338"}) {
        const Measurement read = read_texts(
            plain_stem + "[[added_mass]]\nheight_mm = 156\nmass_g = " + mass + "\n", plain_table);
        EXPECT_NE(stem_file_text(read).find("\nmass_g = " + mass + "\n"), std::string::npos)
            << mass;
    }
}

TEST(MeasurementFolder, ReadsARigWithStatedUncertainties) {
    const MeasurementSet set = read_measurements({std::string(CULM_TEST_DATA_DIR) + "/lab-rig"});
    ASSERT_EQ(set.measurements.size(), 12U);
    for (const Measurement& measurement : set.measurements) {
        EXPECT_EQ(measurement.rig, "R");
        EXPECT_EQ(measurement.uncertainties.length, 4e-4);
        EXPECT_TRUE(measurement.remarks.empty());
    }
}

/// A folder with three frames and this table [release].
std::filesystem::path folder_with_release(const TemporaryFolder& folder,
                                          const std::string& release) {
    std::ofstream(folder.path() / "stem.toml")
        << "[stem]\nid = \"S\"\nlength_mm = 150\ndiameter_mm = 3\ndensity_kg_m3 = 120\n"
        << "[release]\n"
        << release;
    std::ofstream(folder.path() / "deflection.csv") << "time_s,h=50mm,h=100mm\n"
                                                       "0,1,2\n0.001,3,4\n0.002,5,6\n";
    return folder.path();
}

TEST(MeasurementFolder, BeginsAtTheStartOfARecordingInMotion) {
    const TemporaryFolder folder;
    const Measurement measurement =
        read_measurement(folder_with_release(folder, "kind = \"moving\"\nstart_s = 0.0005\n"));
    EXPECT_EQ(measurement.release, ReleaseKind::Moving);
    ASSERT_EQ(measurement.times.size(), 2U);
    EXPECT_NEAR(measurement.times[0], 0.0005, 1e-12);
    EXPECT_NEAR(measurement.times[1], 0.0015, 1e-12);
    EXPECT_EQ(measurement.deflections.size(), 4U);
    EXPECT_NEAR(measurement.deflection(0, 0), 3e-3, 1e-12);
}

TEST(MeasurementFolder, RefusesAMeaninglessStart) {
    const TemporaryFolder folder;
    EXPECT_NE(refusal([&] {
                  static_cast<void>(read_measurement(
                      folder_with_release(folder, "kind = \"tip_pull\"\nstart_s = 0.001\n")));
              }).find("only a release of kind = \"moving\" has a start"),
              std::string::npos);
    EXPECT_NE(refusal([&] {
                  static_cast<void>(read_measurement(
                      folder_with_release(folder, "kind = \"moving\"\nstart_s = 0.002\n")));
              }).find("[release] start_s = 0.002 leaves 1 frames of 3"),
              std::string::npos);
}

TEST(MeasurementFolder, IsFoundAloneOrInAFolderOfStems) {
    EXPECT_EQ(find_measurements(examples / "S01"), std::vector{examples / "S01"});
    EXPECT_EQ(find_measurements(examples),
              (std::vector{examples / "S01", examples / "S10", examples / "T1-null"}));
    const TemporaryFolder empty;
    EXPECT_NE(refusal([&] {
                  static_cast<void>(find_measurements(empty.path()));
              }).find("neither this folder nor a folder in it holds a deflection.csv"),
              std::string::npos);
}

TEST(MeasurementFolder, IsReadAfterWriting) {
    const TemporaryFolder folder;
    Measurement measurement = read_texts(plain_stem, plain_table);
    measurement.times[1] = measurement.times[0];
    EXPECT_NE(
        refusal([&] { write_measurement(folder.path(), measurement); }).find("times must ascend"),
        std::string::npos);
    EXPECT_THROW(write_measurement("/proc/no-such-folder", read_texts(plain_stem, plain_table)),
                 core::StorageError);
}

TEST(MeasurementFolder, StoresAnUncertaintyOfEveryReading) {
    const TemporaryFolder folder;
    Measurement measurement = computed(CircularSection{0.003, std::nullopt}, false);
    for (std::size_t at = 0; at < measurement.deflections.size(); ++at)
        measurement.reading_uncertainties.push_back(1e-6 * static_cast<double>(at + 1));
    measurement.uncertainties.row = 8e-6;
    write_measurement(folder.path(), measurement);
    const Measurement read = read_measurement(folder.path());
    EXPECT_EQ(read.reading_uncertainties, measurement.reading_uncertainties);
    EXPECT_EQ(read.uncertainties.row, measurement.uncertainties.row);
    // Writing a measurement without uncertainties removes the earlier ones.
    measurement.reading_uncertainties.clear();
    write_measurement(folder.path(), measurement);
    EXPECT_TRUE(read_measurement(folder.path()).reading_uncertainties.empty());
}

TEST(MeasuredStem, WeighsAsAChainOfSpheresIfRoundAndAsItsSectionOtherwise) {
    MeasuredStem stem = read_texts(plain_stem, plain_table).stem;
    EXPECT_DOUBLE_EQ(mass_per_length(stem), 125.0 * std::numbers::pi / 6.0 * 2.83e-3 * 2.83e-3);
    stem.section = RectangularSection{0.03, 0.02};
    EXPECT_DOUBLE_EQ(mass_per_length(stem), 125.0 * 6e-4);
    EXPECT_DOUBLE_EQ(second_moment_of_area(stem.section), 0.03 * 8e-6 / 12.0);
    EXPECT_DOUBLE_EQ(section_depth(stem.section), 0.02);
    EXPECT_DOUBLE_EQ(section_depth(GeneralSection{6e-4, 0.03 * 8e-6 / 12.0}), 0.02);
}

TEST(MeasuredStem, HollowSectionLosesItsCore) {
    const MeasuredStem stem = read_texts(plain_stem + "wall_mm = 0.34\n", plain_table).stem;
    const double inner = 2.83e-3 - 0.68e-3;
    EXPECT_NEAR(section_area(stem.section),
                std::numbers::pi / 4.0 * (2.83e-3 * 2.83e-3 - inner * inner), 1e-20);
}

} // namespace
