// SPDX-License-Identifier: BSD-3-Clause
// The logarithm of the probability of the readings given a fitted model: the search's score.
#pragma once

#include "fit/chain/stem_model.hpp"
#include "fit/fit.hpp"

#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace culm::diagnose {

/// The prior of a free parameter of an effect, in its coordinate: the number itself, its logarithm
/// or its inverse (physics::FittedAs). A size has a normal prior about its absence. A location, an
/// angle or a time constant has a uniform prior within its bounds. A parameter whose value is known
/// has a normal prior about it, which is a row of the fit's system, too.
struct ParameterPrior {
    bool is_place = false;
    bool is_one_sided = false; ///< of a size: it has one sign, and the prior is half-normal
    double absent = 0.0;       ///< of a size: its coordinate where the effect is absent
    double deviation = 1.0;    ///< of a size: standard deviation; negative where it points down
    double range = 1.0;        ///< of a location: distance between its bounds
    double known = 0.0;        ///< the known value
    double known_within = 0.0; ///< its standard deviation; 0: it is not known

    /// Logarithm of the density at a coordinate.
    [[nodiscard]] double log_density(double coordinate) const;
    /// The prior's part of the second derivative of −log posterior, beyond the system's. For a
    /// location it is such that the Laplace integral over a flat likelihood equals one.
    [[nodiscard]] double precision() const;
};

/// The prior of an effect's parameter in `model`, whose stem determines the usual size.
[[nodiscard]] ParameterPrior prior_of(const fit::FreeParameter& parameter,
                                      const fit::StemModel& model);

/// The quantities of a fitted model that log_evidence() needs, independent of the noise.
struct ModelEvidence {
    std::vector<double> misfits; ///< (recordings) χ²; m² where the noise is not known
    double squared_pulls = 0.0;  ///< of the error terms
    double log_prior = 0.0;      ///< log density of the effects' d numbers at the fit
    /// (d, d) Hessian of ½ χ² by these numbers with all others eliminated.
    Eigen::MatrixXd information;
    std::vector<double> prior_precision; ///< (d)
    /// (k, k) MᵀM of the k error terms of the model, with all numbers but the effects' eliminated.
    Eigen::MatrixXd model_terms;
    std::size_t effects = 0;                 ///< that may or may not act
    std::vector<std::string> absent_effects; ///< those of them that ended where they are absent
};

/// Variance of the noise over what the fits assume, for each recording.
struct NoiseScale {
    std::vector<double> variance;      ///< (recordings); of unknown noise: m²
    std::vector<bool> is_noise_known;  ///< (recordings)
    std::vector<std::size_t> readings; ///< (recordings)

    /// Mean over the readings whose noise is known; 1 if there are none.
    [[nodiscard]] double mean_known() const;
};

/// The noise that the fits assume; if a recording states none, this model's residual.
[[nodiscard]] NoiseScale noise_as_assumed(const fit::Fit& first);

/// From the model that fits best: its reduced χ² if that exceeds 1, because its residual is treated
/// as noise in all models; the mean square of its residuals if no noise is known.
[[nodiscard]] NoiseScale noise_scale_of(const fit::Fit& best);

/// Names of the effects whose sizes all ended at their absence, without the `given` ones.
[[nodiscard]] std::vector<std::string> absent_effects(const fit::Fit& fit,
                                                      const std::vector<std::string>& given);

/// `given`: names of effects that have no prior probability here; `held`: of those, effects whose
/// numbers are not the stem's own.
[[nodiscard]] ModelEvidence evidence_of(const fit::Fit& fit,
                                        std::span<const fit::ObservedRecording> recordings,
                                        const std::vector<std::string>& given,
                                        const std::vector<std::string>& held = {});

/// log Z = −½ rᵀ S⁻¹ r − ½ log|S| + log π(numbers) + ½ d log 2π − ½ log|H| + log P(effects), the
/// Laplace approximation (MacKay 1992, Neural Comput. 4:415-447), up to a constant common to all
/// models. S contains the error terms; of its determinant only the part of the model's own terms,
/// |I + MᵀM|, differs between models.
[[nodiscard]] double log_evidence(const ModelEvidence& evidence, const NoiseScale& noise);

/// Log odds, before a recording is seen, that one effect acts: log(0.05/0.95).
[[nodiscard]] double log_prior_odds();

} // namespace culm::diagnose
