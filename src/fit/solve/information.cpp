// SPDX-License-Identifier: BSD-3-Clause
#include "fit/solve/information.hpp"

#include <Eigen/Eigenvalues>

namespace culm::fit {

bool InformationDirections::is_known(Eigen::Index direction) const {
    // Derivatives by lanes are good to 1e-5 of the largest: their products know no less than its
    // square, with a margin of a hundred.
    constexpr double smallest_share = 1e-12;
    return information(direction) > smallest_share * information.maxCoeff();
}

InformationDirections information_directions(const Eigen::MatrixXd& matrix) {
    InformationDirections out;
    // Y in Pa and a mass in kg differ by fifteen decades: without a common scale the eigenvalues
    // would rank the units.
    out.scale = matrix.diagonal().cwiseSqrt();
    for (double& entry : out.scale)
        entry = entry > 0.0 ? entry : 1.0;
    const Eigen::MatrixXd scaled =
        out.scale.cwiseInverse().asDiagonal() * matrix * out.scale.cwiseInverse().asDiagonal();
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(scaled);
    out.information = solver.eigenvalues();
    out.directions = solver.eigenvectors();
    return out;
}

} // namespace culm::fit
