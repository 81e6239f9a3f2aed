// SPDX-License-Identifier: BSD-3-Clause
// Linear least squares whose unknowns have units of very different size.
//
// All of these scale the unknowns first: columns to unit length, symmetric matrices H to a unit
// diagonal, D⁻¹ H D⁻¹ with D = √diag H. Without a common scale a decomposition ranks the units: Y
// in Pa and a mass in kg differ by fifteen decades.
//
// Traps: derivatives by lanes have errors of 1e-5 of the largest (run/sensitivities.hpp), so a
// direction with less than 1e-6 of a column's length, or 1e-12 of the largest eigenvalue of H, is
// rounding error and has no information. A solution leaves such a direction unchanged.
#pragma once

#include <Eigen/Core>
#include <Eigen/QR>

namespace culm::fit {

/// Least squares onto the columns of a matrix. By the Frisch-Waugh-Lovell theorem the remainder of
/// a new column is the part that a joint fit can detect; the coefficients are the changes of the
/// fitted parameters that hide the rest.
class Projector {
  public:
    explicit Projector(const Eigen::MatrixXd& columns);

    [[nodiscard]] Eigen::MatrixXd coefficients(const Eigen::MatrixXd& wanted) const;
    [[nodiscard]] Eigen::MatrixXd remainder(const Eigen::MatrixXd& wanted) const {
        return remainder(wanted, coefficients(wanted));
    }
    /// From the coefficients() of `wanted`.
    [[nodiscard]] Eigen::MatrixXd remainder(const Eigen::MatrixXd& wanted,
                                            const Eigen::MatrixXd& coefficients) const {
        return wanted - columns_ * coefficients;
    }

  private:
    Eigen::MatrixXd columns_;
    Eigen::VectorXd scale_;
    Eigen::ColPivHouseholderQR<Eigen::MatrixXd> solver_;
};

/// A symmetric, positive semidefinite matrix by the eigenvectors of its scaled form.
class ScaledSpectrum {
  public:
    explicit ScaledSpectrum(const Eigen::MatrixXd& matrix);

    /// H⁻¹ b in the directions that have information.
    [[nodiscard]] Eigen::MatrixXd solve(const Eigen::MatrixXd& right) const;
    [[nodiscard]] Eigen::MatrixXd inverse() const;
    /// Has the unknown more than a thousandth of its length in directions without information?
    [[nodiscard]] bool is_unknown(Eigen::Index unknown) const { return unknown_(unknown) > 1e-6; }
    /// inverse() with an infinite variance of every unknown that is_unknown().
    [[nodiscard]] Eigen::MatrixXd covariance() const;
    /// Of the matrix itself; directions without information count as having the least.
    [[nodiscard]] double log_determinant() const;

  private:
    Eigen::VectorXd scale_;      ///< D
    Eigen::VectorXd values_;     ///< eigenvalues that have information
    Eigen::MatrixXd directions_; ///< (unknowns, directions), scaled and orthonormal
    Eigen::VectorXd unknown_;    ///< (unknowns) squared length in the other directions
};

/// The x that minimises ½ xᵀ H x − bᵀ x for lower ≤ x ≤ upper.
[[nodiscard]] Eigen::VectorXd bounded_minimum(const Eigen::MatrixXd& matrix,
                                              const Eigen::VectorXd& right,
                                              const Eigen::VectorXd& lower,
                                              const Eigen::VectorXd& upper);

} // namespace culm::fit
