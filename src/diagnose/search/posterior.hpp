// SPDX-License-Identifier: BSD-3-Clause
// Probabilities of the models of a search, and of the effects and families in them.
#pragma once

#include "diagnose/search/search.hpp"
#include "physics/effects/effect.hpp"

#include <string>
#include <vector>

namespace culm::diagnose {

/// An effect of the library, or its family where the recordings do not determine the law.
struct NamedFamily {
    physics::Family family = physics::Family::Own;
    std::string rig;                  ///< empty: of stems
    std::vector<std::string> members; ///< the likeliest first
    /// Also laws that the library lacks are possible: of air and of material damping, unless every
    /// other law of the family fails the tests for lack of fit.
    bool is_open = false;

    [[nodiscard]] bool is_same_as(const NamedFamily& other) const {
        return family == other.family && rig == other.rig;
    }
};

/// A set of effects that matter, with all models whose other effects are immaterial.
struct Explanation {
    std::vector<OwnedEffect> effects; ///< in the library's order; none: the published chain
    double probability = 0.0;
    std::size_t model = 0; ///< its likeliest visited model, without other effects if there is one
    bool is_exact = false; ///< that model has no other effects
};

/// Explanations whose effects are of the same families.
struct FamilyExplanation {
    std::vector<NamedFamily> families;
    double probability = 0.0;
    std::size_t model = 0; ///< that of its likeliest explanation
    double largest = 0.0;  ///< probability of that
};

/// A model that was fitted.
struct ModelProbability {
    std::vector<OwnedEffect> effects;
    double log_evidence = 0.0; ///< over that of the best model
    double probability = 0.0;
    std::string failure; ///< why it has none; empty if it has
};

/// An effect that the data support but that is too small to matter.
struct ImmaterialEffect {
    OwnedEffect effect;
    double over_noise = 0.0; ///< root mean square that it explains
};

struct Posterior {
    std::vector<ModelProbability> models;     ///< (visited models), likeliest first
    std::vector<Explanation> explanations;    ///< likeliest first
    std::vector<FamilyExplanation> by_family; ///< likeliest first
    std::vector<ImmaterialEffect> immaterial; ///< of the best model
};

/// The family of a candidate or known effect.
[[nodiscard]] physics::Family family_of(const DiagnosisOptions& options, const std::string& effect);

/// P(m) ∝ Z(m) over all visited models and the predictions of the others: steps 6 to 8 of
/// docs/diagnosis.md.
[[nodiscard]] Posterior posterior_of(const SearchResult& search);

} // namespace culm::diagnose
