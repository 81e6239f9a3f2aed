// SPDX-License-Identifier: BSD-3-Clause
// A model of one or several recordings at a point of its parameters, as a linear problem.
//
//     residual = jacobian · change + white noise of unit variance.
//
// Its rows are the readings of all recordings, over their noise and whitened, then one row for each
// error term k, whose value v_k has mean 0 and standard deviation 1: 0 − v_k = change_k, and one
// for each parameter whose value is known within a deviation.
//
// One rule for missing values: a reading that was not seen, or that the model does not reach, is a
// row of zeros. A derivative that is not finite is 0: near the edge of the stem a lane may miss the
// row.
#pragma once

#include "fit/chain/observed_recording.hpp"
#include "fit/chain/stem_model.hpp"
#include "fit/linear/layout.hpp"

#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

namespace culm::fit {

struct WeightedSystem {
    std::vector<physics::ParameterId> ids;        ///< (columns) of an error term its id as name
    std::vector<std::optional<ErrorKind>> errors; ///< (columns) empty: a parameter
    Eigen::MatrixXd jacobian;     ///< (rows, columns), by the parameters' coordinates
    Eigen::VectorXd residual;     ///< (rows), measured − predicted
    Eigen::VectorXd predicted;    ///< (rows)
    Eigen::Index constraints = 0; ///< of the error terms, then of known parameters: the last rows
    Eigen::Index fitted = 0;      ///< columns of the numbers that a fit changes: the first ones

    [[nodiscard]] Eigen::Index readings() const { return residual.size() - constraints; }
    /// Of a term that is not fitted.
    [[nodiscard]] Eigen::Index column_of(const ErrorTerm& term) const;
};

/// One recording in a system. All must outlive the call.
struct SystemPart {
    const StemModel& model;
    const ObservedRecording& recording;
    const ChainPrediction& prediction;   ///< of the recording's first frames
    const std::vector<double>& noise;    ///< (rows), m
    const std::vector<ErrorTerm>& terms; ///< that are not fitted
};

/// The columns of the layout, then those of the parts' terms: terms of the same id are one.
[[nodiscard]] WeightedSystem weighted_system(const JointLayout& layout,
                                             std::span<const SystemPart> parts);

/// Readings of a part's prediction in the rows of the system: weighted and whitened as there.
[[nodiscard]] Eigen::VectorXd weighted_readings(const SystemPart& part);

/// Column of an error term, per standard uncertainty. (rows of the part)
[[nodiscard]] Eigen::VectorXd weighted_term(const ErrorTerm& term, const SystemPart& part);

} // namespace culm::fit
