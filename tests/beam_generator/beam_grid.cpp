// SPDX-License-Identifier: BSD-3-Clause
#include "beam_generator/beam_grid.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>

namespace culm::beam {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Polynomials of the curvature. 12 give the first five frequencies of a cantilever to 1e-6.
constexpr Index polynomials = 12;
constexpr Index points_a_panel = 24;

/// P_0 … P_last at x.
VectorXd legendre(double x, Index last) {
    VectorXd values(last + 1);
    values[0] = 1.0;
    if (last > 0)
        values[1] = x;
    for (Index k = 1; k < last; ++k) {
        const double n = static_cast<double>(k);
        values[k + 1] = ((2.0 * n + 1.0) * x * values[k] - n * values[k - 1]) / (n + 1.0);
    }
    return values;
}

/// Integrals of P_0 … P_last from −1 to x.
VectorXd legendre_integrals(double x, Index last) {
    const VectorXd p = legendre(x, last + 1);
    VectorXd integrals(last + 1);
    integrals[0] = x + 1.0;
    for (Index k = 1; k <= last; ++k)
        integrals[k] = (p[k + 1] - p[k - 1]) / (2.0 * static_cast<double>(k) + 1.0);
    return integrals;
}

/// Gauss's rule on −1 … 1 and the integrals of the polynomial through values at its nodes.
struct GaussRule {
    VectorXd node;
    VectorXd weight;
    MatrixXd integral; ///< (nodes, nodes), from −1 to each node
};

/// Nodes and weights from the eigenvalues of the Jacobi matrix (Golub & Welsch 1969).
GaussRule gauss_rule(Index count) {
    MatrixXd jacobi = MatrixXd::Zero(count, count);
    for (Index k = 1; k < count; ++k) {
        const double n = static_cast<double>(k);
        jacobi(k, k - 1) = jacobi(k - 1, k) = n / std::sqrt(4.0 * n * n - 1.0);
    }
    const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(jacobi);
    GaussRule rule;
    rule.node = solver.eigenvalues();
    rule.weight = 2.0 * solver.eigenvectors().row(0).transpose().array().square();
    // The polynomial through the values is its Legendre series, which Gauss's rule gives exactly.
    MatrixXd series(count, count);
    MatrixXd integrals(count, count);
    for (Index p = 0; p < count; ++p) {
        const VectorXd values = legendre(rule.node[p], count - 1);
        for (Index j = 0; j < count; ++j)
            series(j, p) = (static_cast<double>(j) + 0.5) * rule.weight[p] * values[j];
        integrals.row(p) = legendre_integrals(rule.node[p], count - 1).transpose();
    }
    rule.integral = integrals * series;
    return rule;
}

/// Where panels begin and end.
std::vector<double> panel_ends(double length, const std::optional<WeakSegment>& segment) {
    std::vector<double> ends{0.0};
    if (segment)
        for (const double side : {-0.5, 0.5}) {
            const double end = segment->position + side * segment->length;
            if (end > ends.back() + 1e-6 * length && end < (1.0 - 1e-6) * length)
                ends.push_back(end);
        }
    ends.push_back(length);
    return ends;
}

void add_points(const GaussRule& rule, const std::vector<double>& ends, BeamGrid& grid) {
    const Index per_panel = rule.node.size();
    const auto panels = static_cast<Index>(ends.size()) - 1;
    const Index points = panels * per_panel;
    grid.position.resize(points);
    grid.weight.resize(points);
    grid.integral = MatrixXd::Zero(points + 1, points);
    for (Index k = 0; k < panels; ++k) {
        const auto at = static_cast<std::size_t>(k);
        Panel panel{ends[at], ends[at + 1], k * per_panel, per_panel, VectorXd(per_panel)};
        const double half = 0.5 * (panel.end - panel.begin);
        for (Index p = 0; p < per_panel; ++p) {
            grid.position[panel.first + p] = panel.begin + half * (1.0 + rule.node[p]);
            grid.weight[panel.first + p] = half * rule.weight[p];
            const double sign = p % 2 == 0 ? 1.0 : -1.0;
            panel.barycentric_weights[p] =
                sign * std::sqrt((1.0 - rule.node[p] * rule.node[p]) * rule.weight[p]);
        }
        grid.integral.block(panel.first, panel.first, per_panel, per_panel) = half * rule.integral;
        const auto later = points + 1 - panel.first - per_panel;
        grid.integral.block(panel.first + per_panel, panel.first, later, per_panel).rowwise() =
            grid.weight.segment(panel.first, per_panel).transpose();
        grid.panels.push_back(std::move(panel));
    }
}

} // namespace

BeamGrid make_grid(double length, bool clamp_turns, const std::optional<WeakSegment>& segment) {
    BeamGrid grid;
    grid.length = length;
    grid.clamp_turns = clamp_turns;
    add_points(gauss_rule(points_a_panel), panel_ends(length, segment), grid);
    const Index turning = clamp_turns ? 1 : 0;
    const Index functions = turning + polynomials + (segment ? 2 : 0);
    grid.slope = MatrixXd::Zero(grid.points(), functions);
    grid.curvature = MatrixXd::Zero(grid.points(), functions);
    if (clamp_turns)
        grid.slope.col(0).setOnes();
    for (Index p = 0; p < grid.points(); ++p) {
        const double place = 2.0 * grid.position[p] / length - 1.0;
        grid.curvature.row(p).segment(turning, polynomials) =
            legendre(place, polynomials - 1).transpose() / length;
        grid.slope.row(p).segment(turning, polynomials) =
            0.5 * legendre_integrals(place, polynomials - 1).transpose();
        if (!segment)
            continue;
        const double within = (grid.position[p] - segment->position) / segment->length;
        if (std::abs(within) < 0.5) {
            grid.curvature(p, functions - 2) = 1.0 / segment->length;
            grid.curvature(p, functions - 1) = within / segment->length;
        }
    }
    if (segment)
        grid.slope.rightCols(2) =
            grid.integral.topRows(grid.points()) * grid.curvature.rightCols(2);
    grid.deflection = grid.integral * grid.slope;
    return grid;
}

const Panel& BeamGrid::panel_at(double place) const {
    const auto found =
        std::ranges::find_if(panels, [place](const Panel& panel) { return place <= panel.end; });
    return found == panels.end() ? panels.back() : *found;
}

Eigen::VectorXd BeamGrid::interpolation(double place) const {
    const Panel& panel = panel_at(place);
    VectorXd weights = VectorXd::Zero(points());
    double sum = 0.0;
    for (Index p = 0; p < panel.points; ++p) {
        const double distance = place - position[panel.first + p];
        if (distance == 0.0) {
            weights.setZero();
            weights[panel.first + p] = 1.0;
            return weights;
        }
        weights[panel.first + p] = panel.barycentric_weights[p] / distance;
        sum += weights[panel.first + p];
    }
    return weights / sum;
}

} // namespace culm::beam
