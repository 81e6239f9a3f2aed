// SPDX-License-Identifier: BSD-3-Clause
// A model fitted to every height and frame of one or several recordings at once.
//
// With the readings y, the prediction f(θ) and the covariance N of the noise, the fit is
//
//     θ̂ = argmin (y − f)ᵀ N⁻¹ (y − f),   every input as stated.
//
// Everything else that is uncertain is a column of U: S = N + U Uᵀ (ErrorTerm). One linear solve
// with the Jacobian J and U at θ̂ gives all other numbers:
//
//     χ² = min over δ, p of |y − f − J δ − U p|² (by N) + |p|²,   the pulls p,
//     covariance of θ̂ = K (s N + U Uᵀ) Kᵀ,   K = (Jᵀ N⁻¹ J)⁻¹ Jᵀ N⁻¹,
//
// s = max(1, reduced χ²), because an inadequate model makes the errors larger (JCGM 100, 5.1.2).
//
// Traps. The residuals that are printed are those of θ̂; χ² and the tests for lack of fit belong to
// the solution with error terms. Terms that a fit without them would be meaningless without (an
// offset of a sensor) are fitted: they are columns of J with a constraint. Recordings of one
// specimen have one Y, but each has its own length: their phases differ by more than a linear
// solution permits, so the fit gives each recording a factor of its Y (ErrorKind::Modulus), and the
// solution takes that back.
#pragma once

#include "fit/solve/solution.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
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
    bool is_place = false;          ///< as in physics::EffectParameter
    double absent = 0.0;            ///< likewise
    bool is_error = false;          ///< a fitted ErrorTerm
    double value_with_errors = 0.0; ///< in the linear solution, in which the inputs may move
};

/// Half of the parameter's 95 % interval.
[[nodiscard]] double interval_half_width(const FittedParameter& parameter);
/// Does that interval contain the value at which the effect is absent?
[[nodiscard]] bool is_absent(const FittedParameter& parameter);

/// An error term in the linear solution.
struct Pull {
    ErrorKind kind = ErrorKind::StatedInput;
    std::string id;
    double value = 0.0;          ///< in standard uncertainties
    double standard_error = 1.0; ///< of that; 1 if the readings say nothing about it
    std::vector<double> changes; ///< (parameters) of the fit by one standard uncertainty
};

/// The fit of one recording, in SI units and for the readings without transformation.
struct RecordingFit {
    StemModel model;                         ///< with the fitted values
    std::vector<FittedParameter> parameters; ///< as StemModel::free_ids

    std::vector<double> times;     ///< (frames) used, s
    ChainPrediction prediction;    ///< readings and Jacobian at the solution
    std::vector<double> residuals; ///< (frames, rows), measured − predicted, m; NaN where not seen
    /// The same without the part that the error terms explain.
    std::vector<double> remaining;
    std::vector<double> noise; ///< (rows), by which the residuals were weighted, m
    std::string noise_source;  ///< as ReadingNoise::source
    bool is_noise_known = false;
    std::shared_ptr<const NoiseModel> noise_model; ///< as in the recording
    std::vector<ErrorTerm> terms;                  ///< of the linear solution
    std::vector<std::string> missing_terms;        ///< one sentence for each kind that failed

    std::size_t readings = 0; ///< used
    std::size_t degrees_of_freedom = 0;
    double chi_squared = 0.0; ///< of `remaining`, and of the terms that this recording has first
    double reduced_chi_squared = 0.0;
    double rmse = 0.0; ///< root mean square of the residuals, m

    [[nodiscard]] const FittedParameter* find(const physics::ParameterId& id) const;
};

/// The results of runs at one point, for a recording: a fit that starts there needs no run.
struct KnownPoint {
    ChainPrediction prediction;
    std::vector<ErrorTerm> inputs; ///< terms of stated inputs
};

