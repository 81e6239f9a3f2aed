// SPDX-License-Identifier: BSD-3-Clause
#include "cli/recordings.hpp"

#include "physics/bond_law_options.hpp"
#include "present/files.hpp"
#include "present/text.hpp"
#include "study/execute/plan.hpp"

#include <filesystem>
#include <optional>

#include <fmt/format.h>

namespace culm::cli {
namespace {

using fit::SelectedEffects;

/// A range, in any unit.
struct Span {
    double least = 0.0;
    double most = 0.0;

    Span& operator+=(const Span& other) {
        least += other.least;
        most += other.most;
        return *this;
    }
    friend Span operator*(double factor, const Span& span) {
        return {factor * span.least, factor * span.most};
    }
};

// Numbers of runs of the chain with all its derivatives, and the time of such a run relative to the
// plain run of study::estimated_seconds, which grows with the number of fitted parameters. Measured
// for the recordings in tests/data/hidden-effect (docs/performance.md, "Fits").
constexpr double seconds_per_plain_run = 4.0;
constexpr double seconds_per_number = 2.0;
constexpr Span runs_of_first_fit{12.0, 30.0};
constexpr Span runs_of_effect_fit{10.0, 90.0};
constexpr Span runs_of_held_out_fits{10.0, 40.0};
constexpr Span runs_of_score{5.0, 10.0};
/// Number of candidates that are fitted with the chain, relative to those that are scored.
constexpr Span fits_for_each_candidate{0.3, 2.0};

/// Expected time of a run with derivatives, s; nothing if the recording has no such model.
std::optional<double> run_seconds(const measure::Measurement& recording,
                                  const SelectedEffects& effects, const fit::FitOptions& options) {
    try {
        fit::StemModel model = fit::baseline_model(recording, options.chain);
        if (!effects.empty())
            model = fit::candidate_model(model, effects, recording);
        if (options.window)
            model.spec.duration = std::min(model.spec.duration, *options.window);
        return (seconds_per_plain_run +
                seconds_per_number * static_cast<double>(model.free_count())) *
               study::estimated_seconds(model.spec);
    } catch (const core::InputError&) {
        return std::nullopt;
    } catch (const core::NumericalError&) {
        return std::nullopt;
    }
}

/// ": about 3 s to 20 s of processor time …" and the end of the line.
std::string time_text(const std::optional<Span>& seconds, int ranks) {
    if (!seconds)
        return "; the time cannot be estimated\n";
    const auto range = [](const Span& span) {
        return fmt::format("{} to {}", present::estimate_text(span.least),
                           present::estimate_text(span.most));
    };
    std::string text =
        fmt::format(": about {} of processor time on the reference machine", range(*seconds));
    if (ranks > 1)
        text += fmt::format(", {} on {} ranks", range((1.0 / ranks) * *seconds), ranks);
    return text + '\n';
}

/// Adds a model's cost to `sum`; `sum` becomes nothing if the cost is unknown.
void add(std::optional<Span>& sum, const Span& runs, const std::optional<double>& run) {
    if (!run)
        sum.reset();
    else if (sum)
        *sum += *run * runs;
}

} // namespace

void add_recording_options(CLI::App& command, RecordingArguments& arguments, const char* paths,
                           const char* output, const char* window) {
    command.add_option("measurements", arguments.paths, paths)
        ->required()
        ->type_name("MEASUREMENT");
    command.add_option("--json", arguments.json, "Write all results to this file (- for stdout)")
        ->type_name("FILE");
    command.add_option("-o,--output", arguments.output, output)->type_name("DIR");
    command.add_flag("-q,--quiet", arguments.is_quiet,
                     "Neither an estimate of the cost nor progress nor the next command");
    command
        .add_option(
            "--window", arguments.window_s,
            fmt::format("{} only the first SECONDS after the release (default: all)", window))
        ->type_name("SECONDS")
        ->check(number_in({0.0, 1e6, true}));
}

void add_chain_options(CLI::App& command, RecordingArguments& arguments) {
    command
        .add_option("--law", arguments.law,
                    "Law of the bonds' damping: \"consistent\" (physical) or \"schramm2019\" (as "
                    "in the authors' code) (default: consistent)")
        ->check(CLI::IsMember(physics::law_names()));
    command
        .add_option("--spheres", arguments.spheres,
                    "Spheres in the chain (default: as stem.toml says, else 56)")
        ->type_name("N")
        ->check(CLI::Range(5, 1000));
    command.add_flag("--details", arguments.with_details,
                     "Also print the tables that the answer is based on");
}

std::string next_step(const RecordingArguments& arguments, const std::string& command) {
    return arguments.is_quiet ? std::string() : next_step(command);
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
    present::make_folder(arguments.output);
    present::write_json((std::filesystem::path(arguments.output) / file).string(), document);
}

std::string cost_of_calibration(const std::vector<measure::Measurement>& recordings,
                                const calibrate::CalibrationOptions& options, int ranks) {
    std::optional<Span> seconds{Span{}};
    for (const measure::Measurement& recording : recordings) {
        add(seconds, runs_of_first_fit, run_seconds(recording, {}, options.fit));
        if (!options.effects.empty())
            add(seconds, runs_of_effect_fit, run_seconds(recording, options.effects, options.fit));
    }
    return present::counted(recordings.size(), "recording") + ", one fit of the chain to each" +
           time_text(seconds, ranks);
}

std::string cost_of_ladder(const measure::Measurement& recording,
                           const std::vector<SelectedEffects>& models,
                           const fit::FitOptions& options) {
    std::optional<Span> seconds{Span{}};
    add(seconds, runs_of_first_fit, run_seconds(recording, {}, options));
    add(seconds, runs_of_held_out_fits, run_seconds(recording, {}, options));
    for (const SelectedEffects& effects : models)
        for (const Span& runs : {runs_of_effect_fit, runs_of_held_out_fits})
            add(seconds, runs, run_seconds(recording, effects, options));
    return present::counted(models.size() + 1, "model") + ", three fits of each" +
           time_text(seconds, 1);
}

std::string cost_of_table(const std::vector<measure::Measurement>& recordings,
                          const std::vector<SelectedEffects>& models,
                          const fit::FitOptions& options, int ranks) {
    std::optional<Span> seconds{Span{}};
    for (const measure::Measurement& recording : recordings)
        for (const SelectedEffects& effects : models)
            add(seconds, effects.empty() ? runs_of_first_fit : runs_of_effect_fit,
                run_seconds(recording, effects, options));
    return fmt::format("{} fitted to {}", present::counted(models.size(), "model"),
                       present::counted(recordings.size(), "recording")) +
           time_text(seconds, ranks);
}

std::string cost_of_diagnosis(std::span<const measure::Measurement> recordings,
                              const diagnose::DiagnosisOptions& options, int ranks) {
    std::optional<Span> seconds{Span{}};
    for (const measure::Measurement& recording : recordings) {
        add(seconds, runs_of_first_fit, run_seconds(recording, options.known, options.candidate));
        for (const physics::SelectedEffect& candidate : options.candidates) {
            SelectedEffects effects = options.known;
            effects.push_back(candidate);
            const std::optional<double> run =
                run_seconds(recording, fit::in_library_order(effects), options.candidate);
            if (!run)
                continue; // the search reports why it cannot be tried
            add(seconds, runs_of_score, run);
            add(seconds,
                {fits_for_each_candidate.least * runs_of_effect_fit.least,
                 fits_for_each_candidate.most * runs_of_effect_fit.most},
                run);
        }
    }
    return fmt::format("{} scored, the promising ones fitted to {}",
                       present::counted(options.candidates.size(), "candidate"),
                       present::counted(recordings.size(), "recording")) +
           time_text(seconds, ranks);
}

} // namespace culm::cli
