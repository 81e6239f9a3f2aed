// SPDX-License-Identifier: BSD-3-Clause
// Tests whether the 95 % intervals of a calibration contain the truth: recordings of the beam
// generator, with inputs misstated by their uncertainties, are calibrated with three effects.
//
//   bench_uncertainty_coverage FIRST COUNT FILE     adds cases to FILE, prints the shares of all
//
// The truth of case n follows from n alone.
#include "bench/misstated_inputs.hpp"
#include "bench/result_file.hpp"
#include "calibrate/calibration.hpp"
#include "core/error.hpp"
#include "fit/chain/stem_chain.hpp"
#include "physics/effects/library.hpp"
#include "reduce/distributions.hpp"
#include "tests/beam_generator/recording.hpp"

#include <cmath>
#include <cstdlib>
#include <map>
#include <random>
#include <string>
#include <vector>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

namespace {

using namespace culm;
using nlohmann::json;

constexpr const char* effects = "clamp_compliance,precurvature,quadratic_drag";
constexpr int spheres = 40;

struct Truth {
    beam::RecordingSpec spec;
    double drag_coefficient;
    double clamp_stiffness; ///< N m/rad
    double curvature;       ///< 1/m, uniform
};

Truth truth_of(std::uint64_t number) {
    std::mt19937_64 dice(0x5eed0000 + number);
    std::uniform_real_distribution<double> share(0.0, 1.0);
    const auto between = [&](double low, double high) { return low + (high - low) * share(dice); };
    Truth truth;
    truth.spec.stem.length = between(0.13, 0.18);
    truth.spec.stem.youngs_modulus = between(1.5e9, 4e9);
    truth.spec.stem.damping_time = between(0.8e-4, 2.5e-4);
    truth.spec.tip_deflection = between(12e-3, 22e-3);
    truth.spec.heights = beam::even_heights(truth.spec.stem.length, 8);
    truth.spec.duration = 0.3;
    truth.spec.errors.noise = 0.05e-3;
    truth.spec.seed = number;
    truth.drag_coefficient = between(1.0, 3.0);
    truth.clamp_stiffness =
        between(20.0, 60.0) * truth.spec.stem.rigidity() / truth.spec.stem.length;
    truth.curvature = between(-0.3, 0.3);
    truth.spec.effects = {
        {"clamp_compliance", {{"stiffness_nm_rad", truth.clamp_stiffness}}},
        {"precurvature",
         {{"base_curvature_1_m", truth.curvature}, {"tip_curvature_1_m", truth.curvature}}},
        {"quadratic_drag", {{"drag_coefficient", truth.drag_coefficient}}}};
    return truth;
}

json case_of(std::uint64_t number) {
    const Truth truth = truth_of(number);
    measure::Measurement real = beam::record(truth.spec);
    real.stem.spheres = spheres;
    std::mt19937_64 dice(0xe4404000 + number);
    std::normal_distribution<double> normal;
    measure::Measurement measurement =
        bench::misstated(real, [&](const fit::StatedInput&) { return normal(dice); });
    json out{{"number", number}};
    calibrate::CalibrationOptions options;
    options.effects = physics::parse_effects(effects, {});
    calibrate::Calibration stem;
    try {
        stem = calibrate::calibrate_stem(measurement, options);
    } catch (const core::NumericalError& error) {
        out["failure"] = error.what();
        return out;
    }
    const fit::RecordingFit& part = stem.part();
    const fit::UncertaintyBudget& budget = stem.budget;
    out["reduced_chi2"] = stem.fit.reduced_chi_squared;
    // β belongs to the chain of the true stem, not of the stated one.
    run::CaseSpec unit = fit::chain_of(real).spec;
    unit.stem.bond_youngs_modulus = truth.spec.stem.youngs_modulus;
    unit.stem.bond_damping = 1.0;
    const std::map<std::string, double> expected{
        {"bond_youngs_modulus", truth.spec.stem.youngs_modulus},
        {"bond_damping", truth.spec.stem.damping_time / fit::damping_time(unit)},
        {"clamp_compliance.stiffness_nm_rad", truth.clamp_stiffness},
        {"precurvature.base_curvature_1_m", truth.curvature},
        {"quadratic_drag.drag_coefficient", truth.drag_coefficient}};
    for (std::size_t p = 0; p < budget.combined.size(); ++p)
        if (const auto found = expected.find(to_string(part.parameters[p].id));
            found != expected.end())
            out["parameters"][found->first] = {{"truth", found->second},
                                               {"value", part.parameters[p].value},
                                               {"combined", budget.combined[p]},
                                               {"readings", budget.from_readings[p]}};
    for (const fit::BudgetInput& line : budget.inputs)
        out["pulls"][line.input.name] = line.pull;
    return out;
}

/// Share of the cases whose 95 % interval contains the truth, by parameter, with the whole budget
/// and with the noise of the readings alone.
void print_coverage(const json& cases) {
    std::map<std::string, std::array<int, 3>> counts;
    for (const json& each : cases)
        if (each.contains("parameters"))
            for (const auto& [name, entry] : each["parameters"].items()) {
                const double error =
                    std::abs(entry["value"].get<double>() - entry["truth"].get<double>());
                auto& [all, combined, readings] = counts[name];
                ++all;
                combined += error < reduce::normal_quantile_95 * entry["combined"].get<double>();
                readings += error < reduce::normal_quantile_95 * entry["readings"].get<double>();
            }
    fmt::print(
        "| parameter | cases | covered | by the readings' noise alone |\n|---|---|---|---|\n");
    for (const auto& [name, count] : counts)
        fmt::print("| {} | {} | {:.1f} % | {:.1f} % |\n", name, count[0],
                   100.0 * count[1] / count[0], 100.0 * count[2] / count[0]);
}

} // namespace

int main(int argc, char** argv) {
    if (argc != 4) {
        fmt::print(stderr, "usage: bench_uncertainty_coverage FIRST COUNT FILE\n");
        return 2;
    }
    const std::uint64_t first = std::strtoull(argv[1], nullptr, 10);
    const std::uint64_t count = std::strtoull(argv[2], nullptr, 10);
    bench::ResultFile results(argv[3]);
    results.add(
        bench::numbered(first, count), [](const json& key) { return case_of(key["number"]); },
        [](const json&) {});
    print_coverage(results.cases());
    return 0;
}
