// SPDX-License-Identifier: BSD-3-Clause
// A model of all stems of a laboratory: its fit and its log evidence.
#pragma once

#include "diagnose/laboratory/stem_fit.hpp"
#include "diagnose/model_search.hpp"

#include <limits>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace culm::diagnose {

struct LaboratoryModel {
    std::vector<RigEffect> rig_effects;
    std::vector<fit::SelectedEffects> own; ///< (stems)
    std::vector<StemFit> stems;            ///< (stems)
    SharedMinimum shared;
    std::string failure; ///< empty: fitted
    double log_evidence = -std::numeric_limits<double>::infinity();
    std::size_t base = 0;        ///< the visited model about which it was predicted
    double predicted_gain = 0.0; ///< over that; 0: it was not predicted

    [[nodiscard]] bool failed() const { return !failure.empty(); }
};

/// A parameter of one of the model's rig effects that is a shared number.
struct SharedParameter {
    std::size_t effect = 0; ///< of the rig effects
    std::size_t k = 0;      ///< among the effect's parameters
    physics::EffectParameter card;
    Eigen::Index at = 0; ///< among the shared numbers
};
[[nodiscard]] std::vector<SharedParameter> shared_parameters(const LaboratoryModel& model);

/// The effects of a model with their rigs; no rig: of stems.
using EffectOwners = std::set<std::pair<std::string, std::string>>;
[[nodiscard]] EffectOwners owners_of(const LaboratoryModel& model);

/// "quadratic_drag of rig A + taper of stems"; "the published chain".
[[nodiscard]] std::string name_of(const EffectOwners& owners);
[[nodiscard]] inline std::string name_of(const LaboratoryModel& model) {
    return name_of(owners_of(model));
}

/// The stems of a laboratory, and work on them that is distributed over ranks.
struct LaboratoryStems {
    std::span<const Specimen> specimens;
    const DiagnosisOptions& options;
    fit::SelectedEffects known_of_rig; ///< of the options' known effects
    fit::SelectedEffects known_of_stem;
    std::vector<ObservedStem> stems{};
    std::vector<std::string> shared_terms{}; ///< names of error terms that several stems have

    LaboratoryStems(std::span<const Specimen> all, const DiagnosisOptions& chosen);

    [[nodiscard]] std::set<std::string> rigs() const;
    /// Could its chain not be fitted?
    [[nodiscard]] bool is_left_out(std::size_t stem) const {
        return stem < stems.size() && !stems[stem].failure.empty();
    }
    [[nodiscard]] std::size_t fitted_stems() const;
    [[nodiscard]] StemEffects effects_of(const LaboratoryModel& model, std::size_t stem) const;
    /// The effect with the defaults that suit the first stem on the rig.
    [[nodiscard]] RigEffect with_default_values(const physics::SelectedEffect& effect,
                                                const std::string& rig, bool is_known) const;

    /// work(stem, options) for each stem that is not left out; empty for the others.
    template <class Work>
    [[nodiscard]] auto map(const Work& work) const {
        using T = std::invoke_result_t<Work, std::size_t, const fit::FitOptions&>;
        std::vector<std::size_t> items;
        std::vector<double> costs;
        for (std::size_t s = 0; s < specimens.size(); ++s)
            if (!is_left_out(s)) {
                items.push_back(s);
                costs.push_back(cost_of(s));
            }
        std::vector<std::optional<T>> found(specimens.size());
        std::vector<T> answers =
            options.map.values(costs, [&](std::size_t item, const run::Heartbeat& heartbeat) {
                return work(items[item], fit::with_heartbeat(options.candidate, heartbeat));
            });
        for (std::size_t k = 0; k < items.size(); ++k)
            found[items[k]] = std::move(answers[k]);
        return found;
    }

  private:
    [[nodiscard]] double cost_of(std::size_t stem) const; ///< its seconds of motion
};

/// Fits models and computes their log evidence with one noise of the stems.
class LaboratoryFit {
  public:
    explicit LaboratoryFit(const LaboratoryStems& stems) : stems_(stems) {}

    /// (stems) about a model; judge() divides by it.
    void set_noise(std::vector<NoiseScale> noise) { noise_ = std::move(noise); }
    [[nodiscard]] const std::vector<NoiseScale>& noise() const { return noise_; }
    [[nodiscard]] const std::map<std::string, SharedPrior>& priors() const { return priors_; }

    /// Newton's method for the shared numbers, from the model's values; a step is halved until the
    /// model gets better, and the fit fails if it does not converge. The stems' own numbers are
    /// fitted in every step, and follow the step linearly before that. Stems `with_new_own` have an
    /// own effect that their fit does not have; one that ends absent is removed from the stem.
    /// Fails if a stem has effects that cannot be combined.
    void fit(LaboratoryModel& model, const std::set<std::size_t>& with_new_own = {});

    /// log Z = Σ_s [log L_s + log π(θ_s) + ½ d_θ log 2π − ½ log|H_θθ,s|] + log π(φ) + ½ d_φ log 2π
    /// − ½ log|H_φ|, with the error terms that are shared counted once.
    void judge(LaboratoryModel& model);

  private:
    bool take_fit(StemFit found, std::size_t stem, bool has_new_own, LaboratoryModel& model) const;
    [[nodiscard]] double step_size(const LaboratoryModel& model) const;
    [[nodiscard]] std::vector<Eigen::VectorXd> take_step(LaboratoryModel& model, double part) const;
    [[nodiscard]] SharedMinimum minimum_in(const LaboratoryModel& model,
                                           const std::map<std::string, SharedPrior>& priors) const;
    [[nodiscard]] double value_of(LaboratoryModel model) const;
    [[nodiscard]] double log_likelihood(const LaboratoryModel& model) const;
    [[nodiscard]] double log_prior_of_effects(const LaboratoryModel& model) const;
    [[nodiscard]] double log_volume(const LaboratoryModel& model) const;
    [[nodiscard]] bool has_absent_effect(const LaboratoryModel& model) const;
    void add_priors(const LaboratoryModel& model);
    void add_prior(const RigEffect& effect, std::size_t parameter, const std::string& name);

    const LaboratoryStems& stems_;
    std::vector<NoiseScale> noise_;
    std::map<std::string, SharedPrior> priors_; ///< of the effects' parameters; terms have none
    std::map<std::string, ParameterPrior> parameter_priors_;
};

/// Log prior of the event that an effect acts in exactly these stems: the share of stems with it is
/// uniform (Stephan et al. 2009, NeuroImage 46:1004-1017; Rigoux et al. 2014, 84:971-985).
[[nodiscard]] double log_presence(std::size_t with_effect, std::size_t stems);

} // namespace culm::diagnose
