// SPDX-License-Identifier: BSD-3-Clause
// A model fitted to every height and frame of one or several recordings at once.
#pragma once

#include "fit/model/reading_noise.hpp"
#include "fit/solve/solution.hpp"

#include <algorithm>
#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace culm::fit {

/// Pull, in standard uncertainties, beyond which the readings contradict a stated value. A pull
/// this large has a probability of 1/370 by chance.
constexpr double contradiction = 3.0;

struct FittedParameter {
    physics::ParameterId id;
    std::string unit;
    double value = 0.0;
    double standard_error = 0.0; ///< infinite where the data do not determine it
    bool is_at_bound = false;
    double lower = 0.0; ///< allowed range
    double upper = 0.0;
    physics::FittedAs fitted_as = physics::FittedAs::Itself;
    bool is_place = false; ///< as in physics::EffectParameter
    double absent = 0.0;   ///< likewise
    bool is_error = false; ///< a term of ReadingErrors; the value is its pull
};

template <class Wire>
void fields(Wire& wire, FittedParameter& parameter) {
    wire(parameter.id, parameter.unit, parameter.value, parameter.standard_error,
         parameter.is_at_bound, parameter.lower, parameter.upper, parameter.fitted_as,
         parameter.is_place, parameter.absent, parameter.is_error);
}

/// Half of the parameter's 95 % interval.
[[nodiscard]] double interval_half_width(const FittedParameter& parameter);
/// Does that interval contain the value at which the effect is absent?
[[nodiscard]] bool is_absent(const FittedParameter& parameter);

/// The fit of one recording, in SI units and for the readings without transformation.
struct RecordingFit {
    StemModel model;                         ///< with the fitted values
    std::vector<FittedParameter> parameters; ///< as StemModel::free_ids
    Eigen::MatrixXd covariance;              ///< (parameters, parameters)
    Eigen::MatrixXd correlation;
    /// (parameters, error terms): change of a parameter by one standard uncertainty of a term, of a
    /// fit with every input as stated (add_input_uncertainty()); empty: not computed.
    Eigen::MatrixXd input_changes;

    std::vector<double> times;     ///< (frames) used, s
    ChainPrediction prediction;    ///< readings and Jacobian at the solution
    std::vector<double> residuals; ///< (frames, rows), measured − predicted, m; NaN where not seen
    std::vector<double> noise;     ///< (rows), by which the residuals were weighted, m
    std::string noise_source;      ///< as ReadingNoise::source
    bool is_noise_known = false;
    std::shared_ptr<const NoiseModel> noise_model; ///< as in the recording

    std::size_t readings = 0; ///< used
    std::size_t degrees_of_freedom = 0;
    /// Σ (residual/noise)², whitened by the noise model, and Σ value² of the error
    /// terms.
    double chi_squared = 0.0;
    double reduced_chi_squared = 0.0;
    double rmse = 0.0; ///< root mean square of the residuals, m

    int runs = 0; ///< of the chain with all its derivatives
    bool has_converged = false;
    std::string reason; ///< one sentence if not converged or at a bound

    [[nodiscard]] const FittedParameter* find(const physics::ParameterId& id) const;
};

/// The fit with some parameters fixed at the model's values; `is_held` is in the order of free_ids.
/// It starts there without growing windows. For profile likelihoods and constrained comparisons.
[[nodiscard]] RecordingFit fit_chain_with_held(const StemModel& model,
                                               const ObservedRecording& measurement,
                                               const std::vector<bool>& is_held,
                                               const SolveOptions& options = {});

/// `model` with the values that `fit` found for parameters and error terms of the same name.
[[nodiscard]] StemModel started_from(StemModel model, const RecordingFit& fit);

struct JointOptions {
    SolveOptions chain;        ///< windows count from each recording's own release
    std::vector<bool> is_held; ///< (joint parameters); empty: none
    /// (recordings)(rows), m: divides the residuals of recordings whose noise is not known; empty:
    /// the same value for all.
    std::vector<std::vector<double>> noise;
};

enum class FitStatus {
    Fitted,
    Motionless,   ///< nothing in the model moves the stem: the residuals are the readings
    NotConverged, ///< of a solution; a fit that ends like that is Failed
    Failed
};

/// Misfit of one recording.
struct RecordingMisfit {
    std::size_t readings = 0;
    double chi_squared = 0.0; ///< the degrees of freedom if the noise is unknown
    double rmse = 0.0;        ///< m
    bool is_noise_known = false;
};

/// A model fitted to one or several recordings at once. They share the material and everything that
/// acts on the stem; a parameter that belongs to one recording (belongs_to_recording) has a value
/// for each. SI units.
struct Fit {
    SelectedEffects effects;        ///< in addition to the published chain
    std::vector<std::string> names; ///< "baseline" and the effects, in the library's order
    FitStatus status = FitStatus::Failed;
    std::string reason; ///< why it failed, or the parameters at a bound

