// SPDX-License-Identifier: BSD-3-Clause
// Grades an answer of the diagnosis, given the effects hidden in the recording.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

namespace culm::bench {

[[nodiscard]] bool is_in_library(const std::string& effect);

/// Stands for a second mode whose loss is not that of the material: named as material damping.
inline constexpr std::string_view second_loss = "loss of the second mode";

/// The family of an effect of air or of material damping; empty for the others.
[[nodiscard]] std::string family_of(const std::string& effect);

/// A hidden effect, and the rms residual of an exact recording without it, over the noise.
struct HiddenTruth {
    std::string effect;
    double over_noise = 0.0;
    bool is_material = true; ///< by the rule of the posterior
    /// By which it is rightly named, whichever law is the likeliest; empty: by its law.
    std::string family = {};
};

/// Effects or families, "air: power_drag or viscous_drag", that explain a recording together.
struct NamedEffects {
    std::string family;
    std::vector<std::string> members;
};
using AnswerSet = std::vector<NamedEffects>;

struct Answered {
    std::string verdict;               ///< "adequate", "effect", "tie", "unknown", "failed"
    AnswerSet certain;                 ///< effects that are named
    std::vector<AnswerSet> candidates; ///< explanations that hold 95 % of the probability
};

/// Whether the explanation names every material hidden effect, by member or family, and no other.
[[nodiscard]] bool is_truth(const AnswerSet& named, const std::vector<HiddenTruth>& hidden);

/// Whether the answer names the effect as certain.
[[nodiscard]] bool is_named(const Answered& answer, const HiddenTruth& hidden);

/// "right": the truth is named, or nothing if nothing is material; "tie": several explanations,
/// including the truth; "partly": some of the hidden effects and no other; "silent": nothing
/// although an effect is material; "unknown"; "wrong": an effect or family that is not hidden, or
/// only explanations that are not the truth; "failed". An effect that has a HiddenTruth::family is
/// rightly named by any law of it. A law that the library lacks is rightly called unknown or named
/// by its family: by a general law or by several laws.
[[nodiscard]] std::string grade(const Answered& answer, const std::vector<HiddenTruth>& hidden);

void to_json(nlohmann::json& json, const NamedEffects& named);
void from_json(const nlohmann::json& json, NamedEffects& named);

} // namespace culm::bench
