// SPDX-License-Identifier: BSD-3-Clause
// Tests the diagnosis of laboratories: 8 to 16 stems of the beam generator on one rig, with known
// hidden effects (laboratory_cases.hpp).
//
//   [mpirun -n N] bench_laboratories FIRST COUNT FILE
//
// Adds the laboratories that FILE does not hold yet, prints a line for each of FILE and the rates.
// A laboratory follows from its number alone; its answer does not depend on the number of ranks.
//
// Nothing is hidden in laboratories 0, 5, …; one effect of the rig in 1, 6, …; two in 2, 7, …; an
// effect of some stems in 3, 8, …; one of the rig and one of some stems in 4, 9, …. An effect of
// the rig has one value for all stems: 0.3 to 2 times the detection limit (three standard
// deviations) of the first stem alone, which `culm diagnose` states for it without the effect.
//
// An effect is named if the conclusion is "effect", the best model contains it and its probability
// is at least Policy::held_probability. A general law counts as each of its special cases.
#include "bench/decision_grade.hpp"
#include "bench/diagnosis_summary.hpp"
#include "bench/laboratory_cases.hpp"
#include "bench/result_file.hpp"
#include "bench/run_program.hpp"
#include "diagnose/diagnosis.hpp"
#include "diagnose/ladder.hpp"
#include "farm/environment.hpp"
#include "farm/item_map.hpp"

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <optional>
#include <span>

#include <fmt/ranges.h>

