// SPDX-License-Identifier: BSD-3-Clause
// Tests the answers of `culm diagnose` and their probabilities: diagnoses simulated recordings with
// known hidden effects (decision_cases.hpp), two at a time.
//
//   bench_decision SEED COUNT FILE [SECONDS]
//   bench_decision --write SEED KIND NUMBER FOLDER
//
// Adds the recordings that FILE does not hold yet, prints a line for each and, if all are there,
// the summary. After SECONDS no further recording is begun; the same command continues. Seed 60
// with 60 recordings is the fixed list; any other seed is a fresh one. The second form writes the
// recordings of one line as measurement folders for `culm diagnose`.
#include "bench/decision_cases.hpp"
#include "bench/decision_grade.hpp"
#include "bench/diagnosis_summary.hpp"
#include "bench/result_file.hpp"
#include "bench/run_program.hpp"
#include "diagnose/diagnosis.hpp"
#include "measure/folder/measurement_folder.hpp"
#include "physics/effects/library.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <ranges>
#include <string>
#include <vector>

#include <fmt/core.h>
#include <fmt/ranges.h>

namespace {

using namespace culm;
using bench::AnswerSet;
using bench::HiddenTruth;
using bench::Rate;
using nlohmann::json;

/// T of Policy::temperature that are compared.
constexpr std::array temperatures{1.0, 1.5, 2.0, 3.0, 4.0};
/// Limit of the wall time; a diagnosis that takes longer has failed.
constexpr double longest_s = 400.0;
/// Rms of the published chain over the noise from which an effect should be named.
constexpr double clearly_visible = 1.5;

double seconds_since(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// --- The truth of a case

/// Rms residual of the exact recordings with these effects, over the noise.
double over_noise_with(const fit::SelectedEffects& effects,
                       const std::vector<measure::Measurement>& exact) {
    std::vector<fit::SelectedEffects> sets;
    if (!effects.empty())
        sets.push_back(effects);
    const fit::Fit fit = fit::fit_nested(exact, sets).models.back().stated;
    return fit.rmse / *exact.front().noise;
}

std::vector<HiddenTruth> truth_of(const bench::DecisionCase& drawn) {
    std::vector<HiddenTruth> truth;
    for (const beam::HiddenEffect& hidden : drawn.hidden) {
        fit::SelectedEffects others;
        for (const beam::HiddenEffect& other : drawn.hidden)
            if (other.name != hidden.name)
                others.push_back(physics::parse_effect(other.name, {}));
        truth.push_back({hidden.name, over_noise_with(others, drawn.exact)});
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
    return truth;
}

// --- The answer

AnswerSet answer_set(const std::vector<diagnose::NamedFamily>& families) {
    AnswerSet set;
    for (const diagnose::NamedFamily& named : families)
        set.push_back({std::string(physics::to_string(named.family)), named.members});
    return set;
}

AnswerSet answer_set(const std::vector<std::string>& effects) {
    AnswerSet set;
    for (const std::string& name : effects)
        set.push_back(
            {std::string(physics::to_string(physics::effect_named(name)->family())), {name}});
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

/// Every explanation with its probability at each T, and whether it is the truth.
json explanations_of(const diagnose::SearchResult& search, diagnose::DiagnosisOptions options,
                     const std::vector<HiddenTruth>& truth) {
    json all = json::array();
    for (const double temperature : temperatures) {
        options.policy.temperature = temperature;
        const diagnose::Posterior posterior = diagnose::posterior_of(
            search, options,
            diagnose::has_structure(search.best_fit, search.recordings, options.policy));
        for (const diagnose::Explanation& each : posterior.explanations)
            if (each.probability > 1e-3)
                all.push_back({{"temperature", temperature},
                               {"effects", each.effects},
                               {"probability", each.probability},
                               {"is_truth", is_truth(answer_set(each.effects), truth)}});
    }
    return all;
}

json diagnosed(const bench::DecisionCase& drawn, const std::vector<HiddenTruth>& truth) {
    diagnose::DiagnosisOptions options;
    const auto start = std::chrono::steady_clock::now();
    options.candidate.heartbeat = [start] { return seconds_since(start) < longest_s; };
    options.candidates = fit::in_library_order(fit::candidate_effects(drawn.recordings));
    json out;
    bench::Answered answer;
    try {
        diagnose::SearchResult search = diagnose::search_models(drawn.recordings, options);
        out["explanations"] = explanations_of(search, options, truth);
        out["fits"] = search.visited.size();
        const diagnose::Diagnosis found = diagnose::decide(search, options);
        answer = answered(found);
        out["reason"] = found.reason;
        out["baseline_over_noise"] = found.stated_baseline.rmse / *drawn.recordings.front().noise;
        out["final_reduced_chi2"] = found.final_fit.reduced_chi_squared;
        if (answer.verdict != "unknown")
            out["sizes"] = sizes_of(drawn.hidden, found.ladder.back().stated);
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

/// Prints how often explanations of similar probability are the truth.
void print_reliability(const json& cases) {
    constexpr std::array edges{0.0, 0.05, 0.2, 0.5, 0.8, 0.95, 1.01};
    fmt::print("\n| T | mean log probability of the truth |");
    for (std::size_t k = 0; k + 1 < edges.size(); ++k)
        fmt::print(" {:.2f}-{:.2f} |", edges[k], std::min(edges[k + 1], 1.0));
    fmt::print("\n|---|---|{}\n",
               fmt::join(std::vector<std::string>(edges.size() - 1, "---|"), ""));
    for (const double temperature : temperatures) {
        std::array<Rate, edges.size() - 1> bins;
        double score = 0.0;
        int scored = 0;
        for (const json& each : cases) {
            // No explanation of the library is the truth if the library lacks the law.
            if (each["kind"] == "unknown" || !each.contains("explanations"))
                continue;
            double of_truth = 0.0;
            for (const json& explanation : each["explanations"]) {
                if (explanation["temperature"] != temperature)
                    continue;
                const double probability = explanation["probability"];
                of_truth += explanation["is_truth"] ? probability : 0.0;
                for (std::size_t k = 0; k < bins.size(); ++k)
                    if (probability >= edges[k] && probability < edges[k + 1])
                        bins[k].add(explanation["is_truth"]);
            }
            score += std::log(std::max(of_truth, 1e-3));
            ++scored;
        }
        fmt::print("| {} | {:.3f} |", temperature, score / std::max(scored, 1));
        for (const Rate& bin : bins)
            fmt::print(" {} |", bin.text());
        fmt::print("\n");
    }
}

void print_summary(const json& cases) {
    std::map<std::string, std::map<std::string, int>> grades;
    Rate false_names, wrong, held, visible, covered;
    std::vector<double> seconds;
    for (const json& each : cases) {
        const std::string grade = each["grade"];
        ++grades[each["kind"]][grade];
        seconds.push_back(each["seconds"]);
        (each["kind"] == "null" ? false_names : wrong).add(grade == "wrong");
        held.add(grade == "right" || grade == "tie");
        for (const json& hidden : each["hidden"])
            if (each["kind"] != "unknown" &&
                std::hypot(1.0, hidden["over_noise"].get<double>()) >= clearly_visible)
                visible.add(hidden["is_named"]);
        for (const json& size : each.value("sizes", json::array()))
            covered.add(std::abs(size["value"].get<double>() - size["truth"].get<double>()) <=
                        size["half_width"]);
    }
    fmt::print("\n");
    for (const auto& [kind, counts] : grades) {
        fmt::print("{}:", kind);
        for (const auto& [grade, count] : counts)
            fmt::print(" {} {},", grade, count);
        fmt::print("\n");
    }
    std::ranges::sort(seconds);
    fmt::print("false names without an effect: {}\n"
               "wrong family or absent effect: {}\n"
               "truth in the set:              {}\n"
               "named from {} x noise on:     {}\n"
               "95 % intervals that cover:     {}\n"
               "seconds on one core:           median {:.1f}, longest {:.1f}\n",
               false_names.text(), wrong.text(), held.text(), clearly_visible, visible.text(),
               covered.text(), seconds[seconds.size() / 2], seconds.back());
    print_reliability(cases);
}

void diagnose_all(std::uint64_t seed, std::size_t count, const std::string& file, double limit_s) {
    const auto start = std::chrono::steady_clock::now();
    bench::ResultFile results(file);
    const std::vector<json> keys = bench::decision_keys(seed, count);
    results.add(keys, case_of, print_case, [=] { return seconds_since(start) < limit_s; });
    if (results.cases().size() >= keys.size())
        print_summary(results.cases());
    else
        fmt::print("{} of {} recordings\n", results.cases().size(), keys.size());
}

void write_case(std::uint64_t seed, const std::string& kind, std::uint64_t number,
                const std::filesystem::path& folder) {
    const bench::DecisionCase drawn =
        bench::decision_case({{"seed", seed}, {"kind", kind}, {"number", number}});
    for (const measure::Measurement& recording : drawn.recordings)
        measure::write_measurement(folder / recording.stem.id, recording);
}

std::uint64_t whole(const char* text) {
    return std::strtoull(text, nullptr, 10);
}

} // namespace

int main(int argc, char** argv) {
    const bool writes = argc > 1 && std::string(argv[1]) == "--write";
    if (argc < (writes ? 6 : 4)) {
        fmt::print(stderr, "usage: bench_decision SEED COUNT FILE [SECONDS]\n"
                           "       bench_decision --write SEED KIND NUMBER FOLDER\n");
        return 2;
    }
    return bench::run_program([&] {
        if (writes)
            write_case(whole(argv[2]), argv[3], whole(argv[4]), argv[5]);
        else
            diagnose_all(whole(argv[1]), whole(argv[2]), argv[3],
                         argc > 4 ? std::atof(argv[4]) : HUGE_VAL);
    });
}
