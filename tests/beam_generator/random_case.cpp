// SPDX-License-Identifier: BSD-3-Clause
#include "beam_generator/random_case.hpp"

#include "beam_generator/random_effect.hpp"

#include <algorithm>
#include <numbers>
#include <stdexcept>

#include <fmt/core.h>

namespace culm::beam {
namespace {

/// Whether one effect contains the other, so that they are not combined.
bool exclude_each_other(const std::string& one, const std::string& other) {
    return (one == "clamp_compliance" && other == "clamp_friction") ||
           (one == "clamp_friction" && other == "clamp_compliance");
}

std::vector<std::string> hidden_names(CaseKind kind, std::uint64_t number) {
    switch (kind) {
    case CaseKind::Null:
        return {};
    case CaseKind::Single: {
        const std::vector<std::string> names = library_effects();
        return {names[number % names.size()]};
    }
    case CaseKind::Pair: {
        const auto pairs = effect_pairs();
        return pairs[number % pairs.size()];
    }
    case CaseKind::Unknown: {
        const std::vector<std::string> names = outside_effects();
        return {names[number % names.size()]};
    }
    case CaseKind::Further: {
        const std::vector<std::string> names = further_effects();
        return {names[number % names.size()]};
    }
    }
    return {};
}

BeamStem random_stem(Dice& dice) {
    BeamStem stem;
    stem.length = dice.between(0.14, 0.18);
    stem.diameter = dice.between(2.4e-3, 3.4e-3);
    stem.density = dice.between(100.0, 180.0);
    stem.youngs_modulus = dice.log_between(1.2e9, 3.5e9);
    // ζ = ½ ω τ
    stem.damping_time = dice.log_between(0.01, 0.045) / (std::numbers::pi * stem.first_frequency());
    return stem;
}

} // namespace

std::string_view to_string(CaseKind kind) {
    switch (kind) {
    case CaseKind::Null:
        return "null";
    case CaseKind::Single:
        return "single";
    case CaseKind::Pair:
        return "pair";
    case CaseKind::Unknown:
        return "unknown";
    case CaseKind::Further:
        return "further";
    }
    return "null";
}

CaseKind case_kind(std::string_view name) {
    for (const CaseKind kind :
         {CaseKind::Null, CaseKind::Single, CaseKind::Pair, CaseKind::Unknown, CaseKind::Further})
        if (to_string(kind) == name)
            return kind;
    throw std::invalid_argument(fmt::format("{} is not a kind of case", name));
}

std::vector<std::vector<std::string>> effect_pairs() {
    const std::vector<std::string> names = library_effects();
    std::vector<std::vector<std::string>> pairs;
    for (std::size_t i = 0; i < names.size(); ++i)
        for (std::size_t j = i + 1; j < names.size(); ++j)
            if (!exclude_each_other(names[i], names[j]))
                pairs.push_back({names[i], names[j]});
    // Shuffled, so that the first few of a short run already show many effects.
    for (std::size_t k = pairs.size(); k > 1; --k) {
        const double drawn = uniform({1, RandomUse::CaseDraw, 1, k});
        std::swap(pairs[k - 1], pairs[static_cast<std::size_t>(drawn * static_cast<double>(k))]);
    }
    return pairs;
}

RandomCase random_case(std::uint64_t seed, CaseKind kind, std::uint64_t number) {
    constexpr std::uint64_t kinds = 8; // room for more without changing what was drawn
    const std::uint64_t stream = number * kinds + static_cast<std::uint64_t>(kind);
    Dice dice({seed, RandomUse::CaseDraw, 2 + stream, 0});
    RandomCase drawn{kind, number, {}};
    RecordingSpec& spec = drawn.spec;
    spec.id = fmt::format("{}-{}", to_string(kind), number);
    spec.stem = random_stem(dice);
    spec.tip_deflection = dice.between(15e-3, 25e-3);
    spec.heights = even_heights(spec.stem.length, dice.whole(6, 14));
    spec.duration = dice.between(0.2, 0.5);
    spec.frames_before = dice.whole(0, 10);
    spec.hold_time = dice.between(3.0, 10.0);
    spec.errors.noise = dice.log_between(2e-5, 1e-4);
    spec.gravity_direction = dice.happens(0.7) ? measure::GravityDirection::Axial
                                               : measure::GravityDirection::Transverse;
    spec.seed = seed * 1'000'003 + stream;
    for (const std::string& name : hidden_names(kind, number)) {
        if (name == "plate_air")
            spec.stem.width = spec.stem.diameter * dice.between(5.0, 20.0);
        spec.effects.push_back(random_effect(
            name, {spec.stem, spec.tip_deflection, spec.hold_time, spec.gravity_direction}, dice));
        spec.id += "-" + name;
    }
    return drawn;
}

} // namespace culm::beam
