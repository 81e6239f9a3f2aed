// SPDX-License-Identifier: BSD-3-Clause
// Small motions and the energy of the beam.
#include "beam_generator/beam_model.hpp"

#include <cmath>

namespace culm::beam {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

MatrixXd for_every_field(const MatrixXd& block, Index fields) {
    MatrixXd matrix = MatrixXd::Zero(fields * block.rows(), fields * block.cols());
    for (Index f = 0; f < fields; ++f)
        matrix.block(f * block.rows(), f * block.cols(), block.rows(), block.cols()) = block;
    return matrix;
}

} // namespace

MatrixXd BeamModel::mass_matrix() const {
    return for_every_field(
        grid_.deflection.transpose() * point_mass_.asDiagonal() * grid_.deflection, fields());
}

MatrixXd BeamModel::damping_matrix(double branch_step, const VectorXd& q) const {
    double time = 0.0;
    for (const RelaxingBranch& branch : terms_.branches)
        time += branch_step * branch.fraction / (1.0 + branch_step / branch.time);
    const VectorXd square = field_rows(q, grid_.curvature).rowwise().squaredNorm();
    const VectorXd weighted =
        (time + bending_time(square)) * (rigidity_.array() * grid_.weight.array());
    const VectorXd drag = terms_.linear_drag * grid_.weight;
    const MatrixXd shapes = grid_.deflection.topRows(grid_.points());
    MatrixXd block = grid_.curvature.transpose() * weighted.asDiagonal() * grid_.curvature +
                     shapes.transpose() * drag.asDiagonal() * shapes;
    if (second_mode_.size() > 0)
        block += second_damping_ * second_mode_ * second_mode_.transpose();
    MatrixXd damping = for_every_field(block, fields());
    if (terms_.clamp)
        damping(0, 0) += terms_.clamp->damping;
    return damping;
}

MatrixXd BeamModel::stiffness_matrix() const {
    MatrixXd stiffness(freedoms(), freedoms());
    // Moments are linear in small curvatures, so unit ones give the columns.
    for (Index k = 0; k < freedoms(); ++k) {
        const VectorXd unit = VectorXd::Unit(freedoms(), k);
        const MatrixXd bent = field_rows(unit, grid_.curvature);
        MatrixXd moments = bent.array().colwise() * rigidity_.array();
        if (fields() == 2) {
            const double cosine = std::cos(2.0 * terms_.split_angle);
            const double sine = std::sin(2.0 * terms_.split_angle);
            const VectorXd split = 0.5 * terms_.stiffness_split * rigidity_;
            moments.col(0) += split.cwiseProduct(cosine * bent.col(0) + sine * bent.col(1));
            moments.col(1) += split.cwiseProduct(sine * bent.col(0) - cosine * bent.col(1));
        }
        for (Index f = 0; f < fields(); ++f)
            stiffness.col(k).segment(f * grid_.functions(), grid_.functions()) =
                grid_.curvature.transpose() * moments.col(f).cwiseProduct(grid_.weight);
        VectorXd clamp = VectorXd::Zero(freedoms());
        add_clamp(1e-6 * unit, clamp);
        stiffness.col(k) += 1e6 * clamp;
        if (terms_.slip && k == 0)
            stiffness(0, 0) += terms_.clamp->stiffness;
    }
    if (second_mode_.size() > 0)
        stiffness +=
            for_every_field(second_stiffness_ * second_mode_ * second_mode_.transpose(), fields());
    return stiffness;
}

double BeamModel::energy(const VectorXd& q, const VectorXd& v) const {
    const Kinematics at = kinematics(q);
    const VectorXd cosine_rate =
        (at.along.array() * field_rows(v, grid_.slope).array()).rowwise().sum();
    const VectorXd axial = grid_.integral * cosine_rate;
    const MatrixXd lateral = field_rows(v, grid_.deflection);
    double energy =
        0.5 * point_mass_.dot(
                  (lateral.rowwise().squaredNorm().array() + axial.array().square()).matrix());
    MatrixXd bent = bending(at, q).curvature;
    const MatrixXd moments = elastic_moments(bent);
    bent.col(0) -= curved_at_rest_;
    // The energy of M = EI κ (1 + γ κ²) is ½ M κ less ¼ γ EI κ⁴.
    const Eigen::ArrayXd square = bent.rowwise().squaredNorm().array();
    energy += grid_.weight.dot((0.5 * (moments.array() * bent.array()).rowwise().sum() -
                                0.25 * terms_.cubic_bending * rigidity_.array() * square.square())
                                   .matrix());
    const VectorXd shortening = grid_.integral * (1.0 - at.cosine.array()).matrix();
    energy += terms_.axial_gravity * point_mass_.dot(shortening);
    energy -= terms_.transverse_gravity * point_mass_.dot(field_rows(q, grid_.deflection).col(0));
    for (Index f = 0; f < fields() && second_mode_.size() > 0; ++f)
        energy += 0.5 * second_stiffness_ * std::pow(second_coordinate(q, f), 2);
    if (terms_.clamp)
        energy += 0.5 * terms_.clamp->stiffness * std::pow(std::asin(q[0]), 2);
    return energy;
}

} // namespace culm::beam
