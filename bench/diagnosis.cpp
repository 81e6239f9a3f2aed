// SPDX-License-Identifier: BSD-3-Clause
// Diagnoses of recordings whose hidden effects are known: drawn at random, made by a beam that is
// not the chain, spread over the ranks of mpirun.
#include "beam_generator/flaw.hpp"
#include "bench/cpu_time.hpp"
#include "bench/diagnosis_confusion.hpp"
#include "bench/diagnosis_outcome.hpp"
#include "bench/diagnosis_score.hpp"
#include "bench/run_program.hpp"
#include "core/error.hpp"
#include "farm/environment.hpp"
#include "farm/item_map.hpp"
#include "measure/folder/measurement_folder.hpp"
#include "run/simulate.hpp"

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/core.h>

namespace culm::bench {
namespace {

using beam::CaseKind;
using nlohmann::json;

struct Settings {
    int cases = 18; ///< of each kind
    std::uint64_t first = 0;
    std::uint64_t seed = 1;
    std::string kind = "all";
    std::string flaw = "none"; ///< of every recording
    std::string results_folder;
    std::string write_folder;
    std::optional<int> spheres;
    double limit_s = 900.0; ///< of processor time for one recording
};

std::vector<beam::RandomCase> draw_cases(const Settings& settings) {
    std::vector<beam::RandomCase> cases;
    for (const CaseKind kind :
         {CaseKind::Null, CaseKind::Single, CaseKind::Pair, CaseKind::Unknown})
        if (settings.kind == "all" || settings.kind == beam::to_string(kind))
            for (int k = 0; k < settings.cases; ++k)
                cases.push_back(beam::random_case(settings.seed, kind,
                                                  settings.first + static_cast<std::uint64_t>(k)));
    for (beam::RandomCase& drawn : cases)
        beam::flaw_named(settings.flaw).apply(drawn.spec);
    return cases;
}

Outcome diagnosed_case(const beam::RandomCase& drawn, const Settings& settings,
                       const core::Heartbeat& heartbeat) {
    const measure::Measurement measurement = beam::record(drawn.spec);
    if (!settings.write_folder.empty())
        measure::write_measurement(std::filesystem::path(settings.write_folder) / drawn.spec.id,
                                   measurement);
    diagnose::DiagnosisOptions options;
    options.candidate.chain.spheres = settings.spheres;
    const double start = cpu_seconds();
    options.candidate.heartbeat = [&heartbeat, &settings, start] {
        return heartbeat() && cpu_seconds() - start < settings.limit_s;
    };
    try {
        return diagnosed(measurement, options);
    } catch (const run::Abandoned&) {
        if (!heartbeat())
            throw;
        return no_answer(fmt::format("no answer within {} s", settings.limit_s), settings.limit_s);
    }
}

json case_json(const GradedCase& graded, const Settings& settings) {
    json truth = json::object();
    for (const beam::HiddenEffect& effect : graded.drawn.spec.effects)
        for (const auto& [name, value] : effect.parameters)
            truth[effect.name][name] = value;
    const beam::RecordingSpec& spec = graded.drawn.spec;
    return {{"id", spec.id},
            {"kind", beam::to_string(graded.drawn.kind)},
            {"seed", settings.seed},
            {"flaw", settings.flaw},
            {"number", graded.drawn.number},
            {"truth", truth},
            {"youngs_modulus_Pa", spec.stem.youngs_modulus},
            {"damping_time_s", spec.stem.damping_time},
            {"tip_deflection_m", spec.tip_deflection},
            {"noise_m", spec.errors.noise},
            {"rows", spec.heights.size()},
            {"duration_s", spec.duration},
            {"grade", to_string(graded.grade)},
            {"outcome", graded.outcome}};
}

std::filesystem::path result_file(const Settings& settings, const beam::RandomCase& drawn) {
    return std::filesystem::path(settings.results_folder) /
           fmt::format("{}-{}{}.json", settings.seed, drawn.spec.id,
                       settings.flaw == "none" ? "" : "-" + settings.flaw);
}

/// The answer of this case, as an earlier run kept it.
std::optional<json> kept_case(const Settings& settings, const beam::RandomCase& drawn) {
    if (settings.results_folder.empty())
        return std::nullopt;
    std::ifstream file(result_file(settings, drawn));
    if (!file)
        return std::nullopt;
    return json::parse(file);
}

/// Whole or not at all: a run that is stopped goes on from what it kept.
void keep_case(const Settings& settings, const beam::RandomCase& drawn, const json& graded) {
    if (settings.results_folder.empty())
        return;
    const std::filesystem::path path = result_file(settings, drawn);
    const std::filesystem::path draft = path.string() + ".part";
    std::ofstream file(draft);
    file << graded.dump(1) << '\n';
    if (!file.flush())
        throw core::StorageError(fmt::format("{} cannot be written", draft.string()));
    file.close();
    std::filesystem::rename(draft, path);
}

json answered_case(const Settings& settings, const beam::RandomCase& drawn,
                   const core::Heartbeat& heartbeat) {
    if (std::optional<json> kept = kept_case(settings, drawn))
        return *kept;
    const Outcome outcome = diagnosed_case(drawn, settings, heartbeat);
    json answered = case_json({drawn, outcome, grade(drawn, outcome)}, settings);
    keep_case(settings, drawn, answered);
    fmt::print(stderr, "{}: {}, {:.0f} s\n", drawn.spec.id, to_string(grade(drawn, outcome)),
               outcome.seconds);
    return answered;
}

GradedCase graded(const beam::RandomCase& drawn, const json& answered) {
    const Outcome outcome = answered.at("outcome");
    return {drawn, outcome, grade(drawn, outcome)};
}

/// All that runs of any seed kept in the folder.
std::vector<GradedCase> kept_cases(const std::filesystem::path& folder) {
    std::vector<GradedCase> cases;
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
        if (entry.path().extension() != ".json")
            continue;
        std::ifstream file(entry.path());
        const json answered = json::parse(file);
        const beam::RandomCase drawn = beam::random_case(
            answered.at("seed"), beam::case_kind(answered.at("kind").get<std::string>()),
            answered.at("number").get<std::uint64_t>());
        cases.push_back(graded(drawn, answered));
    }
    return cases;
}

void print_report(const std::string& source, const std::vector<GradedCase>& cases) {
    fmt::print("{} recordings; {} build, {}; {}\n{}{}", cases.size(), CULM_BUILD_TYPE,
               CULM_ARCHITECTURE, source, report(cases), confusion_matrix(cases));
}

void run(const Settings& settings, const farm::Communicator* communicator) {
    if (!settings.results_folder.empty())
        std::filesystem::create_directories(settings.results_folder);
    const std::vector<beam::RandomCase> cases = draw_cases(settings);
    const auto work = [&](std::size_t item, const core::Heartbeat& heartbeat) {
        return answered_case(settings, cases[item], heartbeat).dump();
    };
    // Two effects are searched for longest.
    std::vector<double> costs;
    costs.reserve(cases.size());
    for (const beam::RandomCase& drawn : cases)
        costs.push_back(1.0 + 2.0 * static_cast<double>(drawn.spec.effects.size()));
    const std::vector<core::ItemOutcome<std::string>> answers =
        farm::map(communicator, costs, work);
    if (communicator != nullptr && communicator->rank() != 0)
        return;
    std::vector<GradedCase> all;
    all.reserve(cases.size());
    for (std::size_t k = 0; k < cases.size(); ++k)
        if (answers[k].value)
            all.push_back(graded(cases[k], json::parse(*answers[k].value)));
        else
            fmt::print(stderr, "{}: lost: {}\n", cases[k].spec.id, answers[k].failure);
    print_report(fmt::format("seed {}, cases from {} on, flaw: {}", settings.seed, settings.first,
                             settings.flaw),
                 all);
}

/// Empty if a flaw has this name.
std::string flaw_objection(const std::string& name) {
    std::string names;
    for (const beam::Flaw& flaw : beam::flaws()) {
        if (flaw.name == name)
            return {};
        names += (names.empty() ? "" : ", ") + flaw.name;
    }
    return fmt::format("{} is none of {}", name, names);
}

} // namespace
} // namespace culm::bench

