// SPDX-License-Identifier: BSD-3-Clause
// culm export liggghts|lammps CALIBRATION
#include "cli/calibration_json.hpp"
#include "cli/commands.hpp"
#include "core/file_text.hpp"

#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/core.h>

namespace culm::cli {
namespace {

struct BulkExportArguments {
    std::string code;
    std::string calibration;
    std::string stem;
    std::string output;
    std::vector<std::string> without;
};

void export_lines(const BulkExportArguments& arguments) {
    const std::string text = core::file_text(arguments.calibration);
    std::vector<calibrate::BulkStem> stems =
        bulk_stems(text, arguments.calibration, arguments.stem);
    calibrate::leave_out(stems, arguments.without);
    std::string lines;
    for (const calibrate::BulkStem& stem : stems)
        lines += (lines.empty() ? "" : "\n") + (arguments.code == "liggghts"
                                                    ? calibrate::liggghts_lines(stem)
                                                    : calibrate::lammps_lines(stem));
    if (arguments.output.empty()) {
        fmt::print("{}", lines);
        return;
    }
    std::ofstream out(arguments.output);
    out << lines;
    out.flush();
    if (!out)
        throw core::StorageError(fmt::format("{}: cannot be written", arguments.output));
}

} // namespace

void add_export_command(CLI::App& app) {
    CLI::App* command = app.add_subcommand(
        "export", "Write input lines for the bulk simulation from a calibration");
    auto arguments = std::make_shared<BulkExportArguments>();
    command
        ->add_option("code", arguments->code,
                     "\"liggghts\" (the authors' flexible fibres; law schramm2019) or \"lammps\" "
                     "(bond style bpm/rotational; law consistent)")
        ->required()
        ->type_name("CODE")
        ->check(CLI::IsMember({"liggghts", "lammps"}));
    command
        ->add_option("calibration", arguments->calibration, "File written by culm calibrate --json")
        ->required()
        ->type_name("CALIBRATION.json");
    command->add_option("--stem", arguments->stem, "Only the stem of this id (default: all)")
        ->type_name("ID");
    command
        ->add_option("--without", arguments->without,
                     "Leave these effects of the calibration out; \"added_mass\" stands for the "
                     "known masses. Without it an effect that CODE cannot express is refused")
        ->delimiter(',')
        ->type_name("EFFECT,...");
    command->add_option("-o,--output", arguments->output, "File to write (default: the screen)")
        ->type_name("FILE");
    command->callback([arguments] { export_lines(*arguments); });
}

} // namespace culm::cli
