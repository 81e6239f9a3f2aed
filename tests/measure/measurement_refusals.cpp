// SPDX-License-Identifier: BSD-3-Clause
// Messages of the reader of measurement folders for invalid files.
#include "measure/measurement_files.hpp"

#include <utility>
#include <vector>

#include <gtest/gtest.h>

namespace {

using namespace culm::tests;

void expect_contains(const std::string& text, const std::string& part) {
    EXPECT_NE(text.find(part), std::string::npos) << "in: " << text << "\nmissing: " << part;
}

const std::string header = "time_s,h=14mm,h=148mm\n";

TEST(DeflectionFile, RefusesOtherHeadersAndSaysWhatToWrite) {
    const std::vector<std::pair<std::string, std::string>> cases{
        {"time_s;h=14mm;h=148mm\n", "deflection.csv:1: cells are not separated by commas"},
        {"sep=;\ntime_s;h=14mm\n", "deflection.csv:1: cells are not separated by commas"},
        {"time_s\th=14mm\n", "not separated by commas"},
        {"time_s h=14mm\n", "not separated by commas"},
        {"time_s,h=14,h=148mm\n", "column \"h=14\": the unit is missing: write \"h=14mm\""},
        {"time_s,14,148\n", "column \"14\" must be a height with its unit: write \"h=14mm\""},
        {"time_s,h=1.4cm\n", "column \"h=1.4cm\": \"cm\" is not a unit known here; mm or m"},
        {"time_s,h=14mm,h=0.148m\n", "all heights must have one unit"},
        {"time_s,\"h=14,5mm\"\n", "column \"h=14,5mm\" has a decimal comma"},
        {"time_s,h=14mm,h=100mm,h=14.0mm\n", "column \"h=14.0mm\": column 2 has the same height"},
        {"time_s,h=14mm,h=158mm\n", "column \"h=158mm\" lies above the stem, which is 157 mm long"},
        {"time_s,h=-3mm\n", "column \"h=-3mm\" lies below the clamp"},
        {"time_s,tip\n", "column \"tip\" must be \"h=<height>mm\""},
        {"time_ms,h=14mm\n", "\"time_ms\": time must be in s: divide by 1000"},
        {"t,h=14mm\n", "\"t\": the first column must be \"time_s\""},
        {"h=14mm,time_s\n", "the column \"time_s\" must be the first"},
        {"0,0.18,17.5\n", "the file has no header"},
        {"time_s\n", "there is no height"},
        {"", "the file is empty"},
        {std::string("\xFF\xFEt\0i\0", 6), "the text is UTF-16"},
        {"PK\x03\x04...", "this is a workbook or an archive, not text"},
        {"time_s,h=14mm,h=148mm\n", "there are no lines after the header"}};
    for (const auto& [text, message] : cases)
        expect_contains(refusal_of_table(text), message);
}

TEST(DeflectionFile, BoundsTheNumberOfHeights) {
    std::string text = "time_s";
    for (int i = 0; i < 10001; ++i)
        text += ",h=" + std::to_string(0.001 * i) + "mm";
    expect_contains(refusal_of_table(text + "\n"),
                    "deflection.csv:1: 10001 heights; at most 10000 are allowed");
}

TEST(DeflectionFile, RefusesCellsThatASpreadsheetSpoiledAndSaysHow) {
    for (const std::string cell : {"\"17,6\"", "\"1,017.6\"", "#REF!", "#N/A", "=B2*2", "17. Jun",
                                   "17.06.2024", "17:36", "17.6mm",
                                   "\xE2\x88\x92"
                                   "17.6",
                                   "1'017.6", "1 017.6", "lost", "inf"}) {
        const std::string text = refusal_of_table(header + "0,0.1,0.2\n0.001,0.1," + cell + "\n");
        expect_contains(text, "deflection.csv:3: column 3: \"");
        expect_contains(text, "is not a number: write digits and one decimal point");
    }
}

TEST(DeflectionFile, RefusesLinesAndTimesThatDoNotFit) {
    const std::vector<std::pair<std::string, std::string>> cases{
        {"0,1,2\n0.001,1\n", "deflection.csv:3: has 2 cells, but the header has 3 columns"},
        {"0,0,18,17,5\n",
         "deflection.csv:2: has 5 cells, but the header has 3 columns (commas separate cells"},
        {"0;0.18;17.5\n", "(commas separate cells"},
        {"0,1,2\n0.002,1,2\n0.001,1,2\n",
         "deflection.csv:4: time 0.001 s does not come after 0.002 s"},
        {"0,1,2\n0,1,2\n", "deflection.csv:3: time 0 s does not come after 0 s"},
        {"0,1,2\n,1,2\n0.002,1,2\n", "deflection.csv:3: time \"\" is empty"},
        {"-0.002,1,2\n-0.001,1,2\n", "nothing was recorded after the release"},
        {"0,1,2\n0.001,1,200\n", "deflection.csv:3: column 3: a deflection of 0.2 m is more than"},
        {"0,1,\n0.001,1,\n", "column 3 is empty: delete it"},
        {"0,1,2\n0.001,1,2,3\n", "deflection.csv:3: has 4 cells"}};
    for (const auto& [lines, message] : cases)
        expect_contains(refusal_of_table(header + lines), message);
}

TEST(DeflectionFile, RefusesMillisecondsAndFrameNumbersIfTheCameraIsKnown) {
    const std::string stem = plain_stem + "[camera]\nfps = 960\n";
    expect_contains(refusal_of(stem, header + "0,1,2\n1.0417,1,2\n2.0833,1,2\n3.125,1,2\n"),
                    "which is a frame in ms at 960 frames/s: time_s must be in s");
    expect_contains(refusal_of(stem, header + "0,1,2\n1,1,2\n2,1,2\n3,1,2\n"),
                    "as frame numbers: divide them by 960");
}

TEST(DeflectionFile, ListsADozenFaultsAndCountsTheOthers) {
    std::string table = header;
    for (int i = 0; i < 20; ++i)
        table += "0.00" + std::to_string(10 + i) + ",x,1\n";
    const std::string text = refusal_of_table(table);
    expect_contains(text, "deflection.csv:2: column 2: \"x\" is not a number");
    expect_contains(text, "deflection.csv:13: ");
    expect_contains(text, "... and 8 more faults in deflection.csv");
}

TEST(StemFile, SaysWhichKeyIsWrongAndWhatIsAllowed) {
    const std::string section = "[section]\nshape = \"rectangle\"\n";
    const std::string no_diameter =
        "[stem]\nid = \"A\"\nlength_mm = 157.0\ndensity_kg_m3 = 125.0\n";
    const std::vector<std::pair<std::string, std::string>> cases{
        {"", "stem.toml:1: stem is missing"},
        {"[camera]\nfps = 960\n", "stem is missing: write a table [stem]"},
        {no_diameter, "stem.toml:1: stem.diameter_mm is missing: outer diameter"},
        {plain_stem + "wall_mm = 1.5\n",
         "stem.toml:6: stem.wall_mm = 1.5: must be below half the diameter, 1.415 mm"},
        {plain_stem + "lenght_mm = 3\n",
         "stem.toml:6: stem.lenght_mm = 3: unknown key (did you mean length_mm?)"},
        {"[stem]\nid = \"A\"\nlength_cm = 15.7\ndiameter_mm = 2.83\ndensity_kg_m3 = 125\n",
         "stem.length_cm = 15.7: unknown key: the unit is mm (write length_mm = 157)"},
        {"[stem]\nid = \"A\"\nlength_mm = 157,0\n", "(a decimal comma? write a point)"},
        {"[stem]\nid = \"A\"\nlength_mm = \"157\"\ndiameter_mm = 2.83\ndensity_kg_m3 = 125\n",
         "must be a number without quotes, with a decimal point"},
        {"[stem]\nid = \"A\"\nlength_mm = 157\ndiameter_mm = 2.83e-3\ndensity_kg_m3 = 125\n",
         "stem.diameter_mm = 0.00283: must be a number in [0.01, 10000]"},
        {"[stem]\nid = \"A\"\nlength_mm = 157\nlength_m = 0.157\ndiameter_mm = 2\ndensity_kg_m3 = "
         "125\n",
         "stem.length_m = 0.157: is given in addition to length_mm"},
        {plain_stem + section, "the file also has a [section]: remove one of them"},
        {no_diameter + section, "section.width_mm is missing: across the plane of motion"},
        {no_diameter + "[section]\nshape = \"rectangel\"\n", "(did you mean \"rectangle\"?)"},
        {no_diameter + section + "width_mm = 3\nheight_mm = 3\narea_mm2 = 9\n",
         "section.area_mm2 = 9: belongs to shape = \"general\""},
        {plain_stem + "[release]\nkind = \"pulled\"\n",
         "release.kind = \"pulled\": must be \"tip_pull\", \"held_straight\" or \"moving\""},
        {plain_stem + "[measurement]\nreading = \"rows\"\n", "(did you mean \"row\"?)"},
        {plain_stem + "[measurement]\nnoise_by_height_mm = [0.1]\n",
         "has 2 heights, but stem.toml gives noise_by_height for 1"},
        {plain_stem + "[measurement]\nholdtime_s = 3\n", "(did you mean hold_time_s?)"},
        {plain_stem + "[measurement]\nhold_time_s = -1\n",
         "measurement.hold_time_s = -1: must be a number in [0, 10000000]"},
        {plain_stem + "[measurment]\nnoise_mm = 1\n", "(did you mean measurement?)"},
        {plain_stem + "[[added_mass]]\nheight_mm = 160\nmass_g = 1\n",
         "stem.toml:7: added_mass.height_mm = 160: lies above the stem"},
        {plain_stem + "[added_mass]\nheight_mm = 16\nmass_g = 1\n", "write [[added_mass]]"}};
    for (const auto& [stem, message] : cases)
        expect_contains(refusal_of(stem, plain_table), message);
}

TEST(StemFile, RefusesAKeyInTheWrongPlaceAndNamesTheRightOne) {
    // These keys were once ignored with a note; for example, the fit then took rows for marks.
    const std::vector<std::pair<std::string, std::string>> cases{
        {plain_stem + "reading = \"material\"\n",
         "stem.toml:6: stem.reading = \"material\": unknown key: reading belongs into "
         "[measurement]"},
        {"reading = \"material\"\n" + plain_stem,
         "stem.toml:1: reading = \"material\": unknown key: reading belongs into [measurement]"},
        {plain_stem + "[[added_mass]]\nheight_mm = 9\nmass_g = 1\nnoise_mm = 0.1\n",
         "stem.toml:9: added_mass.noise_mm = 0.1: unknown key: noise_mm belongs into "
         "[measurement]"},
        {plain_stem + "[measurement]\nkind = \"held_straight\"\n",
         "measurement.kind = \"held_straight\": unknown key: kind belongs into [release]"},
        {plain_stem + "fps = 960\n", "stem.fps = 960: unknown key: fps belongs into [camera]"},
        {plain_stem + "mass_g = 1\n",
         "stem.mass_g = 1: unknown key: mass_g belongs into [[added_mass]]"},
        {plain_stem + "shape = \"rectangle\"\n",
         "stem.shape = \"rectangle\": unknown key: shape belongs into [section]"},
        {plain_stem + "[stem.camera]\nfps = 960\n", "write [camera]"},
        {plain_stem + "moisture = 5.8\n",
         "stem.toml:6: stem.moisture = 5.8: unknown key; allowed: id, "},
        {plain_stem + "[harvest]\nyear = 2018\n",
         "stem.toml:6: harvest: unknown table; allowed: section, stem, "},
        {plain_stem + "[measurement]\nnoise_source_mm = 3\n", "(did you mean noise_source?)"}};
    for (const auto& [stem, message] : cases)
        expect_contains(refusal_of(stem, plain_table), message);
}

TEST(StemFile, ChecksStatedUncertainties) {
    const std::string mass = "[[added_mass]]\nheight_mm = 9\nmass_g = 1\n";
    const std::vector<std::pair<std::string, std::string>> cases{
        {plain_stem + "length_uncertainty_mm = 0\n",
         "stem.toml:6: stem.length_uncertainty_mm = 0: must be a number in (0, 100000]"},
        {plain_stem + "length_uncertainty_mm = \"0.4\"\n", "must be a number without quotes"},
        {plain_stem + "length_expanded_uncertainty_mm = 0.8\n",
         "stem.coverage_factor is missing: ratio of length_expanded_uncertainty_mm to the standard "
         "uncertainty"},
        {plain_stem + "length_expanded_uncertainty_mm = 0.8\ncoverage_factor = 0.5\n",
         "stem.coverage_factor = 0.5: must be a number in [1, 10]"},
        {plain_stem + "length_limits_mm = [156.5, 157.5]\nlength_uncertainty_mm = 0.3\n",
         "stem.length_limits_mm = [156.5, 157.5]: is given in addition to length_uncertainty_mm"},
        {plain_stem + "length_limits_mm = [157.5, 156.5]\n",
         "must be [lowest, highest] with 157 between them"},
        {plain_stem + "length_limits_mm = [150, 151]\n", "with 157 between them"},
        {plain_stem + "density_uncertainty_kg_m3 = -1\n",
         "stem.density_uncertainty_kg_m3 = -1: must be a number in (0, 100000]"},
        {plain_stem + "clamp_uncertainty_mm = 0.2\n",
         "unknown key: clamp_uncertainty_mm belongs into [camera]"},
        {plain_stem + "[camera]\nscale_uncertainty = 4\n",
         "camera.scale_uncertainty = 4: must be a number in (0, 1]"},
        {plain_stem + "[camera]\nexposure_ms = -1\n", "must be a number in [0, 1000]"},
        {plain_stem + mass + "mass_uncertainty_g = 0\n",
         "added_mass.mass_uncertainty_g = 0: must be a number in (0, "},
        {plain_stem + "wall_uncertainty_mm = 0.1\n", "the file states no wall"},
        {plain_stem + "width_uncertainty_mm = 0.1\n",
         "unknown key: width_uncertainty_mm belongs into [section]"},
        {plain_stem + "rig = 3\n", "stem.rig = 3: must be a text in quotes"}};
    for (const auto& [stem, message] : cases)
        expect_contains(refusal_of(stem, plain_table), message);
}

TEST(MeasurementFolder, RefusesUncertaintiesOfOtherReadings) {
    const TemporaryFolder folder;
    write_file(folder / "stem.toml", plain_stem);
    write_file(folder / "deflection.csv", "time_s,h=10mm,h=20mm\n0,1,2\n0.1,,-1\n");
    const auto refused = [&](const std::string& table) {
        write_file(folder / "uncertainty.csv", table);
        return refusal([&] { static_cast<void>(culm::measure::read_measurement(folder.path())); });
    };
    expect_contains(refused("time_s,h=10mm,h=30mm\n0,1,2\n0.1,1,1\n"),
                    "uncertainty.csv: times and heights must be those of deflection.csv");
    expect_contains(refused("time_s,h=10mm,h=20mm\n0,1,0\n0.1,1,1\n"),
                    "uncertainty.csv: 0 mm at 0 s and 20 mm: every reading needs a standard "
                    "uncertainty above 0");
    expect_contains(refused("time_s,h=10mm,h=20mm\n0,1,1\n0.1,1,\n"),
                    "uncertainty.csv: nothing at 0.1 s and 20 mm");
    // A missing reading needs no uncertainty.
    write_file(folder / "uncertainty.csv", "time_s,h=10mm,h=20mm\n0,1,1\n0.1,,1\n");
    EXPECT_EQ(culm::measure::read_measurement(folder.path()).reading_uncertainties[1], 1e-3);
}

TEST(MeasurementFolder, RefusesAMissingFileByName) {
    const TemporaryFolder folder;
    write_file(folder / "stem.toml", plain_stem);
    expect_contains(
        refusal([&] { static_cast<void>(culm::measure::read_measurement(folder.path())); }),
        "there is no deflection.csv");
    expect_contains(
        refusal([&] { static_cast<void>(culm::measure::read_measurement(folder / "nothing")); }),
        "there is no such folder");
}

} // namespace
