// SPDX-License-Identifier: BSD-3-Clause
// culm simulate: one stem, with parameters given or calibrated from a study's regressions.
#include "cli/options.hpp"
#include "present/files.hpp"
#include "reduce/study_regression.hpp"
#include "run/simulate.hpp"
#include "study/config/parameters.hpp"
#include "study/execute/point_results.hpp"
#include "study/summary/summary.hpp"

#include <optional>
#include <string>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

namespace culm::cli {
namespace {

struct SimulateArguments {
    std::string study;
    std::string via;
    std::optional<double> youngs_modulus_gpa;
    std::optional<double> bond_damping;
    std::optional<double> decay_per_cycle;
    std::optional<double> frequency_hz;
    std::string json;
};

/// A stem to simulate: the source of its parameters, and the expected results.
struct Candidate {
    std::string name;
    double youngs_modulus = 0.0; ///< Pa
    double bond_damping = 0.0;
};

reduce::RingDownFit simulate_candidate(const study::StudyConfig& config,
                                       const Candidate& candidate) {
    run::CaseSpec spec = config.base;
    spec.stem.bond_youngs_modulus = candidate.youngs_modulus;
    spec.stem.bond_damping = candidate.bond_damping;
    const run::CaseOutcome outcome = run::simulate(spec);
    if (const auto* failure = std::get_if<run::CaseFailure>(&outcome))
        throw core::NumericalError(failure->kind, failure->reason);
    const auto& result = std::get<run::CaseResult>(outcome);
    return reduce::fit_ring_down(study::sample_times(spec), result.tip_deflection,
                                 study::fit_options(config.reduce));
}

/// Y and β from the regressions of a study: from the paper's laws, and from the terms that the
/// F-tests kept.
std::vector<Candidate> calibrated(const study::ArchivedStudy& archived,
                                  const SimulateArguments& arguments) {
    const study::StudySummary summary = study::reduce_study(archived, std::nullopt);
    const reduce::StemPrediction prediction = reduce::predict_stem(
        summary.regression, {reduce::normal_estimate(*arguments.decay_per_cycle, 0.0),
                             reduce::normal_estimate(*arguments.frequency_hz, 0.0)});
    if (!prediction.is_inside_design)
        print_warning(fmt::format(
            "the study covers decays per cycle of {:.4g} … {:.4g} and frequencies of {:.4g} … "
            "{:.4g} Hz; this stem lies outside, the laws are extrapolated",
            summary.regression.decay_per_cycle.low, summary.regression.decay_per_cycle.high,
            summary.regression.frequency.low, summary.regression.frequency.high));
    std::vector<Candidate> candidates;
    const auto add = [&candidates](const char* name, const auto& modulus, const auto& damping) {
        if (modulus && damping)
            candidates.push_back({name, modulus->value, damping->value});
    };
    add("paper's laws", prediction.bond_youngs_modulus.by_single_law,
        prediction.bond_damping.by_single_law);
    add("F-test terms", prediction.bond_youngs_modulus.by_reduced_model,
        prediction.bond_damping.by_reduced_model);
    if (candidates.empty())
        throw core::InputError(fmt::format("{}: the study has no regressions to calibrate with: {} "
                                           "{}",
                                           arguments.via, prediction.bond_youngs_modulus.reason,
                                           prediction.bond_damping.reason));
    return candidates;
}

nlohmann::json to_json(const Candidate& candidate, const reduce::RingDownFit& fit,
                       const SimulateArguments& arguments) {
    nlohmann::json json{{"parameters_from", candidate.name},
                        {"bond_youngs_modulus_pa", candidate.youngs_modulus},
                        {"bond_damping", candidate.bond_damping},
                        {"frequency_hz", fit.frequency.value},
                        {"decay_per_cycle", fit.decay_per_cycle.value},
                        {"amplitude", fit.amplitude.value / fit.largest_deflection},
                        {"rms_residual", fit.rms_residual / fit.largest_deflection}};
    if (arguments.frequency_hz)
        json["frequency_error_percent"] =
            100.0 * (fit.frequency.value / *arguments.frequency_hz - 1.0);
    if (arguments.decay_per_cycle)
        json["decay_error_percent"] =
            100.0 * (fit.decay_per_cycle.value / *arguments.decay_per_cycle - 1.0);
    return json;
}

/// `law` is the name of that of the bonds' damping, `stem` measure::stem_line().
void print(const Candidate& candidate, const reduce::RingDownFit& fit, const std::string& law,
           const std::string& stem, const SimulateArguments& arguments) {
    fmt::print("{}: Y = {:.4f} GPa, beta = {:.3f} (law {})\n", candidate.name,
               candidate.youngs_modulus * 1e-9, candidate.bond_damping, law);
    fmt::print("    stem: {}\n", stem);
    const auto line = [](const char* name, double value, const char* unit,
                         const std::optional<double>& wanted) {
        fmt::print("    {:<22} {:>10.5g} {}", name, value, unit);
        if (wanted)
            fmt::print("    wanted {:.5g}, error {:+.2f} %", *wanted,
                       100.0 * (value / *wanted - 1.0));
        fmt::print("\n");
    };
    line("b2 (frequency)", fit.frequency.value, "Hz", arguments.frequency_hz);
    line("b1 (decay per cycle)", fit.decay_per_cycle.value, "  ", arguments.decay_per_cycle);
    fmt::print("    Eq. 1 leaves {:.2f} % of the tip's deflection (rms)\n",
               100.0 * fit.rms_residual / fit.largest_deflection);
}

void refuse_incomplete(const SimulateArguments& arguments) {
    if (arguments.via.empty() && arguments.study.empty())
        throw core::InputError("simulate needs a study file, or --via DIR");
    if (!arguments.via.empty() && !arguments.study.empty())
        throw core::InputError("simulate takes a study file or --via DIR, not both");
    if (!arguments.via.empty() && !(arguments.decay_per_cycle && arguments.frequency_hz))
        throw core::InputError("--via DIR needs --frequency-hz and --decay-per-cycle, the measured "
                               "b2 and b1 of the stem");
    if (!arguments.study.empty() && !(arguments.youngs_modulus_gpa && arguments.bond_damping))
        throw core::InputError("a study file needs --bond-youngs-modulus-gpa and --bond-damping; "
                               "to calibrate them from a study that has run, give --via DIR");
}

void simulate(const SimulateArguments& arguments) {
    refuse_incomplete(arguments);
    std::vector<Candidate> candidates;
    study::StudyConfig config;
    if (arguments.via.empty()) {
        config = study::load_study(arguments.study).config;
        candidates.push_back(
            {"given parameters", *arguments.youngs_modulus_gpa * 1e9, *arguments.bond_damping});
    } else {
        const study::ArchivedStudy archived =
            study::open_archive(study::StudyFolder(arguments.via));
        config = archived.study.config;
        candidates = calibrated(archived, arguments);
    }
    nlohmann::json json = nlohmann::json::array();
    for (const Candidate& candidate : candidates) {
        const reduce::RingDownFit fit = simulate_candidate(config, candidate);
        if (arguments.json != "-")
            print(candidate, fit, physics::law_name(config.base.law),
                  measure::stem_line(run::described_stem(config.base), candidate.youngs_modulus),
                  arguments);
        json.push_back(to_json(candidate, fit, arguments));
    }
    if (!arguments.json.empty())
        present::write_json(arguments.json, json);
}

} // namespace

void add_simulate_command(CLI::App& app) {
    const auto range_of = [](const char* key) {
        return number_in(study::find_parameter(key)->range);
    };
    CLI::App* command = app.add_subcommand(
        "simulate", "Simulate one stem and fit b1 and b2 to its motion (the paper's closing test)");
    auto arguments = std::make_shared<SimulateArguments>();
    add_option(*command, "study", arguments->study, "STUDY.toml",
               "Study file whose stem and release are used");
    add_option(*command, "--via", arguments->via, "DIR",
               "Calibrate Y and beta by this study's regressions, and use its stem");
    add_option(*command, "--bond-youngs-modulus-gpa", arguments->youngs_modulus_gpa, "GPA",
               "Bond Young's modulus Y, GPa")
        ->check(range_of("bond_youngs_modulus_gpa"));
    add_option(*command, "--bond-damping", arguments->bond_damping, "BETA", "Local damping beta")
        ->check(range_of("bond_damping"));
    add_option(*command, "--frequency-hz", arguments->frequency_hz, "HZ",
               "Measured frequency b2, Hz")
        ->check(number_in({0.0, 1e6, true, false}));
    add_option(*command, "--decay-per-cycle", arguments->decay_per_cycle, "B1",
               "Measured damping b1 in normalised time, negative")
        ->check(number_in({-10.0, 0.0, false, true}));
    add_option(*command, "--json", arguments->json, "FILE",
               "Write the results to this file (- for stdout)");
    command->callback([arguments] { simulate(*arguments); });
}

} // namespace culm::cli
