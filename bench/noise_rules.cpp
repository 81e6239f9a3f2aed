// SPDX-License-Identifier: BSD-3-Clause
// What the noise model does to verdicts and intervals: 40 fixed recordings of the beam generator,
// five truths with each of eight laws of noise.
//
//   bench_noise_rules
//
// Prints one line per recording and one summary. Each recording is fitted with the published chain
// and, if an effect is hidden in it, with that effect, as `culm compare --with` does. Run it before
// and after a change of the noise model (docs/uncertainty.md has the table of removals).
#include "bench/reading_noise.hpp"
#include "diagnose/adequacy.hpp"
#include "fit/fit_model.hpp"
#include "fit/model/stem_chain.hpp"
#include "fit/solve/residual_statistics.hpp"
#include "tests/beam_generator/recording.hpp"

#include <cmath>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/core.h>

namespace {

using namespace culm;

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

struct Sums {
    int nulls = 0, adequate_nulls = 0;
    int effects = 0, adequate_effects = 0, refused_chains = 0;
    double modulus = 0.0, damping = 0.0; ///< of (error/standard error)²
};

/// Error of a number over its standard error.
double score(const fit::RecordingFit& fit, const physics::ParameterId& id, double truth) {
    const fit::FittedParameter& found = *fit.find(id);
    return (found.value - truth) / found.standard_error;
}

diagnose::Finding finding(const fit::ModelFit& model, const measure::Measurement& recording) {
    return diagnose::verdict_on(model.judged, {&recording, 1}).finding;
}

void judge(const HiddenTruth& truth, const std::string& family, std::uint64_t number, Sums& sums) {
    const measure::Measurement recording = recorded(truth, family, number);
    std::vector<fit::SelectedEffects> sets;
    if (*truth.effect != '\0')
        sets.push_back(physics::parse_effects(truth.effect, {}));
    const fit::NestedFits fits = fit::fit_nested({&recording, 1}, sets);
    const fit::ModelFit& right = fits.models.back();
    if (right.judged.failed() || right.stated.failed()) {
        fmt::print("{:<22} {:<12} failed: {}\n", truth.effect, family, right.judged.reason);
        return;
    }
    const bool is_adequate = finding(right, recording) == diagnose::Finding::Adequate;
    const fit::RecordingFit& part = right.stated.parts.front();
    const beam::BeamStem stem;
    run::CaseSpec unit = fit::chain_of(recording).spec;
    unit.stem.bond_youngs_modulus = stem.youngs_modulus;
    unit.stem.bond_damping = 1.0;
    const double modulus = score(part, physics::bond_youngs_modulus, stem.youngs_modulus);
    const double damping =
        score(part, physics::bond_damping, stem.damping_time / fit::damping_time(unit));
    sums.modulus += modulus * modulus;
    sums.damping += damping * damping;
    std::string chain;
    if (sets.empty()) {
        ++sums.nulls;
        sums.adequate_nulls += is_adequate ? 1 : 0;
    } else {
        ++sums.effects;
        sums.adequate_effects += is_adequate ? 1 : 0;
        const bool is_refused =
            finding(fits.models.front(), recording) == diagnose::Finding::Inadequate;
        sums.refused_chains += is_refused ? 1 : 0;
        chain = is_refused ? "chain inadequate" : "chain adequate";
    }
    fmt::print("{:<22} {:<12} {:<10} {:<16} red. chi2 {:.3f} /noise {:.2f} Y {:+.1f} beta {:+.1f}"
               "  {}\n",
               sets.empty() ? "-" : truth.effect, family, is_adequate ? "adequate" : "inadequate",
               chain, right.judged.reduced_chi_squared, fit::over_noise(part), modulus, damping,
               part.noise_source);
}

} // namespace

int main() {
    Sums sums;
    std::uint64_t number = 0;
    for (const HiddenTruth& truth : truths(beam::BeamStem{})) {
        judge(truth, "white", ++number, sums);
        for (const std::string_view family : bench::noise_families)
            judge(truth, std::string(family), ++number, sums);
    }
    const double count = sums.nulls + sums.effects;
    fmt::print(
        "adequate: {} of {} without an effect, {} of {} with their effect; chain inadequate "
        "without the effect: {} of {}; rms error over standard error: Y {:.2f}, beta {:.2f}\n",
        sums.adequate_nulls, sums.nulls, sums.adequate_effects, sums.effects, sums.refused_chains,
        sums.effects, std::sqrt(sums.modulus / count), std::sqrt(sums.damping / count));
    return 0;
}
