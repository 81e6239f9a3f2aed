// SPDX-License-Identifier: BSD-3-Clause
#include "bench/decision_cases.hpp"

#include "bench/misstated_inputs.hpp"
#include "bench/reading_noise.hpp"
#include "tests/beam_generator/random_case.hpp"
#include "tests/beam_generator/random_effect.hpp"
#include "tests/beam_generator/recording.hpp"

#include <algorithm>
#include <array>
#include <random>
#include <stdexcept>
#include <string_view>
#include <utility>

#include <fmt/core.h>

namespace culm::bench {
namespace {

using nlohmann::json;

/// Kinds and how many of 60 recordings are of each.
constexpr std::array<std::pair<std::string_view, std::size_t>, 5> kinds{
    {{"null", 20}, {"single", 20}, {"pair", 8}, {"loaded", 6}, {"unknown", 6}}};
constexpr std::size_t kinds_total = 60;
/// Known mass, as a share of the stem's own mass.
constexpr double known_mass = 0.6;

beam::RecordingSpec drawn_spec(const json& key) {
    const std::uint64_t seed = key.at("seed");
    const std::uint64_t number = key.at("number");
    const std::string kind = key.at("kind");
    if (kind != "loaded")
        return beam::random_case(seed, beam::case_kind(kind), number).spec;
    // All effects of the library except the mass, which is known here; 5 is prime to their number,
    // so that few recordings show unlike effects.
    beam::RecordingSpec spec =
        beam::random_case(seed, beam::CaseKind::Null, 1'000'000 + number).spec;
    std::vector<std::string> names = beam::library_effects();
    std::erase(names, "tip_mass");
    beam::Dice dice({seed, beam::RandomUse::CaseDraw, 1, number});
    spec.effects = {beam::random_effect(
        names[5 * number % names.size()],
        {spec.stem, spec.tip_deflection, spec.hold_time, spec.gravity_direction}, dice)};
    return spec;
}

} // namespace

std::vector<json> decision_keys(std::uint64_t seed, std::size_t count) {
    std::vector<json> keys;
    for (const auto& [kind, share] : kinds)
        for (std::uint64_t number = 0; number * kinds_total < share * count; ++number)
            keys.push_back({{"seed", seed}, {"kind", kind}, {"number", number}});
    return keys;
}

DecisionCase decision_case(const json& key) {
    const std::uint64_t seed = key.at("seed");
    const std::uint64_t number = key.at("number");
    const std::string kind = key.at("kind");
    beam::RecordingSpec spec = drawn_spec(key);
    const double noise = std::exchange(spec.errors, {}).noise;
    const std::size_t family = number % (noise_families.size() + 1);
    const std::string owner(1, 'A');
    DecisionCase out;
    out.hidden = spec.effects;
    for (int k = 0; k < (kind == "loaded" ? 2 : 1); ++k) {
        const double mass = known_mass * spec.stem.mass_per_length() * spec.stem.length;
        spec.id = fmt::format("{}", k == 0 ? "bare" : "loaded");
        if (k == 1) {
            spec.effects.push_back({"tip_mass", {{"mass_kg", mass}}});
            spec.duration *= 1.5;
        }
        measure::Measurement measurement = beam::record(spec);
        measurement.noise = noise;
        measurement.specimen = owner;
        measurement.rig = owner;
        if (k == 1)
            measurement.stem.added_masses = {{spec.stem.length, mass, {}}};
        out.exact.push_back(measurement);
        std::mt19937_64 dice = dice_for(seed, number, fmt::format("{} {}", kind, k));
        Noise(family == 0 ? "white" : std::string(noise_families[family - 1]), dice())
            .add(noise, measurement);
        out.recordings.push_back(
            misstated(std::move(measurement), [=](const fit::StatedInput& input) {
                return normal_error(input.name, seed, number);
            }));
    }
    return out;
}

} // namespace culm::bench
