// SPDX-License-Identifier: BSD-3-Clause
// The effect of the noise model on verdicts and intervals: 40 fixed recordings of the beam
// generator, five truths with each of eight laws of noise.
//
//   bench_noise_rules FILE
//
// Adds the cases to FILE, prints one line per recording and one summary. Each recording is fitted
// with the published chain and, if an effect is hidden in it, with that effect, as `culm compare
// --with` does. Run it before and after a change of the noise model.
#include "bench/reading_noise.hpp"
#include "bench/result_file.hpp"
#include "diagnose/adequacy.hpp"
#include "diagnose/ladder.hpp"
#include "fit/chain/stem_chain.hpp"
#include "fit/fit_model.hpp"
#include "fit/solve/residual_statistics.hpp"
#include "tests/beam_generator/recording.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

namespace {

using namespace culm;
using nlohmann::json;

constexpr double size = 0.04e-3; // m, of the noise
constexpr int spheres = 20;

struct HiddenTruth {
    const char* effect; ///< empty: none
    std::vector<beam::HiddenEffect> effects;
};

std::vector<HiddenTruth> truths(const beam::BeamStem& stem) {
    const double stiffness = 40.0 * stem.rigidity() / stem.length;
    return {{"", {}},
            {"quadratic_drag", {{"quadratic_drag", {{"drag_coefficient", 1.0}}}}},
            {"clamp_compliance", {{"clamp_compliance", {{"stiffness_nm_rad", stiffness}}}}},
            {"relaxation",
             {{"relaxation", {{"fraction", 0.03}, {"time_s", 0.15}, {"hold_time_s", 10.0}}}}},
            {"bending_nonlinearity", {{"bending_nonlinearity", {{"gamma_m2", -0.01}}}}}};
}

measure::Measurement recorded(const HiddenTruth& truth, const std::string& family,
                              std::uint64_t number) {
    beam::RecordingSpec spec;
    spec.effects = truth.effects;
    spec.heights = beam::even_heights(spec.stem.length, 8);
    spec.duration = 0.35;
    spec.errors.noise = 0.0;
    measure::Measurement measurement = beam::record(spec);
    bench::Noise(family, number).add(size, measurement);
    measurement.noise = size;
    measurement.stem.spheres = spheres;
    return measurement;
}

/// Error of a number over its standard error.
double score(const fit::RecordingFit& fit, const physics::ParameterId& id, double truth) {
    const fit::FittedParameter& found = *fit.find(id);
    return (found.value - truth) / found.standard_error;
}

bool is_found(const diagnose::NestedFits& fits, const fit::Fit& model, diagnose::Finding finding) {
    return diagnose::verdict_on(model, fits.recordings).finding == finding;
}

json case_of(const HiddenTruth& truth, const std::string& family, std::uint64_t number) {
    const measure::Measurement recording = recorded(truth, family, number);
    std::vector<fit::SelectedEffects> sets;
    if (*truth.effect != '\0')
        sets.push_back(physics::parse_effects(truth.effect, {}));
    const diagnose::NestedFits fits = diagnose::fit_nested({&recording, 1}, sets);
    const fit::Fit& right = fits.models.back();
    if (right.failed())
        return {{"failure", right.reason}};
    const fit::RecordingFit& part = right.parts.front();
    const beam::BeamStem stem;
    run::CaseSpec unit = fit::chain_of(recording).spec;
    unit.stem.bond_youngs_modulus = stem.youngs_modulus;
    unit.stem.bond_damping = 1.0;
    return {
        {"is_adequate", is_found(fits, right, diagnose::Finding::Adequate)},
        {"is_chain_inadequate", is_found(fits, fits.models.front(), diagnose::Finding::Inadequate)},
        {"reduced_chi2", right.reduced_chi_squared},
        {"over_noise", fit::over_noise(part)},
        {"error_of_youngs_modulus", score(part, physics::bond_youngs_modulus, stem.youngs_modulus)},
        {"error_of_damping",
         score(part, physics::bond_damping, stem.damping_time / fit::damping_time(unit))},
        {"noise", part.noise_source}};
}

void print(const json& each) {
    fmt::print(
        "{:<22} {:<12} {}\n", each["effect"].get<std::string>(), each["family"].get<std::string>(),
        each.contains("failure")
            ? "failed: " + each["failure"].get<std::string>()
            : fmt::format(
                  "{:<10} {:<16} red. chi2 {:.3f} /noise {:.2f} Y {:+.1f} beta "
                  "{:+.1f}  {}",
                  each["is_adequate"].get<bool>() ? "adequate" : "inadequate",
                  each["is_chain_inadequate"].get<bool>() ? "chain inadequate" : "chain adequate",
                  each["reduced_chi2"].get<double>(), each["over_noise"].get<double>(),
                  each["error_of_youngs_modulus"].get<double>(),
                  each["error_of_damping"].get<double>(), each["noise"].get<std::string>()));
    std::fflush(stdout);
}

void print_summary(const json& cases) {
    std::map<std::string, int> counts;
    double modulus = 0.0;
    double damping = 0.0;
    int fitted = 0;
    for (const json& each : cases) {
        const bool is_null = each["effect"].get<std::string>().empty();
        ++counts[is_null ? "null" : "effect"];
        if (each.contains("failure"))
            continue;
        ++fitted;
        counts[is_null ? "null adequate" : "effect adequate"] += each["is_adequate"] ? 1 : 0;
        counts["refused"] += !is_null && each["is_chain_inadequate"] ? 1 : 0;
        modulus += std::pow(each["error_of_youngs_modulus"].get<double>(), 2);
        damping += std::pow(each["error_of_damping"].get<double>(), 2);
    }
    fmt::print(
        "adequate: {} of {} without an effect, {} of {} with their effect; chain inadequate "
        "without the effect: {} of {}; rms error over standard error: Y {:.2f}, beta {:.2f}\n",
        counts["null adequate"], counts["null"], counts["effect adequate"], counts["effect"],
        counts["refused"], counts["effect"], std::sqrt(modulus / fitted),
        std::sqrt(damping / fitted));
}

} // namespace

int main(int argc, char** argv) {
    if (argc != 2) {
        fmt::print(stderr, "usage: bench_noise_rules FILE\n");
        return 2;
    }
    const std::vector<HiddenTruth> hidden = truths(beam::BeamStem{});
    std::vector<std::string> families{"white"};
    families.insert(families.end(), bench::noise_families.begin(), bench::noise_families.end());
    std::vector<json> keys;
    for (const HiddenTruth& truth : hidden)
        for (const std::string& family : families)
            keys.push_back(
                {{"effect", truth.effect}, {"family", family}, {"number", keys.size() + 1}});
    bench::ResultFile results(argv[1]);
    results.add(
        keys,
        [&](const json& key) {
            const auto truth = std::ranges::find_if(hidden, [&](const HiddenTruth& each) {
                return each.effect == key["effect"].get<std::string>();
            });
            return case_of(*truth, key["family"], key["number"]);
        },
        print);
    print_summary(results.cases());
    return 0;
}
