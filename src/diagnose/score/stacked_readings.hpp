// SPDX-License-Identifier: BSD-3-Clause
// Readings of one or several recordings over their noise, one below the other.
#pragma once

#include "fit/fit_model.hpp"
#include "fit/solve/layout.hpp"

#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace culm::diagnose {

/// A model at a point of its parameters, as the linear problem residual = jacobian · change.
struct StackedReadings {
    std::vector<physics::ParameterId> ids; ///< of the columns
    Eigen::MatrixXd jacobian;              ///< (rows, parameters), by the parameters' own units
    Eigen::VectorXd residual;              ///< (rows), measured − predicted
    Eigen::VectorXd predicted;             ///< (rows)
    Eigen::Index constraints = 0;          ///< of the error terms: the last rows

    [[nodiscard]] Eigen::Index readings() const { return residual.size() - constraints; }
};

/// `models`, `recordings` and `base` (whose times and noise count) belong together; readings that
/// were not seen are rows of zeros. Throws core::NumericalError if a model cannot be computed.
[[nodiscard]] StackedReadings stacked_readings(std::span<const fit::StemModel> models,
                                               std::span<const fit::ObservedRecording> recordings,
                                               const fit::Fit& base,
                                               const run::Heartbeat& heartbeat);

/// The fit itself, without a run.
[[nodiscard]] StackedReadings stacked_readings(const fit::Fit& base,
                                               std::span<const fit::ObservedRecording> recordings);

/// The models after this change of the parameters in their joint list, each within its bounds.
[[nodiscard]] fit::StartModels moved(fit::StartModels models, const fit::JointLayout& layout,
                                     const Eigen::VectorXd& change);

/// Change of the parameters that minimises the square of what is left.
struct LinearSolution {
    Eigen::VectorXd change;
    double left = 0.0; ///< square of the residual that remains
};

/// Columns count as independent down to 1e-6 of their length; `is_held` columns do not change.
[[nodiscard]] LinearSolution solve_linear(const StackedReadings& stacked,
                                          const std::vector<bool>& is_held);

/// What of `column` the columns of `jacobian` cannot imitate, and the imitation's coefficients.
struct Projection {
    Eigen::VectorXd standing_out;
    Eigen::VectorXd imitation;
};
[[nodiscard]] Projection project_off(const Eigen::MatrixXd& jacobian,
                                     const Eigen::VectorXd& column);

} // namespace culm::diagnose
