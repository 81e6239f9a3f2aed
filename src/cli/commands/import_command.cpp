// SPDX-License-Identifier: BSD-3-Clause
// culm import MAPPING.toml -o DIR, culm import RECORDING -o DIR
#include "cli/options.hpp"
#include "cli/provenance.hpp"
#include "measure/folder/measurement_folder.hpp"
#include "measure/import/import_recording.hpp"
#include "present/text.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>

#include <fmt/format.h>

namespace culm::cli {
namespace {

struct ImportArguments {
    std::string mapping;
    std::string recording;
    std::string output;
};

std::string time_gaps_text(const measure::TimeGaps& gaps) {
    return gaps.count == 0 ? "no gap in time"
                           : fmt::format("{} in time, the longest {:.4g} ms at {:.6g} s",
                                         present::counted(gaps.count, "gap"), 1e3 * gaps.longest,
                                         gaps.begin_of_longest);
}

void import_measurement(const ImportArguments& arguments) {
    if (!arguments.mapping.ends_with(".toml"))
        run_python_program("propose_import.py", {arguments.mapping, "--output", arguments.output},
                           "it proposes a mapping for a recording");
    const measure::ImportMapping mapping =
        measure::read_import_mapping(arguments.mapping, arguments.recording);
    if (measure::needs_conversion(mapping.source)) { // to a table, which is then imported
        const auto table = (std::filesystem::path(arguments.output) / "recording.csv").string();
        run_python_program("recording_table.py",
                           {mapping.source.string(), "--output", table, "--then",
                            own_program().string(), "import", arguments.mapping, "--recording",
                            table, "--output", arguments.output},
                           "it converts this recording to a table");
    }
    const measure::Measurement measurement = measure::import_recording(mapping);
    measure::write_measurement(arguments.output, measurement);
    for (const std::string& remark : measurement.remarks)
        print_note(remark);
    const auto before =
        std::ranges::count_if(measurement.times, [](double time) { return time < 0.0; });
    const auto missing = std::ranges::count_if(measurement.deflections,
                                               [](double value) { return std::isnan(value); });
    fmt::print("{}: {}, {} frames ({} before the release), {} readings missing; {}\n",
               arguments.output, present::counted(measurement.heights.size(), "height"),
               measurement.times.size(), before, missing,
               time_gaps_text(measure::time_gaps(measurement.times)));
    for (std::size_t j = 0; j < measurement.heights.size(); ++j) {
        double largest = 0.0;
        for (const double value : measurement.history(j))
            if (!std::isnan(value))
                largest = std::max(largest, std::abs(value));
        const bool is_camera = measure::is_of_camera(measurement.sensors, j);
        const auto noise = is_camera ? measurement.noise_at(j) : measurement.sensors[j].noise;
        const measure::ReadingUnit unit = is_camera
                                              ? measure::ReadingUnit()
                                              : measure::reading_unit({&measurement.sensors[j], 1});
        fmt::print("  h = {:g} mm: largest {} {}, noise {}\n", 1e3 * measurement.heights[j],
                   is_camera ? "deflection" : to_string(measurement.sensors[j].quantity),
                   unit.text(largest, 3), noise ? unit.text(*noise) : "unknown");
    }
    if (!measurement.noise_source.empty())
        fmt::print("  noise: {}\n", measurement.noise_source);
}

} // namespace

void add_import_command(CLI::App& app) {
    CLI::App* command = app.add_subcommand(
        "import", "Make a measurement folder from a recording of another program");
    auto arguments = std::make_shared<ImportArguments>();
    add_option(*command, "mapping", arguments->mapping, "MAPPING.toml",
               "What the recording's columns or markers are (docs/measurements.md); of a "
               "recording itself (.csv, .trk, .mat, ...) a mapping is proposed")
        ->required();
    add_option(*command, "--recording", arguments->recording, "FILE",
               "The recording, instead of the one that the mapping names");
    add_option(*command, "-o,--output", arguments->output, "DIR", "Measurement folder to write")
        ->required();
    command->callback([arguments] { import_measurement(*arguments); });
}

} // namespace culm::cli
