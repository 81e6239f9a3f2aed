// SPDX-License-Identifier: BSD-3-Clause
#include "cli/recordings.hpp"

#include "cli/options.hpp"
#include "core/user_files.hpp"
#include "fit/chain/stem_chain.hpp"
#include "physics/bond_law_options.hpp"
#include "present/files.hpp"
#include "present/text.hpp"
#include "study/execute/plan.hpp"

#include <filesystem>
#include <numeric>

#include <fmt/format.h>

namespace culm::cli {
namespace {

/// Simulations of a stem of lab-rig, from the times with 3 and with 21 candidates.
constexpr double simulations_for_fits = 1300.0;
constexpr double simulations_for_candidate = 55.0;
// Of a rod with 2050 readings and a strip with 250 000.
constexpr double simulations_for_calibration = 1000.0;
constexpr double seconds_per_time = 2e-4;
constexpr double seconds_per_reading = 5e-5;

double simulation_seconds(const measure::Measurement& recording, const fit::ChainOptions& chain) {
    run::CaseSpec spec = fit::chain_of(recording, chain).spec;
    spec.duration = recording.times.back();
    return study::estimated_seconds(spec);
}

} // namespace

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

std::string cost_text(const std::vector<double>& seconds, int ranks) {
    const double sum = std::accumulate(seconds.begin(), seconds.end(), 0.0);
    return fmt::format("{}: about {} of processor time on the reference machine, {} on {}",
                       present::counted(seconds.size(), "stem"), present::estimate_text(sum),
                       present::estimate_text(sum / ranks), present::counted(ranks, "rank"));
}

double expected_seconds(const measure::Measurement& recording, const fit::ChainOptions& chain) {
    return simulations_for_calibration * simulation_seconds(recording, chain) +
           seconds_per_time * double(recording.times.size()) +
           seconds_per_reading * double(recording.deflections.size());
}

std::vector<double> expected_seconds(std::span<const diagnose::Specimen> specimens,
                                     const fit::ChainOptions& chain, std::size_t candidates) {
    const double simulations =
        simulations_for_fits + simulations_for_candidate * static_cast<double>(candidates);
    std::vector<double> seconds;
    for (const diagnose::Specimen& specimen : specimens) {
        double& sum = seconds.emplace_back(0.0);
        for (const measure::Measurement& recording : specimen.recordings)
            sum += simulations * simulation_seconds(recording, chain);
    }
    return seconds;
}

} // namespace culm::cli
