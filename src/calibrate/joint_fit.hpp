// SPDX-License-Identifier: BSD-3-Clause
// One model fitted to several recordings at once: what they share is one number.
#pragma once

#include "calibrate/chain_fit.hpp"
#include "calibrate/joint_layout.hpp"

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace culm::calibrate {

struct JointOptions {
    ChainFitOptions chain;                   ///< windows count from each recording's own release
    BelongsToRecording belongs_to_recording; ///< empty: everything is shared
    std::vector<bool> is_held;               ///< (joint parameters); empty: none
    /// (recordings)(rows), m: by what the residuals of recordings of unknown noise are weighted
    /// until they tell it; empty: all alike.
    std::vector<std::vector<double>> weights;
};

/// SI units, as ChainFit.
struct JointFit {
    /// (recordings) each with its own numbers, residuals and χ²; covariance and standard errors are
    /// those of the joint solution, restricted to the part's parameters.
    std::vector<ChainFit> parts;
    std::vector<FittedParameter> parameters;      ///< every number once, as JointLayout names them
    std::vector<std::vector<std::size_t>> places; ///< (recordings)(parameters of the part)
    Eigen::MatrixXd covariance;                   ///< (parameters, parameters)

    std::size_t readings = 0;
    std::size_t degrees_of_freedom = 0;
    double chi_squared = 0.0;
    double reduced_chi_squared = 0.0;
    double rmse = 0.0;                        ///< m, over all readings
    double weighted_rms = 0.0;                ///< of residual over weight: what was minimised
    std::vector<std::vector<double>> weights; ///< (recordings)(rows), m: noise or JointOptions'

    int runs = 0; ///< of chains with all their derivatives
    bool has_converged = false;
    /// ChainFitOptions::wanted_chi_squared if the fit has ended early because of it.
    std::optional<double> out_of_reach;
    std::string reason;
};

/// Least squares over all recordings, each with a model of its own (length, section, known masses,
/// frame rate, rows), by the method of fit_chain, which is the same with one recording. Starts from
/// the models' values, shared ones from the first model that has them. The covariance is the
/// inverse of the summed information, times the reduced χ² where that is above 1. Errors and
/// failures as fit_chain's.
[[nodiscard]] JointFit fit_jointly(std::span<const StemModel> models,
                                   std::span<const measure::Measurement> measurements,
                                   const JointOptions& options = {});

} // namespace culm::calibrate
