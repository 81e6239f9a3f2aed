// SPDX-License-Identifier: BSD-3-Clause
// Simulated laboratories: stems on one rig, with hidden effects of the rig and of some stems.
#pragma once

#include "bench/misstated_inputs.hpp"
#include "bench/reading_noise.hpp"
#include "diagnose/detection_limits.hpp"
#include "physics/effects/library.hpp"
#include "tests/beam_generator/random_case.hpp"
#include "tests/beam_generator/random_effect.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/core.h>

namespace culm::bench {

inline constexpr std::uint64_t laboratory_seed = 0x1ab;
/// Kinds, in turn: nothing hidden, one or two effects of the rig, one in some stems, both.
inline constexpr std::array<std::string_view, 5> laboratory_kinds{"null", "rig", "two", "stems",
                                                                  "both"};
/// Effects of some stems; both kinds that have one use the whole list.
inline constexpr std::array<std::string_view, 8> own_effects{
    "tip_mass",           "local_defect", "taper",
    "precurvature",       "out_of_plane", "bending_nonlinearity",
    "hysteretic_damping", "relaxation"};
/// Smallest and largest effect of a rig, over the detection limit of one stem.
inline constexpr double weakest = 0.3;
inline constexpr double strongest = 2.0;

/// An effect of the rig, relative to a limit that is not known yet.
struct RigStrength {
    double over_limit = 1.0;
    double sign = 1.0; ///< of an effect that may have either
};

struct LaboratoryStem {
    beam::RecordingSpec spec; ///< without effects and noise
    double noise = 0.0;       ///< m
    std::vector<beam::HiddenEffect> own;
};

struct DrawnLaboratory {
    std::uint64_t number = 0;
    std::string kind;
    std::vector<LaboratoryStem> stems;
    std::size_t first = 0; ///< effect of the rig, in sizable_rig_effects()
    std::vector<RigStrength> strengths;
};

/// An effect of the rig of known size.
struct RigTruth {
    beam::HiddenEffect effect; ///< has one parameter
    double over_limit = 0.0;
    double limit = 0.0; ///< of the first stem alone
};

/// Effects of rigs that the generator has and whose size is their only free parameter: the spring
/// of clamp_friction would be a second hidden effect.
[[nodiscard]] inline std::vector<std::string> sizable_rig_effects() {
    std::vector<std::string> names;
    for (const std::string& name : beam::library_effects()) {
        const physics::EffectPointer effect = physics::effect_named(name);
        if (effect->belongs_to == physics::BelongsTo::Rig && effect->parameters.size() == 1)
            names.push_back(name);
    }
    return names;
}

/// Laboratory `number`, the same whatever was drawn before. The stems are those of
/// beam::random_case(), and so are the sizes of their own effects, which a third of them has.
[[nodiscard]] inline DrawnLaboratory drawn_laboratory(std::uint64_t number) {
    const std::uint64_t turn = number / laboratory_kinds.size();
    DrawnLaboratory out{
        number, std::string(laboratory_kinds[number % laboratory_kinds.size()]), {}, 0, {}};
    const bool has_own = out.kind == "stems" || out.kind == "both";
    beam::Dice dice({laboratory_seed, beam::RandomUse::CaseDraw, 0, 1000 * number});
    const int count = dice.whole(8, 16);
    const int first_with_own = dice.whole(0, 2);
    // Numbers of both strengths are drawn in any case.
    for (int k = 0; k < 2; ++k) {
        const double over_limit = dice.log_between(weakest, strongest);
        out.strengths.push_back({over_limit, dice.sign()});
    }
    out.strengths.resize(out.kind == "two" ? 2 : out.kind == "rig" || out.kind == "both" ? 1 : 0);
    out.first = turn + (out.kind == "both" ? 3 : 0);
    const std::string_view own =
        own_effects[(turn + (out.kind == "both" ? 4 : 0)) % own_effects.size()];
    for (int s = 0; s < count; ++s) {
        LaboratoryStem& stem = out.stems.emplace_back();
        stem.spec = beam::random_case(laboratory_seed, beam::CaseKind::Null,
                                      100 * number + static_cast<std::uint64_t>(s))
                        .spec;
        stem.spec.id = fmt::format("stem-{:02}", s + 1);
        // The stems of a rig hang alike.
        stem.spec.gravity_direction = out.stems.front().spec.gravity_direction;
        stem.noise = std::exchange(stem.spec.errors, {}).noise;
        if (has_own && s % 3 == first_with_own)
            stem.own = {beam::random_effect(own,
                                            {stem.spec.stem, stem.spec.tip_deflection,
                                             stem.spec.hold_time, stem.spec.gravity_direction},
                                            dice)};
    }
    return out;
}

/// The recording of a stem with its own effects and those of the rig, without errors.
[[nodiscard]] inline measure::Measurement
exact_recording(const LaboratoryStem& stem, const std::vector<beam::HiddenEffect>& of_rig) {
    beam::RecordingSpec spec = stem.spec;
    spec.effects = stem.own;
    spec.effects.insert(spec.effects.end(), of_rig.begin(), of_rig.end());
    measure::Measurement measurement = beam::record(spec);
    measurement.noise = stem.noise;
    measurement.specimen = spec.id;
    measurement.rig = "A";
    return measurement;
}

/// The recording as the laboratory writes it: with white noise, and normal errors of the inputs.
/// All stems have the same error of the scale, since they are seen by one camera.
[[nodiscard]] inline measure::Measurement
written_recording(const DrawnLaboratory& drawn, std::size_t index,
                  const std::vector<beam::HiddenEffect>& of_rig) {
    const LaboratoryStem& stem = drawn.stems[index];
    const std::uint64_t number = 100 * drawn.number + index;
    measure::Measurement measurement = exact_recording(stem, of_rig);
    Noise("white", dice_for(laboratory_seed, number, "noise")()).add(stem.noise, measurement);
    return misstated(std::move(measurement), [&](const fit::StatedInput& input) {
        const bool is_shared = input.is_of_rig && input.acts != fit::InputActs::OnRows;
        return normal_error(input.name, laboratory_seed, is_shared ? drawn.number : number);
    });
}

/// The effect at a multiple of its limit. A stiffness is the larger, the weaker the effect is.
[[nodiscard]] inline RigTruth sized(const diagnose::DetectionLimit& limit,
                                    const RigStrength& strength) {
    const physics::EffectParameter parameter =
        physics::effect_named(limit.effect)->parameters.front();
    double value = parameter.fitted_as == physics::FittedAs::Inverse
                       ? limit.value / strength.over_limit
                       : limit.value * strength.over_limit;
    if (parameter.lower < 0.0)
        value *= strength.sign;
    return {{limit.effect, {{parameter.name, value}}}, strength.over_limit, limit.value};
}

/// The hidden effects of the rig, given the limits of the first stem alone. The drawn effects are
/// replaced by the next ones of the list if one has no limit.
[[nodiscard]] inline std::vector<RigTruth>
hidden_in_rig(const DrawnLaboratory& drawn, const std::vector<diagnose::DetectionLimit>& limits) {
    const std::vector<std::string> names = sizable_rig_effects();
    for (std::size_t shift = 0; shift < names.size(); ++shift) {
        std::vector<RigTruth> hidden;
        for (std::size_t k = 0; k < drawn.strengths.size(); ++k) {
            // Neighbours in the list may be two laws of one family.
            const std::string& name = names[(drawn.first + shift + 2 * k) % names.size()];
            const auto limit = std::ranges::find(limits, name, &diagnose::DetectionLimit::effect);
            if (limit != limits.end() && limit->failure.empty() && !limit->is_beyond_bounds &&
                std::isfinite(limit->value) && limit->value > 0.0)
                hidden.push_back(sized(*limit, drawn.strengths[k]));
        }
        if (hidden.size() == drawn.strengths.size())
            return hidden;
    }
    throw std::runtime_error(
        fmt::format("laboratory {}: no effect of the rig has a detection limit", drawn.number));
}

} // namespace culm::bench
