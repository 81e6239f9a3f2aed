// SPDX-License-Identifier: BSD-3-Clause
// One model of a search: which effects act in which stems, its fit and its identity.
#pragma once

#include "diagnose/adequacy.hpp"
#include "diagnose/evidence/log_evidence.hpp"
#include "diagnose/models/sharing.hpp"
#include "diagnose/models/stems.hpp"

#include <limits>
#include <string>
#include <utility>
#include <vector>

namespace culm::diagnose {

/// An effect and who has its numbers: all stems on a rig together, or each stem its own.
struct ActingEffect {
    physics::SelectedEffect effect; ///< as a candidate; the user's fixed values stay
    std::string rig;                ///< whose stems share the numbers; empty: none
    std::vector<std::size_t> stems; ///< in which it acts
    std::vector<double> values;     ///< of a rig's effect: of its parameters, SI units
    bool is_known = false;          ///< the user states that it acts

    [[nodiscard]] std::string name() const { return effect.effect->name; }
    [[nodiscard]] bool is_shared() const { return !rig.empty(); }
    [[nodiscard]] bool acts_in(std::size_t stem) const;
};

/// The effect shared by all fitted stems on the rig, with the default values of the first one.
[[nodiscard]] ActingEffect on_rig(const physics::SelectedEffect& effect, const std::string& rig,
                                  const Stems& stems);

/// The fitted chain of a stem with the effect and the defaults that suit the stem.
[[nodiscard]] fit::StemModel stem_with(const ActingEffect& effect, std::size_t stem,
                                       const Stems& stems);

/// Name of an effect and its rig; no rig: of stems.
using OwnedEffect = std::pair<std::string, std::string>;
[[nodiscard]] inline OwnedEffect owned(const ActingEffect& effect) {
    return {effect.name(), effect.rig};
}

/// The effects of one stem in a model.
struct StemEffects {
    fit::SelectedEffects all;
    std::vector<std::string> given; ///< names of those whose presence the stem does not decide
    Sharing sharing;
};

/// The fit of one stem.
struct StemFit {
    fit::Fit fit; ///< its numbers
    ModelEvidence evidence;
    SetVerdict verdict; ///< on its lack of fit
    SharedBlock block;
};

struct Model {
    std::vector<ActingEffect> effects; ///< the known ones first
    std::vector<StemFit> stems;        ///< (stems)
    SharedMinimum shared;
    std::string failure; ///< empty: fitted
    double log_evidence = -std::numeric_limits<double>::infinity();
    double offset = 0.0; ///< of the log evidence, of a fit with another number of spheres

    [[nodiscard]] bool failed() const { return !failure.empty(); }
    [[nodiscard]] StemEffects effects_of(std::size_t stem, const Stems& stems) const;
    /// Those that are not known.
    [[nodiscard]] std::size_t added() const;

    // Sums over the stems, and numbers of the fits themselves.
    [[nodiscard]] double chi_squared() const { return sum_of(&fit::Fit::chi_squared); }
    [[nodiscard]] double readings() const { return sum_of(&fit::Fit::readings); }
    [[nodiscard]] int batches() const { return static_cast<int>(sum_of(&fit::Fit::batches)); }
    [[nodiscard]] bool moves() const;

  private:
    template <class Member>
    [[nodiscard]] double sum_of(Member member) const {
        double sum = 0.0;
        for (const StemFit& stem : stems)
            sum += static_cast<double>(stem.fit.*member);
        return sum;
    }
};

/// The effects without number `place`.
[[nodiscard]] std::vector<ActingEffect> without(std::vector<ActingEffect> effects,
                                                std::size_t place);

/// Those that are not known.
[[nodiscard]] std::vector<OwnedEffect> added_names(const std::vector<ActingEffect>& effects);

/// The identity of a model: its effects with fixed values, rig and recordings where they are
/// absent, sorted.
using ModelKey = std::vector<std::string>;
[[nodiscard]] ModelKey key_of(const std::vector<ActingEffect>& effects);

/// The model with exactly these effects that was fitted or failed; null: none.
[[nodiscard]] const Model* find_model(const std::vector<Model>& models,
                                      const std::vector<ActingEffect>& effects);

/// "baseline + quadratic_drag of rig A + taper"; "of stems" where there are several.
[[nodiscard]] std::string name_of(const std::vector<ActingEffect>& effects, const Stems& stems);

/// Can the effects act together? A family whose laws are one law permits at most one effect.
[[nodiscard]] bool can_be_combined(const fit::SelectedEffects& effects);
/// In every stem.
[[nodiscard]] bool can_be_combined(const std::vector<ActingEffect>& effects, const Stems& stems);

/// Does `effects` contain every effect of `some`, with the same owner?
[[nodiscard]] bool contains_all(const std::vector<ActingEffect>& effects,
                                const std::vector<ActingEffect>& some);
[[nodiscard]] bool contains_all(const fit::SelectedEffects& effects,
                                const fit::SelectedEffects& some);

/// Indices of the effect's parameters that a fit may change, in the order of its free parameters.
[[nodiscard]] std::vector<std::size_t> free_parameters(const physics::SelectedEffect& effect);

/// Log prior of the event that an effect acts in exactly these of the stems, given that it acts in
/// one or more: the share of stems with it is uniform (Stephan et al. 2009, NeuroImage
/// 46:1004-1017; Rigoux et al. 2014, 84:971-985). 0 for one stem.
[[nodiscard]] double log_presence(std::size_t with_effect, std::size_t stems);

/// In a model, a stem has an own effect if that is more probable than not.
inline constexpr double present_from = 0.5;
/// Probability that each stem has an effect, from the change of its log evidence if it has: the
/// mean-field solution where the share of stems with it is unknown (Stephan et al. 2009).
[[nodiscard]] std::vector<double> presence_of(const std::vector<double>& gains);

} // namespace culm::diagnose
