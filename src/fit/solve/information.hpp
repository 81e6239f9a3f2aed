// SPDX-License-Identifier: BSD-3-Clause
// What readings tell of the parameters of a fit, direction by direction.
#pragma once

#include <Eigen/Core>

namespace culm::fit {

/// Eigenvectors of an information matrix Jᵀ W J, (parameters, parameters), whose parameters are
/// scaled alike: by the root of the diagonal, or by 1 where the readings tell nothing of one.
struct InformationDirections {
    Eigen::VectorXd scale;       ///< (parameters)
    Eigen::VectorXd information; ///< (directions), rising
    Eigen::MatrixXd directions;  ///< (parameters, directions), scaled and orthonormal

    /// Not smaller, against the largest, than derivatives of runs can tell.
    [[nodiscard]] bool is_known(Eigen::Index direction) const;
};

/// `matrix` is symmetric and has at least one row.
[[nodiscard]] InformationDirections information_directions(const Eigen::MatrixXd& matrix);

} // namespace culm::fit
