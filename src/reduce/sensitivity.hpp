// SPDX-License-Identifier: BSD-3-Clause
// Sobol indices: what share of a response's variance each input explains.
#pragma once

#include "reduce/population_statistics.hpp"

#include <cstddef>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace culm::reduce {

/// An input, or inputs that depend on each other and therefore share one index. Groups are
/// independent of each other.
struct InputGroup {
    std::string name;
    Eigen::MatrixXd values;  ///< at the study's points: (points, inputs)
    Eigen::MatrixXd nodes;   ///< the joint distribution as nodes: (nodes, inputs)
    Eigen::VectorXd weights; ///< of the nodes, sum 1
};

/// Indices of Sobol (1993) and Homma & Saltelli (1996).
struct GroupSensitivity {
    std::string name;
    Share first_order; ///< explained by this group alone
    Share total;       ///< with its interactions: what remains if all other groups are fixed
};

struct Sensitivity {
    std::size_t points = 0;
    int degree = 0;        ///< of the polynomials; 0: no input explains anything
    std::size_t terms = 0; ///< with the constant
    /// Share of the variance that the polynomials predict at points left out one at a time (Q²);
    /// 1 − Q² is noise or truncation of the series.
    double predicted_share = 0.0;
    double mean = 0.0;               ///< of the response under the inputs' distributions
    double standard_deviation = 0.0; ///< of the same
    double interactions = 0.0;       ///< share that no group explains alone
    std::vector<GroupSensitivity> groups;

    /// False if the polynomials predict nothing at points left out: then no index is determined.
    [[nodiscard]] bool is_determined() const { return degree > 0 && predicted_share > 0.0; }
};

template <class To>
void describe(To& to, const GroupSensitivity& group) {
    to("group", group.name);
    to("first_order", group.first_order);
    to("total", group.total);
}

template <class To>
void describe(To& to, const Sensitivity& found) {
    to("points", found.points);
    to("degree", found.degree);
    to("terms", found.terms);
    to("predicted_share", found.predicted_share);
    to("mean", found.mean);
    to("standard_deviation", found.standard_deviation);
    to("interactions", found.interactions);
    to("indices", found.groups);
}

/// Polynomial chaos by least squares (Sudret 2008): products of the groups' orthonormal
/// polynomials up to a total degree, which is that of the smallest leave-one-out error. Squared
/// coefficients are corrected for their variance; intervals use the delta method with
/// heteroscedasticity-consistent covariances (HC3, MacKinnon & White 1985).
/// `responses` has the shape (points, responses); one result for each column.
/// Throws core::NumericalError (FitFailed) when there are too few points for degree 1 or no input
/// varies.
[[nodiscard]] std::vector<Sensitivity> analyse_sensitivity(const std::vector<InputGroup>& groups,
                                                           const Eigen::MatrixXd& responses);

/// Orthonormal polynomials of a discrete measure, by QR of the weighted monomials. The nodes are
/// quadrature nodes of a distribution, levels of a list or rows of a table. The constant function
/// is not included.
class GroupPolynomials {
  public:
    /// `nodes` has the shape (nodes, inputs), `weights` (nodes) sums to one. Functions that the
    /// nodes cannot distinguish from lower ones (two levels determine no parabola) are left out.
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