    std::vector<FittedParameter> parameters; ///< every number once, as JointLayout names them
    double chi_squared = 0.0;
    double reduced_chi_squared = 0.0;
    double rmse = 0.0; ///< m, over all readings
    std::size_t readings = 0;
    std::size_t degrees_of_freedom = 0;
    std::vector<RecordingMisfit> misfits; ///< (recordings)
    int runs = 0;                         ///< of chains with all their derivatives

    /// (recordings) each with its own numbers, residuals and χ²; covariance and standard errors are
    /// those of the joint solution, restricted to the part's parameters. Empty: the numbers alone.
    std::vector<RecordingFit> parts;
    /// (recordings) error terms of the model itself, if there are no parts that contain them.
    std::vector<std::vector<ReadingErrors::Term>> model_terms;
    std::vector<std::vector<std::size_t>> places; ///< (recordings)(parameters of the part)
    Eigen::MatrixXd covariance;                   ///< (parameters, parameters)
    double weighted_rms = 0.0;                    ///< of residual over noise: what was minimised
    std::vector<std::vector<double>> noise; ///< (recordings)(rows), m: its own or JointOptions'

    [[nodiscard]] bool failed() const {
        return status == FitStatus::Failed || status == FitStatus::NotConverged;
    }
    [[nodiscard]] bool moves() const { return status != FitStatus::Motionless; }
    /// Does any recording state its noise? For all of them see is_noise_known_everywhere().
    [[nodiscard]] bool is_noise_known_anywhere() const {
        return std::ranges::any_of(misfits, &RecordingMisfit::is_noise_known);
    }
    [[nodiscard]] bool is_noise_known_everywhere() const {
        return std::ranges::all_of(misfits, &RecordingMisfit::is_noise_known);
    }
    /// Were its parameters fitted?
    [[nodiscard]] bool is_fitted() const { return status == FitStatus::Fitted; }
};

/// One model for each recording.
using StartModels = std::vector<StemModel>;

/// The models of a fit's parts.
[[nodiscard]] StartModels start_from(const Fit& fit);

/// The chain, the frames and the heartbeat of a fit.
struct FitOptions {
    ChainOptions chain;
    std::optional<double> window; ///< only frames up to here, s after the release; empty: all
    run::Heartbeat heartbeat;

    [[nodiscard]] SolveOptions solve(bool is_first_guess = false) const {
        return {.window = window, .is_first_guess = is_first_guess, .heartbeat = heartbeat};
    }
};

/// `options` with this heartbeat, or unchanged if it is empty.
[[nodiscard]] FitOptions with_heartbeat(FitOptions options, const run::Heartbeat& heartbeat);

/// Fills `fit` from the model, times, prediction, noise (by which the residuals were weighted) and
/// is_noise_known of its parts. Fixed parameters get a standard error of 0. If the noise of a part
/// is not known, it is determined from the residuals, so that the part's reduced χ² is 1.
void add_statistics(std::span<const ObservedRecording> measurements, const JointLayout& layout,
                    const std::vector<bool>& is_held, Fit& fit);

/// Adds the contribution of the error terms of `recordings` to the covariance of a fit without
/// terms: K (s N + U Uᵀ) Kᵀ with K = (Jᵀ N⁻¹ J)⁻¹ Jᵀ N⁻¹, the noise N, a column of U for each term,
/// and the factor `misfit` (s, at least 1) of an inadequate model (JCGM 100, 5.1.2). Updates the
/// standard errors.
void add_input_uncertainty(std::span<const ObservedRecording> recordings, double misfit, Fit& fit);

/// Start of a fit with the recording's error terms: one least-squares step from `stated`, a fit
/// without them, or `stated` itself if the step takes a term beyond `contradiction`.
[[nodiscard]] StemModel linear_start(const RecordingFit& stated,
                                     const ObservedRecording& recording);

/// Fits all recordings by least squares, with Levenberg and Marquardt's method with bounds (Ceres)
/// and the sensitivities of run::simulate_with_sensitivities. Each recording has its own model
/// (length, section, known masses, frame rate, rows). The fit starts from the models' values, for a
/// shared parameter from the first model that has it. Error terms are fitted too; each adds its own
/// value as a residual. The covariance is (JᵀWJ/s + C)⁻¹ with the reduced χ² s, at least 1, and the
/// information C of these constraints. A fit that ends at a bound or does not converge is returned
/// with its reason. Throws core::NumericalError if it cannot start, run::Abandoned if the heartbeat
/// says so.
[[nodiscard]] Fit fit_jointly(std::span<const StemModel> models,
                              std::span<const ObservedRecording> measurements,
                              const JointOptions& options = {});

} // namespace culm::fit
