// SPDX-License-Identifier: BSD-3-Clause
// Fits models to all stems and computes their log evidence.
#pragma once

#include "diagnose/models/stem_fit.hpp"

#include <limits>
#include <map>
#include <string>
#include <vector>

namespace culm::diagnose {

inline constexpr double not_predicted = std::numeric_limits<double>::quiet_NaN();

/// A model to be fitted.
struct PlannedModel {
    Model model; ///< stems: fits that stay, and from which stems with shared numbers start
    double predicted = not_predicted;
    std::map<std::size_t, StemStart> starts; ///< of the stems to be fitted
};

/// A parameter of one of a model's shared effects that is a shared number.
struct SharedParameter {
    std::size_t effect = 0; ///< of the model's effects
    std::size_t k = 0;      ///< among the effect's parameters
    physics::EffectParameter card;
    Eigen::Index at = 0; ///< among the shared numbers
};
[[nodiscard]] std::vector<SharedParameter> shared_parameters(const Model& model);

/// With one noise of the stems for all models.
class ModelFits {
  public:
    explicit ModelFits(const Stems& stems) : stems_(&stems) {}

    /// (stems) judge() divides by it.
    void set_noise(std::vector<NoiseScale> noise) { noise_ = std::move(noise); }
    [[nodiscard]] const std::vector<NoiseScale>& noise() const { return noise_; }
    [[nodiscard]] const std::map<std::string, SharedPrior>& priors() const { return priors_; }

    /// Fits the models at once, so that their stems keep all ranks busy. A model without shared
    /// numbers needs the fits of `starts` alone. In the others, all stems on the rig are fitted in
    /// each of Newton's steps for the shared numbers (sharing.hpp); a step is halved until the
    /// model gets better, and the fit fails if it does not converge.
    ///
    /// With several stems an own effect that ends absent from a stem is removed from that stem.
    void fit(std::vector<PlannedModel>& planned);

    /// log Z = Σ_s [log L_s + log π(θ_s) + ½ d_θ log 2π − ½ log|H_θθ,s|] + log π(φ) + ½ d_φ log 2π
    /// − ½ log|H_φ|, with the error terms that are shared counted once, and the prior of the
    /// effects and of the stems in which they act. −infinity if an effect ended absent.
    void judge(Model& model);

  private:
    class Descent;

    [[nodiscard]] SharedMinimum minimum_in(const Model& model,
                                           const std::map<std::string, SharedPrior>& priors) const;
    [[nodiscard]] double value_of(const Model& model) const;
    [[nodiscard]] double log_likelihood(const Model& model, const SharedMinimum& shared) const;
    [[nodiscard]] double log_prior_of_effects(const Model& model) const;
    [[nodiscard]] double log_volume(const Model& model) const;
    [[nodiscard]] bool has_absent_effect(const Model& model) const;
    void add_priors(const Model& model);
    void add_prior(const ActingEffect& effect, std::size_t parameter, const std::string& name);

    const Stems* stems_;
    std::vector<NoiseScale> noise_;
    std::map<std::string, SharedPrior> priors_; ///< of the effects' parameters; terms have none
    std::map<std::string, ParameterPrior> parameter_priors_;
};

} // namespace culm::diagnose
