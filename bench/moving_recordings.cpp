// SPDX-License-Identifier: BSD-3-Clause
// Compares the diagnosis of a recording that begins while the stem swings with that of the complete
// one. The same readings are diagnosed twice: as they are, and from an arbitrary moment on with a
// release that is "moving".
//
//   bench_moving_recordings FIRST COUNT FILE
//
// The beam generator makes the recordings, with white noise that is stated. Even cases have no
// hidden effect, odd ones quadratic drag and a soft clamp in turn. The moment lies between
// 10 % and 35 % of the record after the release. Both answers of every case are stored, and
// the parameters of the baseline or, with a hidden effect, of the final fit: Young's modulus and
// damping of the bonds and those of the effects.
//
// Stated inputs (length, diameter, …) are the same in both and, here, exact: their contribution to
// the standard errors explains no difference. A difference is compared with 1.96 times the larger
// of the two standard errors, first by the noise of the readings alone, then with the modes at the
// start or the release, which are not the same in both. If a fit ends a small part of one standard
// error from its minimum, differences are smaller than those from the noise.
// Both are compared with the truth too.
//
// Adds the cases to FILE, prints a line for each, then how often both agree. A case follows from
// its number alone.
#include "bench/diagnosis_summary.hpp"
#include "bench/result_file.hpp"
#include "diagnose/ladder.hpp"
#include "fit/chain/stem_chain.hpp"
#include "fit/fit_model.hpp"
#include "fit/solve/uncertainty_budget.hpp"
#include "reduce/distributions.hpp"
#include "tests/beam_generator/random_case.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <optional>
#include <random>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

