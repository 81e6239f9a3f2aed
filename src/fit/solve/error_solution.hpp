// SPDX-License-Identifier: BSD-3-Clause
// The linear solution about a fit with all error terms (the mathematics: fit_result.hpp).
#pragma once

#include "fit/solve/fit_result.hpp"

#include <span>
#include <vector>

namespace culm::fit {

/// Adds the columns of the parts' terms to the system of a fit, solves it, and sets pulls, χ², what
/// remains of the residuals, covariance and standard errors. `is_held`: (joint parameters). If the
/// noise of a recording is not known, what remains determines it: its reduced χ² is 1.
///
/// If the fit has factors of Y (ErrorKind::Modulus), values and covariance become those of the
/// solution.
void solve_with_errors(std::span<const ObservedRecording> recordings, const JointLayout& layout,
                       const std::vector<bool>& is_held, const FitOptions& options, Fit& fit);

/// The parts of a fit's system.
[[nodiscard]] std::vector<SystemPart> parts_of(const Fit& fit,
                                               std::span<const ObservedRecording> recordings);

/// The system of a fit at other models of its recordings, which may have more free parameters.
/// Throws core::NumericalError if a model cannot be computed.
[[nodiscard]] WeightedSystem system_at(const StartModels& models, const Fit& fit,
                                       std::span<const ObservedRecording> recordings,
                                       const run::Heartbeat& heartbeat);

/// Predicted readings in the rows of the fit's system; 0 for the constraints. Each run has one
/// model for each recording; the runs are computed side by side in lanes, whose number is added to
/// `batches`. Throws as predict_readings().
[[nodiscard]] std::vector<Eigen::VectorXd>
readings_together(const std::vector<StartModels>& runs, const Fit& fit,
                  std::span<const ObservedRecording> recordings, const run::Heartbeat& heartbeat,
                  int& batches);

} // namespace culm::fit