/// The number of batches of the runs does not travel, because the fit has counted them.
template <class Wire>
void fields(Wire& wire, KnownPoint& point) {
    ChainPrediction& prediction = point.prediction;
    wire(prediction.spheres, prediction.frames, prediction.rows, prediction.parameters,
         prediction.readings, prediction.jacobian, point.inputs);
}

/// The point of a fit's solution.
[[nodiscard]] KnownPoint known_point(const RecordingFit& fit);

enum class FitStatus {
    Fitted,
    Motionless, ///< nothing in the model moves the stem: the residuals are the readings
    Failed
};

/// Rms residual over the rms reading of a chain that follows the motion.
inline constexpr double small_remainder = 0.2;

/// Misfit of one recording.
struct RecordingMisfit {
    std::size_t readings = 0;
    double chi_squared = 0.0; ///< without the terms; the degrees of freedom if the noise is unknown
    double rmse = 0.0;        ///< of what remains, m
    bool is_noise_known = false;
    double motion = 0.0; ///< rms of the readings, m

    /// χ² over that of a chain that leaves small_remainder of the readings.
    [[nodiscard]] double over_followed() const {
        return std::pow(rmse / (small_remainder * motion), 2);
    }
};

/// A model fitted to one or several recordings at once. They share the material and everything that
/// acts on the stem; a parameter that belongs to one recording (belongs_to_recording) has a value
/// for each. SI units.
struct Fit {
    SelectedEffects effects; ///< in addition to the published chain
    FitStatus status = FitStatus::Failed;
    std::string reason; ///< why it failed, or the parameters at a bound

    std::vector<FittedParameter> parameters; ///< every number once, as JointLayout names them
    std::vector<Pull> pulls;                 ///< of the error terms
    /// Values and intervals are those of the solution with error terms, because several recordings
    /// disagree with exact inputs.
    bool has_moved_inputs = false;
    double chi_squared = 0.0;
    double reduced_chi_squared = 0.0;
    double rmse = 0.0; ///< m, over all readings
    std::size_t readings = 0;
    std::size_t degrees_of_freedom = 0;
    std::vector<RecordingMisfit> misfits; ///< (recordings)
    int batches = 0;                      ///< of lanes that were run
    std::vector<KnownPoint> points;       ///< (recordings) of a fit without parts; empty: none

    /// (recordings) each with its own numbers, residuals and χ²; standard errors are those of the
    /// joint solution. Empty: the numbers alone.
    std::vector<RecordingFit> parts;
    WeightedSystem system;      ///< at θ̂, with all error terms
    Eigen::MatrixXd covariance; ///< (parameters, parameters), of their coordinates
    double weighted_rms = 0.0;  ///< of residual over noise: what was minimised
    double own_weighted_rms =
        0.0; ///< the same with the noise that an unknown one was found to have

    /// "baseline" and the effects, in the library's order.
    [[nodiscard]] std::vector<std::string> names() const {
        return model_names(in_library_order(effects));
    }
    [[nodiscard]] bool failed() const { return status == FitStatus::Failed; }
    [[nodiscard]] bool moves() const { return status != FitStatus::Motionless; }
    /// Were its parameters fitted?
    [[nodiscard]] bool is_fitted() const { return status == FitStatus::Fitted; }
    /// Does any recording state its noise? For all of them see is_noise_known_everywhere().
    [[nodiscard]] bool is_noise_known_anywhere() const {
        return std::ranges::any_of(misfits, &RecordingMisfit::is_noise_known);
    }
    [[nodiscard]] bool is_noise_known_everywhere() const {
        return std::ranges::all_of(misfits, &RecordingMisfit::is_noise_known);
    }
};

/// The models of a fit's parts.
[[nodiscard]] StartModels start_from(const Fit& fit);
/// The times of its frames, (recordings), s.
[[nodiscard]] std::vector<std::vector<double>> times_of(const Fit& fit);

} // namespace culm::fit
