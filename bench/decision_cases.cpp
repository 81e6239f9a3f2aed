// SPDX-License-Identifier: BSD-3-Clause
#include "bench/decision_cases.hpp"

#include "bench/misstated_inputs.hpp"
#include "bench/reading_noise.hpp"
#include "tests/beam_generator/random_case.hpp"
#include "tests/beam_generator/random_effect.hpp"
#include "tests/beam_generator/recording.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <stdexcept>
#include <utility>

#include <fmt/core.h>

namespace culm::bench {
namespace {

using nlohmann::json;

/// Kinds and how many cases of a half are of each.
constexpr std::array<std::pair<std::string_view, std::uint64_t>, 6> kinds{{{"null", 50},
                                                                           {"single", 60},
                                                                           {"pair", 25},
                                                                           {"unknown", 15},
                                                                           {"known_mass", 5},
                                                                           {"correlated", 20}}};

/// Numbers of eight whose noise is of one of these families; that of the others is autoregressive.
constexpr std::array<std::string_view, 3> other_noise{"student", "outliers", "quantised"};
constexpr std::uint64_t noise_cycle = 8;

std::uint64_t seed_of(std::string_view half) {
    if (half == "tuning")
        return 2026;
    if (half == "judging")
        return 7130;
    throw std::invalid_argument(fmt::format("{} is no half: tuning or judging", half));
}

beam::LawErrors law_errors(const beam::RecordingSpec& spec, std::uint64_t seed,
                           std::uint64_t stream) {
    beam::Dice dice({seed, beam::RandomUse::CaseDraw, 0, stream << 8U});
    beam::LawErrors errors;
    errors.second_frequency_share = dice.between(-0.02, 0.02);
    errors.second_loss_ratio = dice.log_between(1.0 / 1.5, 1.5);
    errors.drag_exponent = dice.between(1.6, 2.1);
    // The mean speed of the stem, about half of the tip's rms speed.
    errors.drag_speed =
        0.35 * 2.0 * std::numbers::pi * spec.stem.first_frequency() * spec.tip_deflection;
    errors.clamp_loss_factor = dice.between(0.0, 0.1);
    const int times = dice.whole(2, 3);
    double total = 0.0;
    for (int k = 0; k < times; ++k) {
        errors.relaxation.push_back(
            {dice.between(0.3, 1.0), std::pow(10.0, static_cast<double>(k) / (times - 1) - 0.5)});
        total += errors.relaxation.back().share;
    }
    for (beam::RelaxationPart& part : errors.relaxation)
        part.share /= total;
    return errors;
}

void add_noise(double size, std::uint64_t seed, std::uint64_t number, const std::string& kind,
               measure::Measurement& measurement) {
    std::mt19937_64 dice = dice_for(seed, number, kind);
    std::uniform_real_distribution<double> share;
    const double correlation = 0.9 * share(dice);
    const bool is_common = share(dice) < 0.5;
    const std::uint64_t family = number % noise_cycle;
    if (kind == "correlated")
        Noise(Noise::Autoregression{0.9, false}, dice()).add(size, measurement);
    else if (family < other_noise.size())
        Noise(std::string(other_noise[family]), dice()).add(size, measurement);
    else
        Noise(Noise::Autoregression{correlation, is_common}, dice()).add(size, measurement);
}

/// Stem, camera and effects of a case: those of "known_mass" and "correlated" continue the lists of
/// single effects and of none.
beam::RandomCase drawn_case(std::uint64_t seed, const std::string& kind, std::uint64_t number) {
    if (kind == "known_mass")
        return beam::random_case(seed, beam::CaseKind::Single, 60 + number);
    if (kind == "correlated")
        return number % 2 == 0 ? beam::random_case(seed, beam::CaseKind::Null, 50 + number)
                               : beam::random_case(seed, beam::CaseKind::Single, 80 + number);
    return beam::random_case(seed, beam::case_kind(kind), number);
}

/// The recording, with a mass at the tip that it states; 0: none.
measure::Measurement recorded(beam::RecordingSpec spec, double mass, double noise) {
    if (mass > 0.0) {
        const auto hidden = std::ranges::find(spec.effects, "tip_mass", &beam::HiddenEffect::name);
        if (hidden == spec.effects.end())
            spec.effects.push_back({"tip_mass", {{"mass_kg", mass}}});
        else
            hidden->parameters.front().second += mass;
        spec.id += "-loaded";
    }
    measure::Measurement measurement = beam::record(spec);
    measurement.specimen = "stem";
    measurement.noise = noise;
    if (mass > 0.0)
        measurement.stem.added_masses.push_back({.height = spec.stem.length, .mass = mass});
    return measurement;
}

/// The masses at the tip of the recordings of a case, kg.
std::vector<double> masses_of(const std::string& kind, const beam::BeamStem& stem,
                              std::uint64_t seed, std::uint64_t number) {
    std::vector<double> masses{0.0};
    if (kind == "known_mass") {
        std::mt19937_64 dice = dice_for(seed, number, "mass");
        masses.push_back(std::uniform_real_distribution<double>(0.5, 1.5)(dice) *
                         stem.mass_per_length() * stem.length);
    }
    return masses;
}

} // namespace

std::vector<json> decision_keys(std::string_view half) {
    static_cast<void>(seed_of(half));
    std::vector<std::pair<double, json>> keys;
    for (const auto& [kind, count] : kinds)
        for (std::uint64_t number = 0; number < count; ++number)
            keys.emplace_back((static_cast<double>(number) + 0.5) / static_cast<double>(count),
                              json{{"half", half}, {"kind", kind}, {"number", number}});
    std::ranges::stable_sort(keys, {}, &std::pair<double, json>::first);
    std::vector<json> sorted;
    for (auto& [place, key] : keys)
        sorted.push_back(std::move(key));
    return sorted;
}

DecisionCase decision_case(const json& key) {
    const std::uint64_t number = key.at("number");
    const std::string kind = key.at("kind");
    const std::uint64_t seed = seed_of(key.at("half").get<std::string>());
    beam::RandomCase drawn = drawn_case(seed, kind, number);
    beam::RecordingSpec& spec = drawn.spec;
    const double noise = std::exchange(spec.errors, {}).noise;
    spec.law_errors =
        law_errors(spec, seed, 8 * drawn.number + static_cast<std::uint64_t>(drawn.kind));
    spec.id = "stem";
    DecisionCase out{spec.effects, {}, {}, {}};
    beam::RecordingSpec exact = spec;
    exact.law_errors.second_frequency_share = 0.0;
    exact.law_errors.second_loss_ratio = 1.0;
    beam::RecordingSpec lossy = exact;
    lossy.law_errors.second_loss_ratio = spec.law_errors.second_loss_ratio;
    lossy.effects.clear();
    for (const double mass : masses_of(kind, spec.stem, seed, number)) {
        out.exact.push_back(recorded(exact, mass, noise));
        out.lossy.push_back(recorded(lossy, mass, noise));
        measure::Measurement flawed = recorded(spec, mass, noise);
        add_noise(noise, seed, number, kind + (mass > 0.0 ? " loaded" : ""), flawed);
        out.recordings.push_back(misstated(std::move(flawed), [=](const fit::StatedInput& input) {
            return normal_error(input.name, seed, number);
        }));
    }
    return out;
}

} // namespace culm::bench