namespace {

using namespace culm;
using bench::DrawnLaboratory;
using bench::Rate;
using bench::RigTruth;
using nlohmann::json;

using Recordings = std::vector<measure::Measurement>;

double seconds_since(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// Those of `culm diagnose` without options.
diagnose::DiagnosisOptions options_for(const Recordings& recordings, const core::ItemMap& map) {
    diagnose::DiagnosisOptions options;
    options.map = map;
    options.candidates = fit::in_library_order(fit::candidate_effects(recordings));
    return options;
}

/// Does a named family contain the hidden effect? An open one contains all of its laws.
bool stands_for(const json& named, const std::string& hidden) {
    const std::string family = named["family"];
    if (named["is_open"])
        return family == physics::to_string(physics::effect_named(hidden)->family);
    bench::Answered answer;
    answer.verdict = "effect";
    answer.certain = {bench::NamedEffects{family, named["members"]}};
    return bench::is_named(answer, {hidden});
}

// --- The truth of a laboratory

std::vector<RigTruth> hidden_in_rig(const DrawnLaboratory& drawn, const core::ItemMap& map) {
    if (drawn.strengths.empty())
        return {};
    DrawnLaboratory bare = drawn;
    bare.stems.front().own.clear();
    const Recordings first{bench::written_recording(bare, 0, {})};
    return bench::hidden_in_rig(
        drawn, diagnose::diagnose(diagnose::specimens_of(first), options_for(first, map))
                   .detection_limits);
}

/// (stems) rms residual of the published chain, over the noise, of exact recordings with the own
/// effects alone; 0 for stems without one, NaN if the chain cannot be fitted.
std::vector<double> own_over_noise(const DrawnLaboratory& drawn, const core::ItemMap& map) {
    std::vector<double> out;
    const auto of_stem = [&](std::size_t s, const core::Heartbeat&) {
        if (drawn.stems[s].own.empty())
            return 0.0;
        const Recordings exact{bench::exact_recording(drawn.stems[s], {})};
        return diagnose::fit_nested(exact, {}).models.back().rmse / drawn.stems[s].noise;
    };
    for (const core::ItemOutcome<double>& each :
         map.outcomes(std::vector(drawn.stems.size(), 1.0), of_stem))
        out.push_back(each.value.value_or(std::numeric_limits<double>::quiet_NaN()));
    return out;
}

json rig_truth_json(const std::vector<RigTruth>& of_rig) {
    json out = json::array();
    for (const RigTruth& each : of_rig)
        out.push_back({{"effect", each.effect.name},
                       {"parameter", each.effect.parameters.front().first},
                       {"truth", each.effect.parameters.front().second},
                       {"over_limit", each.over_limit},
                       {"limit_of_first_stem", each.limit}});
    return out;
}

json stems_truth_json(const DrawnLaboratory& drawn, const core::ItemMap& map) {
    const std::vector<double> over_noise = own_over_noise(drawn, map);
    json out = json::array();
    for (std::size_t s = 0; s < drawn.stems.size(); ++s) {
        json& stem =
            out.emplace_back(json{{"name", drawn.stems[s].spec.id},
                                  {"noise_mm", 1e3 * drawn.stems[s].noise},
                                  {"true_modulus", drawn.stems[s].spec.stem.youngs_modulus},
                                  {"own", json::object()},
                                  {"named", json::array()}});
        for (const beam::HiddenEffect& own : drawn.stems[s].own)
            stem["own"][own.name] = {{"parameters", own.parameters}, {"over_noise", over_noise[s]}};
    }
    return out;
}

// --- The answer

/// The answer about an effect of the rig, with the truth of the values. A stiffness may be
/// infinite, which JSON lacks.
json rig_answer_json(const diagnose::EffectAnswer& answer, const std::vector<RigTruth>& of_rig) {
    json out{{"effect", answer.effect},
             {"probability", answer.probability},
             {"family", answer.family},
             {"family_probability", answer.family_probability},
             {"values", json::array()}};
    for (const diagnose::SharedValue& each : answer.values) {
        json& value = out["values"].emplace_back(json{{"name", each.name},
                                                      {"value", each.value},
                                                      {"lower", each.lower},
                                                      {"upper", each.upper}});
        for (const RigTruth& hidden : of_rig)
            if (const auto& [name, truth] = hidden.effect.parameters.front();
                hidden.effect.name == answer.effect && name == each.name)
                value["covers"] = each.lower <= truth && truth <= each.upper;
    }
    return out;
}

/// The families that are certain, with the stems that have an effect of them.
void add_named(const diagnose::Diagnosis& found, json& out) {
    out["named"] = json::array();
    for (const diagnose::NamedFamily& family : found.families) {
        json named{{"family", physics::to_string(family.family)},
                   {"members", family.members},
                   {"is_open", family.is_open},
                   {"rig", family.rig}};
        for (const diagnose::EffectAnswer& each : found.answers)
            if (each.rig.empty() && family.rig.empty() &&
                std::ranges::find(family.members, each.effect) != family.members.end())
                for (json& stem : out["stems"])
                    if (std::ranges::find(each.stems, stem["name"].get<std::string>()) !=
                        each.stems.end())
                        stem["named"].push_back(named);
        out["named"].push_back(std::move(named));
    }
}

/// Y over its truth, mean of the stems that were fitted.
double modulus_ratio(const DrawnLaboratory& drawn, const diagnose::Diagnosis& found,
                     diagnose::StemNumbers diagnose::StemAnswer::*numbers) {
    double sum = 0.0;
    double count = 0.0;
    for (std::size_t s = 0; s < drawn.stems.size(); ++s)
        if (found.stems[s].failure.empty()) {
            sum +=
                (found.stems[s].*numbers).youngs_modulus / drawn.stems[s].spec.stem.youngs_modulus;
            ++count;
        }
    return sum / count;
}

void add_stem_answers(const diagnose::Diagnosis& found, json& stems) {
    for (std::size_t s = 0; s < found.stems.size(); ++s) {
        const diagnose::StemAnswer& answer = found.stems[s];
        stems[s].update({{"failure", answer.failure},
                         {"modulus_before", answer.before.youngs_modulus},
                         {"modulus_after", answer.after.youngs_modulus},
                         {"modulus_error", answer.after.youngs_modulus_error},
                         {"finding", to_string(answer.finding)},
                         {"over_noise", answer.after.over_noise}});
    }
}

void add_own_answers(const diagnose::Diagnosis& found, json& out) {
    for (const diagnose::EffectAnswer& each : found.answers)
        if (each.rig.empty())
            out["own_answers"].push_back({{"effect", each.effect},
                                          {"probability", each.probability},
                                          {"stems", each.stems},
                                          {"possible_stems", each.possible_stems}});
}

void add_answer(const DrawnLaboratory& drawn, const std::vector<RigTruth>& of_rig,
                const core::ItemMap& map, json& out) {
    std::vector<beam::HiddenEffect> effects;
    for (const RigTruth& each : of_rig)
        effects.push_back(each.effect);
    Recordings recordings;
    for (std::size_t s = 0; s < drawn.stems.size(); ++s)
        recordings.push_back(bench::written_recording(drawn, s, effects));
    const std::vector<diagnose::Specimen> specimens = diagnose::specimens_of(recordings);
    const diagnose::Diagnosis found = diagnose::diagnose(specimens, options_for(recordings, map));
    out["conclusion"] = to_string(found.conclusion);
    out["reason"] = found.reason;
    for (const diagnose::EffectAnswer& each : found.answers)
        if (!each.rig.empty())
            out["rig_answers"].push_back(rig_answer_json(each, of_rig));
    add_own_answers(found, out);
    add_named(found, out);
    add_stem_answers(found, out["stems"]);
    out["modulus_ratio_before"] = modulus_ratio(drawn, found, &diagnose::StemAnswer::before);
    out["modulus_ratio_after"] = modulus_ratio(drawn, found, &diagnose::StemAnswer::after);
}

/// Collective. An error that all ranks meet is an answer, a lost farm is not.
json case_of(std::uint64_t number, const core::ItemMap& map) {
    const DrawnLaboratory drawn = bench::drawn_laboratory(number);
    json out{{"number", number},
             {"kind", drawn.kind},
             {"hidden_in_rig", json::array()},
             {"rig_answers", json::array()},
             {"own_answers", json::array()},
             {"stems", stems_truth_json(drawn, map)}};
    auto start = std::chrono::steady_clock::now();
    try {
        const std::vector<RigTruth> of_rig = hidden_in_rig(drawn, map);
        out["hidden_in_rig"] = rig_truth_json(of_rig);
        out["seconds_for_limits"] = seconds_since(start);
        start = std::chrono::steady_clock::now();
        add_answer(drawn, of_rig, map, out);
    } catch (const farm::FarmError&) {
        throw;
    } catch (const std::runtime_error& error) {
        out["conclusion"] = "failed";
        out["reason"] = error.what();
    }
    out["seconds"] = seconds_since(start);
    return out;
}

// --- Lines and rates

/// "air (quadratic_drag)", "taper or stiffness_gradient".
std::string text_of(const json& named) {
    const std::string members =
        fmt::format("{}", fmt::join(named["members"].get<std::vector<std::string>>(), " or "));
    return named["is_open"] ? fmt::format("{} ({})", named["family"].get<std::string>(), members)
                            : members;
}

/// The stems by the effects in a field of theirs: "taper in 3".
std::vector<std::string> own_texts(const json& stems, const char* field) {
    std::map<std::string, int> counts;
    for (const json& stem : stems)
        for (const auto& [key, value] : stem[field].items())
            ++counts[stem[field].is_array() ? text_of(value) : key];
    std::vector<std::string> texts;
    for (const auto& [effect, count] : counts)
        texts.push_back(fmt::format("{} in {}", effect, count));
    return texts;
}

void print(const json& each) {
    std::vector<std::string> hidden;
    for (const json& truth : each["hidden_in_rig"])
        hidden.push_back(fmt::format("{} x{:.2f}", truth["effect"].get<std::string>(),
                                     truth["over_limit"].get<double>()));
    std::ranges::copy(own_texts(each["stems"], "own"), std::back_inserter(hidden));
    std::vector<std::string> answers;
    if (each.contains("named"))
        for (const json& named : each["named"])
            answers.push_back(text_of(named) + (named["rig"] == "" ? " of stems" : " of the rig"));
    std::ranges::copy(own_texts(each["stems"], "named"), std::back_inserter(answers));
    fmt::print("{:>3}  {:<5} {:>2} stems  [{}]  {}: {}  {:.0f} s{}\n",
               each["number"].get<std::uint64_t>(), each["kind"].get<std::string>(),
               each["stems"].size(), fmt::join(hidden, ", "), each["conclusion"].get<std::string>(),
               fmt::join(answers, ", "), each["seconds"].get<double>(),
               each["conclusion"] == "failed" ? ": " + each["reason"].get<std::string>() : "");
    std::fflush(stdout);
}

/// Rates over all laboratories.
struct Rates {
    std::array<Rate, 3> found; ///< by the strength over the limit
    Rate false_alarms;         ///< laboratories without an effect in which one is named
    Rate not_adequate;         ///< likewise, with any answer but "adequate"
    Rate wrong_effects;        ///< named effects of the rig that are not hidden
    Rate identified;           ///< stems with an own effect
    Rate material;             ///< likewise, if it is not immaterial
    Rate wrong_stems; ///< stems with a named effect that they do not have, of those with one
    Rate covered;     ///< shared values of hidden effects
    Rate failed;
};
constexpr std::array strength_edges{bench::weakest, 0.5, 1.0, bench::strongest};

void add_rig_effects(const json& each, Rates& rates) {
    const json& named = each["named"];
    for (const json& hidden : each["hidden_in_rig"]) {
        const double over_limit = hidden["over_limit"];
        const auto bin = over_limit < strength_edges[1]   ? 0U
                         : over_limit < strength_edges[2] ? 1U
                                                          : 2U;
        rates.found[bin].add(std::ranges::any_of(named, [&](const json& family) {
            return family["rig"] != "" && stands_for(family, hidden["effect"]);
        }));
    }
    for (const json& answer : each["rig_answers"])
        for (const json& value : answer["values"])
            if (value.contains("covers"))
                rates.covered.add(value["covers"]);
    for (const json& family : named)
        if (family["rig"] != "")
            rates.wrong_effects.add(
                std::ranges::none_of(each["hidden_in_rig"], [&](const json& hidden) {
                    return stands_for(family, hidden["effect"]);
                }));
}

void add_stems(const json& stems, Rates& rates) {
    for (const json& stem : stems) {
        bool has_wrong = false;
        for (const json& named : stem["named"]) {
            bool is_own = false;
            for (const auto& [own, truth] : stem["own"].items())
                is_own = is_own || stands_for(named, own);
            has_wrong = has_wrong || !is_own;
        }
        if (!stem["named"].empty())
            rates.wrong_stems.add(has_wrong);
        for (const auto& [own, truth] : stem["own"].items()) {
            const bool is_found = std::ranges::any_of(
                stem["named"], [&](const json& named) { return stands_for(named, own); });
            rates.identified.add(is_found);
            if (!truth["over_noise"].is_null() &&
                truth["over_noise"] > diagnose::Policy{}.immaterial_noise)
                rates.material.add(is_found);
        }
    }
}

void print_modulus(const json& cases) {
    for (const char* when : {"before", "after"}) {
        const std::string field = fmt::format("modulus_ratio_{}", when);
        double bias = 0.0;
        double square = 0.0;
        double count = 0.0;
        for (const json& each : cases)
            if (each.contains(field) && !each[field].is_null()) {
                const double error = each[field].get<double>() - 1.0;
                bias += error;
                square += error * error;
                ++count;
            }
        fmt::print("error of the mean Y {:<6} the effects: mean {:+.2f} %, rms {:.2f} %\n", when,
                   100.0 * bias / count, 100.0 * std::sqrt(square / count));
    }
}

void print_summary(const json& cases) {
    Rates rates;
    for (const json& each : cases) {
        rates.failed.add(each["conclusion"] == "failed");
        if (each["conclusion"] == "failed")
            continue;
        if (each["kind"] == "null") {
            rates.false_alarms.add(each["conclusion"] == "effect");
            rates.not_adequate.add(each["conclusion"] != "adequate");
        }
        add_rig_effects(each, rates);
        add_stems(each["stems"], rates);
    }
    fmt::print("\neffects of rigs: {}\n", fmt::join(bench::sizable_rig_effects(), ", "));
    for (std::size_t k = 0; k < rates.found.size(); ++k)
        fmt::print("found at {} to {} limits of one stem: {}\n", strength_edges[k],
                   strength_edges[k + 1], rates.found[k].text());
    Rate found;
    for (const Rate& each : rates.found) {
        found.hits += each.hits;
        found.of += each.of;
    }
    for (const auto& [text, rate] :
         {std::pair{"found effects of the rig", found},
          {"false alarms without an effect", rates.false_alarms},
          {"… or another answer than adequate", rates.not_adequate},
          {"wrong among the named effects of rigs", rates.wrong_effects},
          {"identified stems of those with an own effect", rates.identified},
          {"… of those with a material one", rates.material},
          {"wrong among the stems with a named own effect", rates.wrong_stems},
          {"intervals of shared values that cover", rates.covered},
          {"failed laboratories", rates.failed}})
        fmt::print("{}: {}\n", text, rate.text());
    print_modulus(cases);
}

// --- The program

/// Collective; `communicator` is null without a launcher. Rank 0 alone has the file.
void diagnose_all(const std::vector<json>& keys, const std::string& file,
                  const farm::Communicator* communicator) {
    std::optional<bench::ResultFile> results;
    const auto wanted = farm::on_root(communicator, [&] {
        try {
            results.emplace(file);
        } catch (const std::exception& error) {
            throw core::InputError(error.what());
        }
        std::vector<std::uint64_t> numbers;
        for (const json& key : results->missing(keys))
            numbers.push_back(key["number"]);
        return numbers;
    });
    const core::ItemMap map = farm::over_ranks(communicator);
    if (!results) {
        for (const std::uint64_t number : wanted)
            case_of(number, map);
        return;
    }
    // On one thread: every diagnosis uses all ranks.
    results->add(
        keys, [&](const json& key) { return case_of(key["number"], map); }, print,
        [] { return true; }, 1);
    fmt::print("\nall laboratories of {}:\n", file);
    for (const json& each : results->cases())
        print(each);
    print_summary(results->cases());
}

/// The exit code.
int diagnose_on_ranks(int argc, char** argv) {
    const std::vector<json> keys =
        bench::numbered(std::strtoull(argv[1], nullptr, 10), std::strtoull(argv[2], nullptr, 10));
    if (!farm::Environment::is_under_launcher()) {
        diagnose_all(keys, argv[3], nullptr);
        return 0;
    }
    const farm::Environment environment(argc, argv);
    const farm::Communicator communicator = environment.world();
    try {
        diagnose_all(keys, argv[3], &communicator);
        return 0;
    } catch (const core::InputError& error) { // every rank meets it
        if (communicator.rank() == 0)
            fmt::print(stderr, "{}\n", error.what());
        return 1;
    }
}

} // namespace

int main(int argc, char** argv) {
    if (argc != 4) {
        fmt::print(stderr, "usage: bench_laboratories FIRST COUNT FILE\n");
        return 2;
    }
    int exit_code = 0;
    const int error = bench::run_program([&] { exit_code = diagnose_on_ranks(argc, argv); });
    return error != 0 ? error : exit_code;
}