namespace {

using namespace culm;
using nlohmann::json;

struct Case {
    beam::RecordingSpec spec; ///< with the hidden effect
    double cut = 0.0;         ///< share of the record after the release that is cut off
};

Case drawn_case(std::uint64_t number) {
    constexpr std::uint64_t seed = 0x30714;
    Case drawn{beam::random_case(seed, beam::CaseKind::Null, number).spec, 0.0};
    std::mt19937_64 dice(0x30714000 + number);
    std::uniform_real_distribution<double> share(0.0, 1.0);
    const auto between = [&](double low, double high) { return low + (high - low) * share(dice); };
    drawn.cut = between(0.10, 0.35);
    beam::RecordingSpec& spec = drawn.spec;
    if (number % 4 == 1)
        spec.effects = {{"quadratic_drag", {{"drag_coefficient", between(1.2, 2.0)}}}};
    if (number % 4 == 3) // adds 4 … 8 % of the stem's own compliance
        spec.effects = {{"clamp_compliance",
                         {{"stiffness_nm_rad",
                           spec.stem.rigidity() / spec.stem.length / between(0.04, 0.08)}}}};
    return drawn;
}

/// The recording from the first frame after `start`, s, on, as by a camera that started late.
measure::Measurement cut_at(measure::Measurement measurement, double start) {
    const auto first = std::ranges::lower_bound(measurement.times, start);
    const auto dropped = first - measurement.times.begin();
    const double begin = *first;
    measurement.times.erase(measurement.times.begin(), first);
    for (double& time : measurement.times)
        time -= begin;
    measurement.deflections.erase(measurement.deflections.begin(),
                                  measurement.deflections.begin() +
                                      dropped *
                                          static_cast<std::ptrdiff_t>(measurement.heights.size()));
    measurement.release = measure::ReleaseKind::Moving;
    return measurement;
}

/// True values by the names of the fitted numbers.
std::map<std::string, double> truths(const beam::RecordingSpec& spec,
                                     const measure::Measurement& measurement) {
    run::CaseSpec unit = fit::chain_of(measurement).spec;
    unit.stem.bond_youngs_modulus = spec.stem.youngs_modulus;
    unit.stem.bond_damping = 1.0;
    std::map<std::string, double> expected{
        {"bond_youngs_modulus", spec.stem.youngs_modulus},
        {"bond_damping", spec.stem.damping_time / fit::damping_time(unit)}};
    for (const beam::HiddenEffect& effect : spec.effects)
        for (const auto& [name, value] : effect.parameters)
            expected[effect.name + "." + name] = value;
    return expected;
}

/// A fitted number and its uncertainties.
struct Number {
    double value = 0.0;
    double standard_error = 0.0; ///< from all sources
    double by_noise = 0.0;       ///< by the readings' noise alone
    double by_own = 0.0;         ///< likewise, and by the modes at the start or the release
};

void to_json(json& out, const Number& number) {
    out = {{"value", number.value},
           {"standard_error", number.standard_error},
           {"by_noise", number.by_noise},
           {"by_noise_and_modes", number.by_own}};
}

/// The model with the effects of `fit`, as `culm calibrate` fits it.
fit::Fit with_budget(const fit::Fit& fit, std::span<const measure::Measurement> recordings) {
    std::vector<fit::SelectedEffects> sets;
    if (!fit.effects.empty())
        sets.push_back(fit.effects);
    return std::move(diagnose::fit_nested(recordings, sets).models.back());
}

/// Numbers that both recordings share, by name.
std::map<std::string, Number> numbers_of(const fit::RecordingFit& fit,
                                         const fit::UncertaintyBudget& budget) {
    std::map<std::string, Number> numbers;
    for (std::size_t p = 0; p < budget.combined.size(); ++p) {
        const physics::ParameterId& id = fit.parameters[p].id;
        if (id == physics::tip_deflection || id == physics::release_time)
            continue;
        double variance = std::pow(budget.from_readings[p], 2);
        for (const fit::BudgetInput& line : budget.inputs)
            if (line.input.name.starts_with("amplitude of mode") ||
                line.input.name.starts_with("velocity of mode"))
                variance += std::pow(line.sensitivities[p] * line.input.standard_uncertainty, 2);
        numbers[to_string(id)] = {fit.parameters[p].value, budget.combined[p],
                                  budget.from_readings[p], std::sqrt(variance)};
    }
    return numbers;
}

/// Results of one of the two recordings.
struct Found {
    json summary;
    std::vector<std::string> model; ///< names of the fit that the numbers are of
    std::map<std::string, Number> numbers;
};

Found found_in(const measure::Measurement& measurement, bool has_effect) {
    diagnose::DiagnosisOptions options;
    const std::span recordings(&measurement, 1);
    Found found;
    const auto start = std::chrono::steady_clock::now();
    try {
        const diagnose::Diagnosis diagnosis =
            diagnose::diagnose(diagnose::specimens_of(recordings), options);
        const fit::Fit fit =
            with_budget(has_effect ? diagnosis.final_fit : diagnosis.baseline, recordings);
        found.summary = bench::diagnosis_summary(diagnosis);
        found.model = fit.names();
        if (fit.is_fitted()) {
            const fit::UncertaintyBudget budget = fit::uncertainty_budget(fit, measurement);
            found.numbers = numbers_of(fit.parts.front(), budget);
            for (const fit::BudgetInput& line : budget.inputs)
                found.summary["pulls"][line.input.name] = line.pull;
        }
    } catch (const std::exception& error) {
        found.summary = {{"answer", "failed"}, {"reason", error.what()}};
    }
    found.summary["model"] = found.model;
    found.summary["numbers"] = found.numbers;
    found.summary["frames"] = measurement.times.size();
    found.summary["seconds"] =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return found;
}

/// Compares one number of the two recordings with each other and with the truth. JSON has no
/// infinity: a number that the readings do not determine is null.
json compared(const Number& complete, const Number& cut, std::optional<double> truth) {
    constexpr double limit = reduce::normal_quantile_95;
    const double difference = cut.value - complete.value;
    const double noise = std::max(complete.by_noise, cut.by_noise);
    const double own = std::max(complete.by_own, cut.by_own);
    json out{{"relative_difference", difference / complete.value},
             {"over_cut_standard_error", difference / cut.standard_error},
             {"over_noise", difference / noise},
             {"over_noise_and_modes", difference / own},
             {"agrees_by_noise", std::abs(difference) <= limit * noise},
             {"agrees_by_noise_and_modes", std::abs(difference) <= limit * own}};
    if (!truth)
        return out;
    out["truth"] = *truth;
    for (const auto& [name, number] : {std::pair{"complete", complete}, std::pair{"cut", cut}}) {
        const double error = number.value - *truth;
        out[name] = {{"relative_error", error / *truth},
                     {"over_standard_error", error / number.standard_error},
                     {"over_noise", error / number.by_noise},
                     {"over_noise_and_modes", error / number.by_own},
                     {"covered", std::abs(error) <= limit * number.standard_error},
                     {"covered_by_noise_and_modes", std::abs(error) <= limit * number.by_own}};
    }
    return out;
}

json case_of(std::uint64_t number) {
    const Case drawn = drawn_case(number);
    const bool has_effect = !drawn.spec.effects.empty();
    const measure::Measurement complete = beam::record(drawn.spec);
    const double start = drawn.cut * complete.times.back();
    const measure::Measurement cut = cut_at(complete, start);
    const Found in_complete = found_in(complete, has_effect);
    const Found in_cut = found_in(cut, has_effect);
    const std::map<std::string, double> expected = truths(drawn.spec, complete);
    json comparison = json::object();
    for (const auto& [name, value] : in_complete.numbers)
        if (const auto other = in_cut.numbers.find(name); other != in_cut.numbers.end()) {
            const auto truth = expected.find(name);
            comparison[name] =
                compared(value, other->second,
                         truth == expected.end() ? std::nullopt : std::optional(truth->second));
        }
    json hidden = json::object();
    for (const beam::HiddenEffect& effect : drawn.spec.effects)
        hidden[effect.name] = effect.parameters;
    return {{"number", number},
            {"hidden", hidden},
            {"start_s", start},
            {"duration_s", complete.times.back()},
            {"noise_mm", 1e3 * drawn.spec.errors.noise},
            {"complete", in_complete.summary},
            {"cut", in_cut.summary},
            {"same_answer", in_complete.summary["answer"] == in_cut.summary["answer"]},
            {"same_model", !in_cut.model.empty() && in_complete.model == in_cut.model},
            {"comparison", comparison}};
}

void print(const json& out) {
    const json& hidden = out["hidden"];
    fmt::print("moving {} ({}, {:.3f} s from {:.3f} s on): {} | cut {} |",
               out["number"].get<std::uint64_t>(), hidden.empty() ? "null" : hidden.begin().key(),
               out["duration_s"].get<double>(), out["start_s"].get<double>(),
               out["complete"]["answer"].get<std::string>(),
               out["cut"]["answer"].get<std::string>());
    for (const auto& [name, of] : out["comparison"].items())
        fmt::print(" {} {:+.2f} %, {:+.1f} of noise, {:+.1f} with modes{};", name,
                   100.0 * of["relative_difference"].get<double>(), of["over_noise"].get<double>(),
                   of["over_noise_and_modes"].get<double>(),
                   of["agrees_by_noise_and_modes"].get<bool>() ? "" : " (disagree)");
    fmt::print("\n");
    std::fflush(stdout);
}

/// Prints the agreement of each number over the cases whose two recordings have the same model.
void print_agreement(const json& cases) {
    struct Counts {
        int all = 0, by_noise = 0, with_modes = 0, complete_covered = 0, cut_covered = 0;
    };
    std::map<std::string, Counts> counts;
    int same_answers = 0;
    for (const json& each : cases) {
        same_answers += each["same_answer"].get<bool>() ? 1 : 0;
        if (!each["same_model"].get<bool>())
            continue;
        for (const auto& [name, of] : each["comparison"].items()) {
            Counts& count = counts[name];
            ++count.all;
            count.by_noise += of["agrees_by_noise"].get<bool>() ? 1 : 0;
            count.with_modes += of["agrees_by_noise_and_modes"].get<bool>() ? 1 : 0;
            if (!of.contains("truth"))
                continue;
            count.complete_covered += of["complete"]["covered_by_noise_and_modes"] ? 1 : 0;
            count.cut_covered += of["cut"]["covered_by_noise_and_modes"] ? 1 : 0;
        }
    }
    fmt::print("\nThe same answer: {} of {}\n\n", same_answers, cases.size());
    fmt::print(
        "| number | same model | agree by noise | with modes | truth in complete | in cut |\n"
        "|---|---|---|---|---|---|\n");
    for (const auto& [name, count] : counts)
        fmt::print("| {} | {} | {} | {} | {} | {} |\n", name, count.all, count.by_noise,
                   count.with_modes, count.complete_covered, count.cut_covered);
}

} // namespace

int main(int argc, char** argv) {
    if (argc != 4) {
        fmt::print(stderr, "usage: bench_moving_recordings FIRST COUNT FILE\n");
        return 2;
    }
    const std::uint64_t first = std::strtoull(argv[1], nullptr, 10);
    const std::uint64_t count = std::strtoull(argv[2], nullptr, 10);
    bench::ResultFile results(argv[3]);
    results.add(
        bench::numbered(first, count), [](const json& key) { return case_of(key["number"]); },
        print);
    print_agreement(results.cases());
    return 0;
}
