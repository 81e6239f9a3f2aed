// SPDX-License-Identifier: BSD-3-Clause
#include "cli/recordings.hpp"

#include "cli/options.hpp"
#include "core/user_files.hpp"
#include "physics/bond_law_options.hpp"
#include "present/files.hpp"

#include <filesystem>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace culm::cli {

void add_recording_options(CLI::App& command, RecordingArguments& arguments, const char* paths,
                           const char* output, const char* window) {
    add_option(command, "measurements", arguments.paths, "MEASUREMENT", paths)->required();
    add_option(command, "--json", arguments.json, "FILE",
               "Write all results to this file (- for stdout)");
    add_option(command, "-o,--output", arguments.output, "DIR", output);
    command.add_flag("-q,--quiet", arguments.is_quiet, "Neither progress nor the next command");
    add_option(command, "--window", arguments.window_s, "SECONDS",
               fmt::format("{} only the first SECONDS after the release (default: all)", window))
        ->check(number_in({0.0, 1e6, true}));
}

void add_chain_options(CLI::App& command, RecordingArguments& arguments) {
    command
        .add_option("--law", arguments.law,
                    "Law of the bonds' damping: \"consistent\" (physical) or \"schramm2019\" (as "
                    "in the authors' code) (default: consistent)")
        ->check(CLI::IsMember(physics::law_names()));
    add_option(command, "--spheres", arguments.spheres, "N",
               "Spheres in the chain (default: as stem.toml says, else 56)")
        ->check(CLI::Range(5, 1000));
    command.add_flag("--details", arguments.with_details,
                     "Also print the tables that the answer is based on");
}

std::string next_step(const RecordingArguments& arguments, const std::string& command) {
    return arguments.is_quiet || command.empty() ? std::string() : next_step(command);
}

fit::ChainOptions chain_options(const RecordingArguments& arguments) {
    return {arguments.spheres, *physics::law_by_name(arguments.law)};
}

std::string chain_words(const RecordingArguments& arguments) {
    std::string text;
    if (arguments.law != RecordingArguments{}.law)
        text += " --law " + arguments.law;
    if (arguments.spheres)
        text += fmt::format(" --spheres {}", *arguments.spheres);
    if (arguments.window_s)
        text += fmt::format(" --window {}", *arguments.window_s);
    return text;
}

std::string model_words(const RecordingArguments& arguments,
                        const std::vector<std::string>& effects) {
    const std::string names = fmt::format("{}", fmt::join(effects, ","));
    return (names.empty() ? "" : " --with" + as_words({names})) + chain_words(arguments);
}

void write_results(const RecordingArguments& arguments,
                   std::span<const measure::Measurement> recordings, const std::string& file,
                   const nlohmann::json& document) {
    for (const measure::Measurement& recording : recordings)
        for (const std::string& remark : recording.remarks)
            print_note(remark);
    if (!arguments.json.empty())
        present::write_json(arguments.json, document);
    if (arguments.output.empty())
        return;
    core::create_folder(arguments.output);
    present::write_json((std::filesystem::path(arguments.output) / file).string(), document);
}

} // namespace culm::cli
