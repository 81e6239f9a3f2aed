// SPDX-License-Identifier: BSD-3-Clause
// Readings of one or several recordings over their noise, stacked in one vector.
#pragma once

#include "fit/fit_model.hpp"
#include "fit/solve/layout.hpp"

#include <span>
#include <vector>

#include <Eigen/Core>
#include <Eigen/QR>

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

/// `models`, `recordings` and `base` (which provides times and noise) belong together; unseen
/// readings are rows of zeros. Throws core::NumericalError if a model cannot be computed.
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

/// Least squares onto the columns of a matrix. By the Frisch-Waugh-Lovell theorem the remainder of
/// a new column is the part that a joint fit can detect; the coefficients are the changes of the
/// fitted parameters that hide the rest. Columns are independent down to 1e-6 of their length.
class Projector {
  public:
    explicit Projector(const Eigen::MatrixXd& columns);

    [[nodiscard]] Eigen::MatrixXd coefficients(const Eigen::MatrixXd& wanted) const;
    [[nodiscard]] Eigen::MatrixXd remainder(const Eigen::MatrixXd& wanted) const;

  private:
    Eigen::MatrixXd columns_;
    Eigen::VectorXd scale_;
    Eigen::ColPivHouseholderQR<Eigen::MatrixXd> solver_;
};

/// Predicted readings over their noise, whitened, in the rows of stacked_readings(base); 0 for the
/// constraints. Each run has one model for each recording; the runs are computed side by side in
/// lanes. Throws as predict_readings().
[[nodiscard]] std::vector<Eigen::VectorXd>
readings_together(const std::vector<fit::StartModels>& runs, const StackedReadings& like,
                  const fit::Fit& base, const run::Heartbeat& heartbeat);

} // namespace culm::diagnose
