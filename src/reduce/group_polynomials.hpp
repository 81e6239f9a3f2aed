// SPDX-License-Identifier: BSD-3-Clause
// Polynomials that are orthonormal under the distribution of an input, or of inputs that belong
// together.
#pragma once

#include <vector>

#include <Eigen/Core>

namespace culm::reduce {

/// Orthonormal polynomials of a discrete measure, by QR of the weighted monomials: for quadrature
/// nodes of a distribution those of the distribution, for a list of levels those of the list, for
/// rows of a table those of the rows. The constant function is not counted among them.
class GroupPolynomials {
  public:
    /// `nodes` has the shape (nodes, inputs), `weights` (nodes) sums to one. Functions that the
    /// nodes cannot tell from lower ones (two levels know no parabola) are left out.
    GroupPolynomials(const Eigen::MatrixXd& nodes, const Eigen::VectorXd& weights,
                     int largest_degree);

    /// Degree of each function, ascending.
    [[nodiscard]] const std::vector<int>& degrees() const { return degrees_; }

    /// Values at places of the shape (places, inputs): (places, functions).
    [[nodiscard]] Eigen::MatrixXd at(const Eigen::MatrixXd& places) const;

  private:
    /// (places, monomials), the constant first, of the standardised inputs.
    [[nodiscard]] Eigen::MatrixXd monomials(const Eigen::MatrixXd& places) const;

    Eigen::RowVectorXd centre_;
    Eigen::RowVectorXd scale_;
    std::vector<std::vector<int>> exponents_; ///< of each monomial: (inputs)
    Eigen::MatrixXd coefficients_;            ///< (monomials, functions)
    std::vector<int> degrees_;
};

} // namespace culm::reduce
