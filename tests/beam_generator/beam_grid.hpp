// SPDX-License-Identifier: BSD-3-Clause
// Shape functions of a clamped beam's slope, and the points at which integrals are taken.
#pragma once

#include "beam_generator/beam_terms.hpp"

#include <optional>
#include <vector>

#include <Eigen/Core>

namespace culm::beam {

/// Points of a section of the beam between jumps of its stiffness.
struct Panel {
    double begin = 0.0; ///< m
    double end = 0.0;
    Eigen::Index first = 0; ///< point
    Eigen::Index points = 0;
    Eigen::VectorXd barycentric_weights; ///< (points)
};

/// The slope u(s) = dy/ds, which is the sine of the stem's angle, is a sum of n functions: the
/// integrals of Legendre polynomials, so that the curvature is a polynomial; for a weak segment
/// a constant and a linear curvature within it; and 1 if the clamp turns. P Gauss points.
struct BeamGrid {
    double length = 0.0;
    bool clamp_turns = false;  ///< then function 0 is 1
    Eigen::VectorXd position;  ///< (P), m
    Eigen::VectorXd weight;    ///< (P), m
    Eigen::MatrixXd slope;     ///< (P, n) functions
    Eigen::MatrixXd curvature; ///< (P, n) their derivatives, 1/m
    /// (P + 1, P): values at the points to their integrals from the clamp to each point, and to the
    /// tip, m.
    Eigen::MatrixXd integral;
    Eigen::MatrixXd deflection; ///< (P + 1, n): integrals of the functions, m
    std::vector<Panel> panels;

    [[nodiscard]] Eigen::Index points() const { return position.size(); }
    [[nodiscard]] Eigen::Index functions() const { return slope.cols(); }
    /// Weights (P) with which values at the points give the value at `place` (m), 0 … L.
    [[nodiscard]] Eigen::VectorXd interpolation(double place) const;
    [[nodiscard]] const Panel& panel_at(double place) const;
};

[[nodiscard]] BeamGrid make_grid(double length, bool clamp_turns,
                                 const std::optional<WeakSegment>& segment);

} // namespace culm::beam
