// SPDX-License-Identifier: BSD-3-Clause
// culm reduce DIR
#include "cli/options.hpp"
#include "present/files.hpp"
#include "present/study/study.hpp"
#include "study/summary/summary.hpp"

#include <optional>
#include <string>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

namespace culm::cli {
namespace {

struct ReduceArguments {
    std::string folder;
    std::optional<double> window_s;
    std::string amplitude;
    std::optional<double> significance;
    std::string json;
    bool keep = false;
};

/// Writes and prints a summary where the arguments say.
template <class Summary>
void hand_out(const ReduceArguments& arguments, const Summary& summary, const std::string& table,
              const std::string& next_command, core::ExitCode& exit_code) {
    if (!arguments.keep)
        present::write_summary(study::StudyFolder(arguments.folder), summary);
    if (!arguments.json.empty())
        present::write_json(arguments.json, present::summary_json(summary));
    if (arguments.json != "-") {
        fmt::print("{}", table);
        if (!arguments.keep)
            fmt::print("\nwritten   {}/summary.json and its tables (--keep leaves them as they "
                       "were)\n",
                       arguments.folder);
        fmt::print("{}", next_step(next_command));
    }
    if (!summary.failed.empty() || !summary.missing.empty())
        exit_code = core::ExitCode::PointsFailed;
}

void reduce_timesteps(const ReduceArguments& arguments, const study::ArchivedStudy& archived,
                      core::ExitCode& exit_code) {
    if (arguments.window_s || !arguments.amplitude.empty() || arguments.significance)
        throw core::InputError(fmt::format("{}: a time-step study keeps no histories to fit again; "
                                           "--window, --amplitude and --significance are for "
                                           "vibrations",
                                           arguments.folder));
    const study::TimestepSummary summary = study::reduce_timestep_study(archived);
    hand_out(arguments, summary, present::timestep_table(summary),
             "culm report" + as_words({arguments.folder}), exit_code);
}

void reduce(const ReduceArguments& arguments, core::ExitCode& exit_code) {
    const study::ArchivedStudy archived = study::open_archive(study::StudyFolder(arguments.folder));
    if (archived.study.config.kind == study::StudyKind::Timestep) {
        reduce_timesteps(arguments, archived, exit_code);
        return;
    }
    study::ReduceOptions options = archived.study.config.reduce;
    const double duration = archived.study.config.base.duration;
    if (arguments.window_s) {
        if (!(*arguments.window_s > 0.0) || *arguments.window_s > duration * (1.0 + 1e-9))
            throw core::InputError(fmt::format(
                "--window {:g}: must be above 0 and at most {:g} s, the study's duration",
                *arguments.window_s, duration));
        options.window = arguments.window_s;
    }
    if (!arguments.amplitude.empty())
        options.is_amplitude_free = arguments.amplitude == "free";
    std::optional<study::ReduceOptions> refit;
    if (arguments.window_s || !arguments.amplitude.empty() ||
        archived.file.description().stored.tip)
        refit = options;
    const study::StudySummary summary =
        study::reduce_study(archived, refit, arguments.significance);
    hand_out(arguments, summary, present::regression_table(summary),
             "culm calibrate MEASUREMENT --via" + as_words({arguments.folder}), exit_code);
}

} // namespace

void add_reduce_command(CLI::App& app, core::ExitCode& exit_code) {
    CLI::App* command = app.add_subcommand(
        "reduce", "Fit Eq. 1 to the stored histories of a study again, and repeat the regressions "
                  "and the spread of its stems");
    auto arguments = std::make_shared<ReduceArguments>();
    add_option(*command, "dir", arguments->folder, "DIR", "Folder of a completed study")
        ->required();
    add_option(*command, "--window", arguments->window_s, "SECONDS",
               "Fit only the first SECONDS (default: as in the study)");
    command
        ->add_option(
            "--amplitude", arguments->amplitude,
            "b0 \"free\" or \"fixed\" at the initial deflection (default: as in the study)")
        ->check(CLI::IsMember({"free", "fixed"}));
    add_option(*command, "--significance", arguments->significance, "P",
               "Significance of the nested F-tests (default: as in the study)")
        ->check(number_in({1e-6, 0.5}));
    add_option(*command, "--json", arguments->json, "FILE",
               "Write the summary to this file (- for stdout)");
    command->add_flag("--keep", arguments->keep, "Do not change summary.json and fits.csv");
    command->callback([arguments, &exit_code] { reduce(*arguments, exit_code); });
}

} // namespace culm::cli