int main(int argc, char** argv) {
    using namespace culm;
    bench::Settings settings;
    CLI::App app("Diagnoses recordings with known hidden effects and grades the answers");
    app.add_option("--cases", settings.cases, "of each kind");
    app.add_option("--first", settings.first, "number of the first case of each kind");
    app.add_option("--seed", settings.seed, "of everything that is drawn");
    app.add_option("--kind", settings.kind, "null, single, pair, unknown or all")
        ->check(CLI::IsMember({"null", "single", "pair", "unknown", "all"}));
    app.add_option("--flaw", settings.flaw, "of every recording: none, unknown_noise, rounded, …")
        ->check(bench::flaw_objection);
    app.add_option("--results", settings.results_folder,
                   "keep every case with its truth and its answer in this folder; what is there "
                   "is not diagnosed again");
    std::string report_folder;
    app.add_option("--report", report_folder, "tables of all that --results kept in this folder")
        ->check(CLI::ExistingDirectory);
    app.add_option("--write", settings.write_folder, "keep the recordings in this folder");
    app.add_option("--spheres", settings.spheres, "of the chains that are fitted");
    app.add_option("--limit", settings.limit_s, "s of processor time for one recording");
    CLI11_PARSE(app, argc, argv);
    return bench::run_program([&] {
        farm::Environment environment(argc, argv);
        const farm::Communicator world = environment.world();
        if (!report_folder.empty()) {
            if (world.rank() == 0)
                bench::print_report("all of " + report_folder, bench::kept_cases(report_folder));
            return;
        }
        bench::run(settings, world.size() > 1 ? &world : nullptr);
    });
}
