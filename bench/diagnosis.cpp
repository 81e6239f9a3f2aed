// SPDX-License-Identifier: BSD-3-Clause
// Diagnoses of recordings whose hidden effects are known: drawn at random, made by a beam that is
// not the chain, spread over the ranks of mpirun.
#include "bench/diagnosis_outcome.hpp"
#include "bench/diagnosis_score.hpp"
#include "bench/run_program.hpp"
#include "cli/gathered_json.hpp"
#include "cli/item_farm.hpp"
#include "core/error.hpp"
#include "farm/batch.hpp"
#include "farm/environment.hpp"
#include "measure/measurement_folder.hpp"

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
    std::string json_file;
    std::string write_folder;
    std::optional<int> spheres;
    int null_draws = 200;
};

std::vector<beam::RandomCase> draw_cases(const Settings& settings) {
    std::vector<beam::RandomCase> cases;
    for (const CaseKind kind :
         {CaseKind::Null, CaseKind::Single, CaseKind::Pair, CaseKind::Unknown})
        if (settings.kind == "all" || settings.kind == beam::to_string(kind))
            for (int k = 0; k < settings.cases; ++k)
                cases.push_back(beam::random_case(settings.seed, kind,
                                                  settings.first + static_cast<std::uint64_t>(k)));
    return cases;
}

Outcome diagnosed_case(const beam::RandomCase& drawn, const Settings& settings,
                       farm::Heartbeat& heartbeat) {
    const measure::Measurement measurement = beam::record(drawn.spec);
    if (!settings.write_folder.empty())
        measure::write_measurement(std::filesystem::path(settings.write_folder) / drawn.spec.id,
                                   measurement);
    diagnose::DiagnosisOptions options;
    options.candidate.chain.spheres = settings.spheres;
    options.null_draws = settings.null_draws;
    options.candidate.heartbeat = [&heartbeat] {
        heartbeat.beat();
        return !heartbeat.stop_requested();
    };
    return diagnosed(measurement, options);
}

json case_json(const GradedCase& graded) {
    json truth = json::object();
    for (const beam::HiddenEffect& effect : graded.drawn.spec.effects)
        for (const auto& [name, value] : effect.parameters)
            truth[effect.name][name] = value;
    const beam::RecordingSpec& spec = graded.drawn.spec;
    return {{"id", spec.id},
            {"kind", beam::to_string(graded.drawn.kind)},
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

void print_report(const Settings& settings, const std::vector<GradedCase>& cases) {
    fmt::print("{} recordings; {} build, {}; seed {}, cases from {} on\n{}", cases.size(),
               CULM_BUILD_TYPE, CULM_ARCHITECTURE, settings.seed, settings.first, report(cases));
    if (settings.json_file.empty())
        return;
    json all = json::array();
    for (const GradedCase& graded : cases)
        all.push_back(case_json(graded));
    std::ofstream file(settings.json_file);
    file << all.dump(1) << '\n';
    if (!file.flush())
        throw core::StorageError(fmt::format("{} cannot be written", settings.json_file));
}

void run(const Settings& settings, const farm::Communicator* communicator) {
    const std::vector<beam::RandomCase> cases = draw_cases(settings);
    std::vector<json> own(cases.size());
    const auto work = [&](std::size_t item, farm::Heartbeat& heartbeat) {
        own[item] = diagnosed_case(cases[item], settings, heartbeat);
        const Outcome outcome = own[item];
        fmt::print(stderr, "{}: {}, {:.0f} s\n", cases[item].spec.id,
                   to_string(grade(cases[item], outcome)), outcome.seconds);
        return farm::BatchReport{1, 0, outcome.seconds};
    };
    // Two effects are searched for longest.
    std::vector<double> costs;
    for (const beam::RandomCase& drawn : cases)
        costs.push_back(1.0 + 2.0 * static_cast<double>(drawn.spec.effects.size()));
    const farm::Summary summary = cli::map_items(communicator, costs, work);
    const json outcomes = cli::gathered(own, communicator);
    if (communicator != nullptr && communicator->rank() != 0)
        return;
    std::vector<GradedCase> graded;
    for (std::size_t k = 0; k < cases.size(); ++k)
        if (!outcomes[k].is_null()) {
            const Outcome outcome = outcomes[k];
            graded.push_back({cases[k], outcome, grade(cases[k], outcome)});
        }
    for (const farm::LostBatch& lost : summary.lost)
        fmt::print(stderr, "{}: lost: {}\n", cases[lost.batch].spec.id, lost.reason);
    print_report(settings, graded);
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
    app.add_option("--json", settings.json_file, "every case with its truth and its answer");
    app.add_option("--write", settings.write_folder, "keep the recordings in this folder");
    app.add_option("--spheres", settings.spheres, "of the chains that are fitted");
    app.add_option("--null-draws", settings.null_draws, "of each diagnosis's own check");
    CLI11_PARSE(app, argc, argv);
    return bench::run_program([&] {
        farm::Environment environment(argc, argv);
        const farm::Communicator world = environment.world();
        bench::run(settings, world.size() > 1 ? &world : nullptr);
    });
}
