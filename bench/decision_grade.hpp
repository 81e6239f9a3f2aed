// SPDX-License-Identifier: BSD-3-Clause
// What an answer of the diagnosis is worth, given what is hidden in the recording.
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace culm::bench {

/// A hidden effect, and the rms over the noise that models without it leave of an exact recording.
struct HiddenTruth {
    std::string effect;
    double over_noise = 0.0;
    bool is_material = true; ///< by the rule of the posterior
};

/// Effects or families, "air: power_drag or viscous_drag", that explain a recording together.
struct NamedEffects {
    std::string family;
    std::vector<std::string> members;
};
using AnswerSet = std::vector<NamedEffects>;

struct Answered {
    std::string verdict;               ///< "adequate", "effect", "tie", "unknown", "failed"
    AnswerSet certain;                 ///< what is named
    std::vector<AnswerSet> candidates; ///< explanations that hold 95 % of the probability
};

/// Does the explanation name every material hidden effect, by member or family, and no other?
[[nodiscard]] bool is_truth(const AnswerSet& named, const std::vector<HiddenTruth>& hidden);

/// Is the effect among those that the answer names as certain?
[[nodiscard]] bool is_named(const Answered& answer, const HiddenTruth& hidden);

/// "right": the truth is named, or nothing where nothing is material; "tie": several explanations,
/// the truth among them; "partly": of the hidden effects not all, and no other; "silent": nothing
/// although something is material; "unknown"; "wrong": an effect or family that is not hidden, or
/// only explanations that are not the truth; "failed". A law that the library lacks is rightly
/// called unknown; or, where its family has general laws, by one of these or an open family.
[[nodiscard]] std::string grade(const Answered& answer, const std::vector<HiddenTruth>& hidden);

void to_json(nlohmann::json& json, const NamedEffects& named);
void from_json(const nlohmann::json& json, NamedEffects& named);

} // namespace culm::bench
