// SPDX-License-Identifier: BSD-3-Clause
// A model of the chain fitted to every height and frame of a measurement at once.
#pragma once

#include "calibrate/chain_prediction.hpp"
#include "calibrate/reading_noise.hpp"

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace culm::calibrate {

struct ChainFitOptions {
    /// Only frames up to here, s after the release; empty: all. Frames before the release count.
    std::optional<double> window;
    /// Readings that deviate by more than 2 σ count less and less (Huber's loss), so that a few
    /// wrong ones do no harm.
    bool is_robust = false;
    /// True: from the model's values as a first guess, with several moduli about it and a window
    /// that grows from 2 to 5 and 12 cycles to all, so that no cycle is skipped. False: the values
    /// are near the solution (a refit with an effect added), all frames at once.
    bool is_first_guess = true;
    int largest_iterations = 50; ///< of each window
    /// A solution whose pace would not bring χ² down to this within the iterations ends early, as
    /// JointFit::out_of_reach tells; empty: none does.
    std::optional<double> wanted_chi_squared;
    run::Heartbeat heartbeat;
};

struct FittedParameter {
    std::string name;
    std::string unit;
    double value = 0.0;
    double standard_error = 0.0; ///< infinite where the data do not tell
    bool is_at_bound = false;
    double lower = 0.0; ///< allowed range
    double upper = 0.0;
    physics::FittedAs fitted_as = physics::FittedAs::Itself;
    bool is_place = false; ///< as physics::EffectParameter's
    double absent = 0.0;   ///< likewise
};

/// The result; everything in SI units and for the readings as they are, without transformation.
struct ChainFit {
    StemModel model;                         ///< with the fitted values
    std::vector<FittedParameter> parameters; ///< as StemModel::free_names
    Eigen::MatrixXd covariance;              ///< (parameters, parameters)
    Eigen::MatrixXd correlation;

    std::vector<double> times;     ///< (frames) used, s
    ChainPrediction prediction;    ///< readings and Jacobian at the solution
    std::vector<double> residuals; ///< (frames, rows), measured − predicted, m; NaN where not seen
    std::vector<double> noise;     ///< (rows), by which the residuals were weighted, m
    std::string noise_source;      ///< as ReadingNoise::source; "residuals": it was not known
    bool is_noise_known = false;

    std::size_t readings = 0; ///< used
    std::size_t degrees_of_freedom = 0;
    double chi_squared = 0.0; ///< Σ (residual/noise)²
    double reduced_chi_squared = 0.0;
    double rmse = 0.0; ///< root mean square of the residuals, m

    int runs = 0; ///< of the chain with all its derivatives
    bool has_converged = false;
    std::string reason; ///< one sentence if it has not, or ends at a bound

    [[nodiscard]] const FittedParameter* find(const std::string& name) const;
};

/// Least squares by Levenberg and Marquardt's method with bounds (Ceres) and the sensitivities of
/// run::simulate_with_sensitivities. The covariance is (JᵀWJ)⁻¹, times the reduced χ² where that is
/// above 1: what a model lacks makes its parameters less sure. A fit that ends at a bound or does
/// not converge comes back with its reason; one that cannot even start throws
/// core::NumericalError. run::Abandoned if the heartbeat says so.
[[nodiscard]] ChainFit fit_chain(const StemModel& model, const measure::Measurement& measurement,
                                 const ChainFitOptions& options = {});

/// The fit with some parameters held at the model's values; `is_held` in the order of free_names.
/// Starts there without growing windows. For profile likelihoods and constrained comparisons.
[[nodiscard]] ChainFit fit_chain_with_held(const StemModel& model,
                                           const measure::Measurement& measurement,
                                           const std::vector<bool>& is_held,
                                           const ChainFitOptions& options = {});

/// `model` with the values that `fit` found for parameters of the same name.
[[nodiscard]] StemModel started_from(StemModel model, const ChainFit& fit);

} // namespace culm::calibrate
