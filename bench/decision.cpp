// SPDX-License-Identifier: BSD-3-Clause
// Tests the answers of `culm diagnose` and their probabilities: diagnoses simulated recordings with
// known hidden effects, whose laws are not quite those of the library (decision_cases.hpp), two at
// a time.
//
//   bench_decision HALF FILE [SECONDS]
//   bench_decision --write HALF KIND NUMBER FOLDER
//
// HALF is "tuning", whose recordings may lead to changes, or "judging", which is run once for a
// version. Adds the recordings that FILE does not hold yet, prints a line for each, and then the
// summary of those that FILE holds. After SECONDS no further recording is begun; the same command
// continues. The second form writes the recordings of one line as measurement folders for
// `culm diagnose`.
#include "bench/decision_cases.hpp"
#include "bench/decision_grade.hpp"
#include "bench/diagnosis_summary.hpp"
#include "bench/result_file.hpp"
#include "bench/run_program.hpp"
#include "diagnose/diagnosis.hpp"
#include "diagnose/ladder.hpp"
#include "measure/folder/measurement_folder.hpp"
#include "physics/effects/library.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <vector>

#include <boost/math/distributions/binomial.hpp>
#include <fmt/core.h>
#include <fmt/ranges.h>

namespace {

using namespace culm;
using bench::AnswerSet;
using bench::HiddenTruth;
using bench::Rate;
using nlohmann::json;

/// Limit of the wall time; a diagnosis that takes longer has failed.
constexpr double longest_s = 400.0;
/// Rms of the published chain over the noise from which an effect should be named.
constexpr double clearly_visible = 1.5;
/// Rms residual over the noise from which another loss of the second mode may be named.
constexpr double visible_loss = 0.2;

double seconds_since(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// --- The truth of a case

/// Rms residual of the exact recordings with these effects, over the noise.
double over_noise_with(const fit::SelectedEffects& effects,
                       std::span<const measure::Measurement> exact) {
    std::vector<fit::SelectedEffects> sets;
    if (!effects.empty())
        sets.push_back(effects);
    return diagnose::fit_nested(exact, sets).models.back().rmse / *exact.front().noise;
}

/// All hidden effects but the one that is not wanted. A law that the library lacks is omitted.
fit::SelectedEffects effects_without(const std::string& unwanted,
                                     const bench::DecisionCase& drawn) {
    fit::SelectedEffects effects;
    for (const beam::HiddenEffect& hidden : drawn.hidden)
        if (hidden.name != unwanted && bench::is_in_library(hidden.name))
            effects.push_back(physics::parse_effect(hidden.name, {}));
    return effects;
}

std::vector<HiddenTruth> truth_of(const bench::DecisionCase& drawn) {
    std::vector<HiddenTruth> truth;
    // The library's laws are not those of the beam; what they leave is no effect's.
    double floor = 0.0;
    if (drawn.hidden.size() > 1 || drawn.exact.size() > 1)
        floor = over_noise_with(effects_without("", drawn), drawn.exact);
    for (const beam::HiddenEffect& hidden : drawn.hidden) {
        const double left = over_noise_with(effects_without(hidden.name, drawn), drawn.exact);
        truth.push_back({hidden.name, std::sqrt(std::max(0.0, left * left - floor * floor))});
    }
    const diagnose::Policy policy;
    for (HiddenTruth& each : truth) {
        double larger = 0.0; // rms that the other effect explains
        for (const HiddenTruth& other : truth)
            if (other.over_noise > each.over_noise)
                larger = other.over_noise;
        each.is_material =
            each.over_noise > std::max(policy.immaterial_noise, policy.immaterial_share * larger);
    }
    // A second mode with another loss is a material that is not the library's: it may be named as
    // material damping, and need not be.
    if (const double loss = over_noise_with({}, drawn.lossy); loss > visible_loss)
        truth.push_back({std::string(bench::second_loss), loss, false});
    // The laws of air and of material damping are never exactly those of the library.
    for (HiddenTruth& each : truth)
        each.family = bench::family_of(each.effect);
    return truth;
}

// --- The answer

AnswerSet answer_set(const std::vector<diagnose::NamedFamily>& families) {
    AnswerSet set;
    for (const diagnose::NamedFamily& named : families)
        set.push_back({std::string(physics::to_string(named.family)), named.members});
    return set;
}

AnswerSet answer_set(const std::vector<diagnose::OwnedEffect>& effects) {
    AnswerSet set;
    for (const auto& [name, rig] : effects)
        set.push_back(
            {std::string(physics::to_string(physics::effect_named(name)->family)), {name}});
    return set;
}

bench::Answered answered(const diagnose::Diagnosis& found) {
    bench::Answered answer;
    answer.verdict = to_string(found.conclusion);
    answer.certain = answer_set(found.families);
    for (const diagnose::FamilyExplanation& each : found.alternatives)
        answer.candidates.push_back(answer_set(each.families));
    return answer;
}

/// Hidden sizes that are among the numbers of the answer.
json sizes_of(const std::vector<beam::HiddenEffect>& hidden, const fit::Fit& fit) {
    json sizes = json::array();
    for (const beam::HiddenEffect& effect : hidden)
        for (const auto& [name, value] : effect.parameters)
            for (const fit::FittedParameter& parameter : fit.parameters)
                if (parameter.id.effect == effect.name && parameter.id.name == name &&
                    !parameter.is_place)
                    sizes.push_back({{"name", to_string(parameter.id)},
                                     {"truth", value},
                                     {"value", parameter.value},
                                     {"half_width", interval_half_width(parameter)}});
    return sizes;
}

std::vector<std::string> names_of(const std::vector<diagnose::OwnedEffect>& effects) {
    std::vector<std::string> names;
    for (const auto& [name, rig] : effects)
        names.push_back(name);
    return names;
}

/// Every explanation with its probability, and whether it is the truth.
json explanations_of(const diagnose::Posterior& posterior, const std::vector<HiddenTruth>& truth) {
    json all = json::array();
    for (const diagnose::Explanation& each : posterior.explanations)
        if (each.probability > 1e-3)
            all.push_back({{"effects", names_of(each.effects)},
                           {"probability", each.probability},
                           {"is_truth", is_truth(answer_set(each.effects), truth)}});
    return all;
}

json diagnosed(const bench::DecisionCase& drawn, const std::vector<HiddenTruth>& truth) {
    diagnose::DiagnosisOptions options;
    const auto start = std::chrono::steady_clock::now();
    options.candidate.heartbeat = [start] { return seconds_since(start) < longest_s; };
    const std::span<const measure::Measurement> recordings(drawn.recordings);
    options.candidates = fit::in_library_order(fit::candidate_effects(recordings));
    json out;
    bench::Answered answer;
    try {
        const diagnose::Diagnosis found =
            diagnose::diagnose(diagnose::specimens_of(recordings), options);
        out["fits"] = found.posterior.models.size();
        answer = answered(found);
        out["explanations"] = explanations_of(found.posterior, truth);
        out["reason"] = found.reason;
        out["baseline_over_noise"] = found.baseline.rmse / *recordings.front().noise;
        out["final_reduced_chi2"] = found.final_fit.reduced_chi_squared;
        if (answer.verdict != "unknown")
            out["sizes"] = sizes_of(drawn.hidden, found.final_fit);
    } catch (const std::exception& error) {
        answer.verdict = "failed";
        out["reason"] = error.what();
    } catch (const run::Abandoned&) {
        answer.verdict = "failed";
        out["reason"] = fmt::format("no answer after {} s", longest_s);
    }
    out["seconds"] = seconds_since(start);
    out["verdict"] = answer.verdict;
    out["candidates"] = answer.candidates;
    out["grade"] = grade(answer, truth);
    out["hidden"] = json::array();
    for (const HiddenTruth& each : truth)
        out["hidden"].push_back({{"effect", each.effect},
                                 {"over_noise", each.over_noise},
                                 {"is_material", each.is_material},
                                 {"is_named", is_named(answer, each)}});
    return out;
}

json case_of(const json& key) {
    const bench::DecisionCase drawn = bench::decision_case(key);
    return diagnosed(drawn, truth_of(drawn));
}

// --- Lines and summary

std::string text_of(const json& set) {
    std::vector<std::string> names;
    for (const json& named : set)
        names.push_back(
            fmt::format("{}", fmt::join(named["members"].get<std::vector<std::string>>(), "/")));
    return names.empty() ? std::string("nothing") : fmt::format("{}", fmt::join(names, "+"));
}

void print_case(const json& each) {
    std::vector<std::string> hidden;
    for (const json& truth : each["hidden"])
        hidden.push_back(fmt::format("{} {:.2f}{}", truth["effect"].get<std::string>(),
                                     truth["over_noise"].get<double>(),
                                     truth["is_material"] ? "" : " (immaterial)"));
    std::vector<std::string> answers;
    for (const json& set : each["candidates"])
        answers.push_back(text_of(set));
    fmt::print("{:<8} {:>2}  {:<7} [{}]  {}: {}  {:.0f} s, {} fits{}\n",
               each["kind"].get<std::string>(), each["number"].get<int>(),
               each["grade"].get<std::string>(), fmt::join(hidden, ", "),
               each["verdict"].get<std::string>(), fmt::join(answers, " | "),
               each["seconds"].get<double>(), each.value("fits", 0),
               each["grade"] == "failed" ? ": " + each["reason"].get<std::string>() : "");
    std::fflush(stdout);
}

/// How often explanations of similar probability are the truth, and Brier's score: the mean square
/// of an explanation's probability less 1 if it is the truth, summed over the explanations of a
/// recording.
void print_reliability(const json& cases) {
    constexpr std::array edges{0.0, 0.05, 0.2, 0.5, 0.8, 0.95, 1.01};
    std::array<Rate, edges.size() - 1> bins;
    double log_score = 0.0;
    double brier = 0.0;
    int scored = 0;
    for (const json& each : cases) {
        // No explanation of the library is the truth if the library lacks the law.
        if (each["kind"] == "unknown" || !each.contains("explanations"))
            continue;
        double of_truth = 0.0;
        for (const json& explanation : each["explanations"]) {
            const double probability = explanation["probability"];
            const bool is_truth = explanation["is_truth"];
            brier += std::pow(probability - (is_truth ? 1.0 : 0.0), 2);
            of_truth += is_truth ? probability : 0.0;
            for (std::size_t k = 0; k < bins.size(); ++k)
                if (probability >= edges[k] && probability < edges[k + 1])
                    bins[k].add(is_truth);
        }
        log_score += std::log(std::max(of_truth, 1e-3));
        ++scored;
    }
    fmt::print("\n| probability | explanations that are the truth |\n|---|---|\n");
    for (std::size_t k = 0; k < bins.size(); ++k)
        fmt::print("| {:.2f}-{:.2f} | {} |\n", edges[k], std::min(edges[k + 1], 1.0),
                   bins[k].text());
    fmt::print("\nmean log probability of the truth: {:.3f}\nBrier's score: {:.3f}\n",
               log_score / std::max(scored, 1), brier / std::max(scored, 1));
}

/// The rate with the upper end of its one-sided 95 % interval (Clopper & Pearson 1934).
std::string bounded(const Rate& rate) {
    const double bound =
        rate.of == 0
            ? 1.0
            : boost::math::binomial_distribution<>::find_upper_bound_on_p(rate.of, rate.hits, 0.05);
    return fmt::format("{}, with 95 % confidence at most {:.1f} %", rate.text(), 100.0 * bound);
}

bool is_clearly_visible(const json& hidden) {
    return hidden["is_material"] &&
           std::hypot(1.0, hidden["over_noise"].get<double>()) >= clearly_visible;
}

void print_summary(const json& cases) {
    std::map<std::string, std::map<std::string, int>> grades;
    Rate wrong, held, visible, covered, failed;
    std::vector<double> seconds;
    for (const json& each : cases) {
        const std::string grade = each["grade"];
        ++grades[each["kind"]][grade];
        seconds.push_back(each["seconds"]);
        wrong.add(grade == "wrong");
        failed.add(grade == "failed");
        if (each["kind"] != "unknown")
            held.add(grade == "right" || grade == "tie");
        for (const json& hidden : each["hidden"])
            if (each["kind"] != "unknown" && is_clearly_visible(hidden))
                visible.add(hidden["is_named"]);
        for (const json& size : each.value("sizes", json::array()))
            covered.add(std::abs(size["value"].get<double>() - size["truth"].get<double>()) <=
                        size["half_width"]);
    }
    fmt::print("\n{} recordings\n", cases.size());
    for (const auto& [kind, counts] : grades) {
        fmt::print("{}:", kind);
        for (const auto& [grade, count] : counts)
            fmt::print(" {} {},", grade, count);
        fmt::print("\n");
    }
    std::ranges::sort(seconds);
    fmt::print("wrong names:                   {}\n"
               "truth in the set:              {}\n"
               "named from {} x noise on:     {}\n"
               "without an answer:             {}\n"
               "95 % intervals that cover:     {}\n"
               "seconds on one core:           median {:.1f}, longest {:.1f}\n",
               bounded(wrong), held.text(), clearly_visible, visible.text(), failed.text(),
               covered.text(), seconds[seconds.size() / 2], seconds.back());
    print_reliability(cases);
}

void diagnose_all(const std::string& half, const std::string& file, double limit_s) {
    const auto start = std::chrono::steady_clock::now();
    bench::ResultFile results(file);
    results.add(bench::decision_keys(half), case_of, print_case,
                [=] { return seconds_since(start) < limit_s; });
    if (!results.cases().empty())
        print_summary(results.cases());
}

void write_case(const std::string& half, const std::string& kind, std::uint64_t number,
                const std::filesystem::path& folder) {
    for (const measure::Measurement& recording :
         bench::decision_case({{"half", half}, {"kind", kind}, {"number", number}}).recordings)
        measure::write_measurement(folder / recording.stem.id, recording);
}

} // namespace

int main(int argc, char** argv) {
    const std::vector<std::string> words(argv + 1, argv + argc);
    const bool writes = !words.empty() && words.front() == "--write";
    if (words.size() < (writes ? 5 : 2)) {
        fmt::print(stderr, "usage: bench_decision tuning|judging FILE [SECONDS]\n"
                           "       bench_decision --write tuning|judging KIND NUMBER FOLDER\n");
        return 2;
    }
    return bench::run_program([&] {
        if (writes)
            write_case(words[1], words[2], std::stoull(words[3]), words[4]);
        else
            diagnose_all(words[0], words[1], words.size() > 2 ? std::stod(words[2]) : HUGE_VAL);
    });
}
