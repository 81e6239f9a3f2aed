// SPDX-License-Identifier: BSD-3-Clause
#include "beam_generator/beam_model.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>

#include <Eigen/Eigenvalues>

namespace culm::beam {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// A clamp that turns in the plane of the pull only: across it the same shape function is held.
constexpr double rigid_clamp = 1e4; // times E I/L

double relative_place(double position, double length) {
    return position / length - 0.5;
}

VectorXd rigidities(const BeamStem& stem, const BeamTerms& terms, const BeamGrid& grid) {
    VectorXd values(grid.points());
    for (Index p = 0; p < grid.points(); ++p) {
        const double place = relative_place(grid.position[p], grid.length);
        const double diameter = 1.0 + terms.taper * place;
        values[p] =
            stem.rigidity() * std::pow(diameter, 4) * (1.0 + terms.stiffness_gradient * place);
        if (terms.segment &&
            std::abs(grid.position[p] - terms.segment->position) < 0.5 * terms.segment->length)
            values[p] *= terms.segment->stiffness_factor;
    }
    return values;
}

VectorXd weighted_masses(const BeamStem& stem, const BeamTerms& terms, const BeamGrid& grid) {
    VectorXd values(grid.points() + 1);
    for (Index p = 0; p < grid.points(); ++p) {
        const double diameter = 1.0 + terms.taper * relative_place(grid.position[p], grid.length);
        values[p] = grid.weight[p] * stem.mass_per_length() * diameter * diameter;
    }
    values[grid.points()] = terms.tip_mass;
    return values;
}

VectorXd rest_curvature(const BeamTerms& terms, const BeamGrid& grid) {
    const VectorXd place = grid.position / grid.length;
    return (terms.base_curvature + (terms.tip_curvature - terms.base_curvature) * place.array())
        .matrix();
}

double support_acceleration(const std::optional<SupportVibration>& support, double time) {
    if (!support)
        return 0.0;
    const double omega = 2.0 * std::numbers::pi * support->frequency;
    return -support->amplitude * omega * omega * std::sin(omega * time + support->phase);
}

} // namespace

BeamModel::BeamModel(const BeamStem& stem, const BeamTerms& terms)
    : stem_(stem), terms_(terms),
      grid_(make_grid(stem.length, terms.clamp.has_value(), terms.segment)),
      rigidity_(rigidities(stem, terms, grid_)), point_mass_(weighted_masses(stem, terms, grid_)),
      curved_at_rest_(rest_curvature(terms, grid_)) {
    add_point_laws();
    if (terms_.second_mode)
        set_second_mode();
}

void BeamModel::set_second_mode() {
    const Index n = grid_.functions();
    const MatrixXd mass = mass_matrix().topLeftCorner(n, n);
    const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> modes(
        stiffness_matrix().topLeftCorner(n, n), mass);
    const double omega_squared = modes.eigenvalues()[1];
    second_stiffness_ =
        omega_squared * (std::pow(1.0 + terms_.second_mode->frequency_share, 2) - 1.0);
    second_damping_ = omega_squared * stem_.damping_time * (terms_.second_mode->loss_ratio - 1.0);
    second_mode_ = mass * modes.eigenvectors().col(1);
}

MatrixXd BeamModel::field_rows(const VectorXd& coefficients, const MatrixXd& functions) const {
    return functions * Eigen::Map<const MatrixXd>(coefficients.data(), grid_.functions(), fields());
}

BeamModel::Kinematics BeamModel::kinematics(const VectorXd& q) const {
    Kinematics at;
    at.slope = field_rows(q, grid_.slope);
    at.cosine = (1.0 - at.slope.rowwise().squaredNorm().array()).sqrt();
    at.along = -(at.slope.array().colwise() / at.cosine.array());
    return at;
}

BeamModel::Bending BeamModel::bending(const Kinematics& at, const VectorXd& q) const {
    const MatrixXd slope_rate = field_rows(q, grid_.curvature);
    const Eigen::ArrayXd c = at.cosine.array();
    const Eigen::ArrayXd denominator = c + c.square();
    const Eigen::ArrayXd product = (at.slope.array() * slope_rate.array()).rowwise().sum();
    const Eigen::ArrayXd turning = product / denominator; // c' = −turning (1 + c)
    Bending bent;
    bent.curvature = slope_rate + (at.slope.array().colwise() * turning).matrix();
    for (Index i = 0; i < fields(); ++i)
        for (Index j = 0; j < fields(); ++j) {
            const Eigen::ArrayXd u_i = at.slope.col(i);
            const Eigen::ArrayXd u_j = at.slope.col(j);
            const Eigen::ArrayXd turning_by_slope =
                slope_rate.col(j).array() / denominator +
                product * (1.0 + 2.0 * c) * u_j / (c * denominator.square());
            const double same = i == j ? 1.0 : 0.0;
            bent.by_slope.emplace_back(same * turning + u_i * turning_by_slope);
            bent.by_slope_rate.emplace_back(same + u_i * u_j / denominator);
        }
    return bent;
}

MatrixXd BeamModel::elastic_moments(const MatrixXd& curvatures) const {
    MatrixXd bent = curvatures;
    bent.col(0) -= curved_at_rest_;
    const Eigen::ArrayXd factor =
        rigidity_.array() * (1.0 + terms_.cubic_bending * bent.rowwise().squaredNorm().array());
    MatrixXd moments = bent.array().colwise() * factor;
    if (fields() == 2) {
        const double cosine = std::cos(2.0 * terms_.split_angle);
        const double sine = std::sin(2.0 * terms_.split_angle);
        const VectorXd split = 0.5 * terms_.stiffness_split * rigidity_;
        moments.col(0) += split.cwiseProduct(cosine * bent.col(0) + sine * bent.col(1));
        moments.col(1) += split.cwiseProduct(sine * bent.col(0) - cosine * bent.col(1));
    }
    return moments;
}

void BeamModel::add_inertia_and_loads(const Kinematics& at, const BeamState& state,
                                      VectorXd& sum) const {
    const MatrixXd turning = field_rows(state.v, grid_.slope);
    const MatrixXd spinning_up = field_rows(state.a, grid_.slope);
    const Eigen::ArrayXd c = at.cosine.array();
    const Eigen::ArrayXd cosine_rate = (at.along.array() * turning.array()).rowwise().sum();
    const Eigen::ArrayXd cosine_acceleration =
        -(turning.rowwise().squaredNorm().array() +
          (at.slope.array() * spinning_up.array()).rowwise().sum() + cosine_rate.square()) /
        c;
    const MatrixXd lateral_velocity = field_rows(state.v, grid_.deflection);
    const VectorXd axial_velocity = grid_.integral * cosine_rate.matrix();

    MatrixXd lateral = field_rows(state.a, grid_.deflection);
    lateral.col(0).array() +=
        support_acceleration(terms_.support, state.time) - terms_.transverse_gravity;
    lateral.array().colwise() *= point_mass_.array();
    VectorXd axial = grid_.integral * cosine_acceleration.matrix();
    axial.array() -= terms_.axial_gravity;
    axial.array() *= point_mass_.array();
    if (terms_.linear_drag != 0.0 || terms_.quadratic_drag != 0.0 || terms_.cubic_drag != 0.0 ||
        terms_.power_drag) {
        const Eigen::ArrayXd speed =
            (lateral_velocity.rowwise().squaredNorm().array() + axial_velocity.array().square())
                .sqrt()
                .head(grid_.points());
        Eigen::ArrayXd drag =
            terms_.linear_drag + (terms_.quadratic_drag + terms_.cubic_drag * speed) * speed;
        if (terms_.power_drag)
            drag += terms_.power_drag->coefficient * speed.pow(terms_.power_drag->exponent - 1.0);
        drag *= grid_.weight.array();
        lateral.topRows(grid_.points()).array() +=
            lateral_velocity.topRows(grid_.points()).array().colwise() * drag;
        axial.head(grid_.points()).array() += axial_velocity.head(grid_.points()).array() * drag;
    }
    if (terms_.air)
        add_air(state, lateral_velocity, lateral);
    const VectorXd above = grid_.integral.transpose() * axial;
    for (Index f = 0; f < fields(); ++f)
        sum.segment(f * grid_.functions(), grid_.functions()) +=
            grid_.deflection.transpose() * lateral.col(f) +
            grid_.slope.transpose() * above.cwiseProduct(at.along.col(f));
}

void BeamModel::add_air(const BeamState& state, const MatrixXd& velocity, MatrixXd& lateral) const {
    constexpr double density = 1.2; // kg/m³
    const AirAround& air = *terms_.air;
    const Index points = grid_.points();
    const Eigen::ArrayXd speed = velocity.col(0).head(points).array();
    const Eigen::ArrayXd place = field_rows(state.q, grid_.deflection).col(0).head(points).array();
    const Eigen::ArrayXd number =
        2.0 * std::numbers::pi / air.width *
            (place.square() + (speed / air.angular_frequency).square()).sqrt() +
        1e-9;
    const Eigen::ArrayXd mass = 0.25 * std::numbers::pi * density * air.width * air.width *
                                (air.still_mass + air.mass * number.pow(2.0 / 3.0));
    const Eigen::ArrayXd drag =
        0.5 * density * air.width * air.drag * number.pow(-1.0 / 3.0) * speed.abs();
    const Eigen::ArrayXd acceleration =
        field_rows(state.a, grid_.deflection).col(0).head(points).array();
    lateral.col(0).head(points).array() +=
        grid_.weight.array() * (mass * acceleration + drag * speed);
}

Eigen::ArrayXd BeamModel::bending_time(const VectorXd& squared_curvature) const {
    Eigen::ArrayXd time = stem_.damping_time + terms_.curvature_damping * squared_curvature.array();
    if (terms_.strain_loss) {
        const StrainLoss& loss = *terms_.strain_loss;
        time += loss.time * (squared_curvature.array().sqrt() / loss.curvature).pow(loss.power);
    }
    return time;
}

void BeamModel::add_bending(const Bending& bent, const MatrixXd& moments, VectorXd& sum) const {
    for (Index j = 0; j < fields(); ++j) {
        VectorXd on_slope = VectorXd::Zero(grid_.points());
        VectorXd on_slope_rate = VectorXd::Zero(grid_.points());
        for (Index i = 0; i < fields(); ++i) {
            const auto at = static_cast<std::size_t>(i * fields() + j);
            on_slope += moments.col(i).cwiseProduct(bent.by_slope[at]);
            on_slope_rate += moments.col(i).cwiseProduct(bent.by_slope_rate[at]);
        }
        sum.segment(j * grid_.functions(), grid_.functions()) +=
            grid_.slope.transpose() * on_slope.cwiseProduct(grid_.weight) +
            grid_.curvature.transpose() * on_slope_rate.cwiseProduct(grid_.weight);
    }
}

void BeamModel::add_clamp(const VectorXd& q, VectorXd& sum) const {
    if (!terms_.clamp)
        return;
    const double slope = q[0];
    if (!terms_.slip) // a slipping spring is a point law
        sum[0] += terms_.clamp->stiffness * std::asin(slope) / std::sqrt(1.0 - slope * slope);
    if (fields() == 2)
        sum[grid_.functions()] +=
            rigid_clamp * stem_.rigidity() / stem_.length * q[grid_.functions()];
}

void BeamModel::add_second_mode(const VectorXd& q, const VectorXd& v, VectorXd& sum) const {
    for (Index f = 0; f < fields() && second_mode_.size() > 0; ++f) {
        const double force =
            second_stiffness_ * second_coordinate(q, f) + second_damping_ * second_coordinate(v, f);
        sum.segment(f * grid_.functions(), grid_.functions()) += force * second_mode_;
    }
}

double BeamModel::second_coordinate(const VectorXd& all, Index field) const {
    return second_mode_.dot(all.segment(field * grid_.functions(), grid_.functions()));
}

VectorXd BeamModel::out_of_balance(const BeamState& state, double finger,
                                   const BranchStep& branches, BranchMoments* rates) const {
    VectorXd sum = -finger * finger_direction();
    const Kinematics at = kinematics(state.q);
    add_inertia_and_loads(at, state, sum);
    const Bending bent = bending(at, state.q);
    const MatrixXd turning = field_rows(state.v, grid_.slope);
    const MatrixXd bending_rate = field_rows(state.v, grid_.curvature);
    MatrixXd curvature_rate = MatrixXd::Zero(grid_.points(), fields());
    for (Index i = 0; i < fields(); ++i)
        for (Index j = 0; j < fields(); ++j) {
            const auto k = static_cast<std::size_t>(i * fields() + j);
            curvature_rate.col(i) += bent.by_slope[k].cwiseProduct(turning.col(j)) +
                                     bent.by_slope_rate[k].cwiseProduct(bending_rate.col(j));
        }
    const Eigen::ArrayXd viscosity =
        rigidity_.array() * bending_time(bent.curvature.rowwise().squaredNorm());
    MatrixXd moments = elastic_moments(bent.curvature);
    moments.array() += curvature_rate.array().colwise() * viscosity;
    for (std::size_t b = 0; b < terms_.branches.size(); ++b) {
        const RelaxingBranch& branch = terms_.branches[b];
        const MatrixXd driven =
            curvature_rate.array().colwise() * (branch.fraction * rigidity_.array());
        const Index first = static_cast<Index>(b) * fields();
        const MatrixXd now =
            (branches.predicted->middleCols(first, fields()) + branches.step * driven) /
            (1.0 + branches.step / branch.time);
        moments += now;
        if (rates != nullptr)
            rates->middleCols(first, fields()) = driven - now / branch.time;
    }
    add_bending(bent, moments, sum);
    add_clamp(state.q, sum);
    if (terms_.clamp)
        sum[0] += terms_.clamp->damping * state.v[0] / (1.0 - state.q[0] * state.q[0]);
    add_second_mode(state.q, state.v, sum);
    return sum;
}

BranchMoments BeamModel::held_branches(const VectorXd& q) const {
    const auto count = static_cast<Index>(terms_.branches.size());
    BranchMoments moments(grid_.points(), count * fields());
    MatrixXd bent = bending(kinematics(q), q).curvature;
    bent.col(0) -= curved_at_rest_;
    for (Index b = 0; b < count; ++b) {
        const RelaxingBranch& branch = terms_.branches[static_cast<std::size_t>(b)];
        moments.middleCols(b * fields(), fields()) =
            bent.array().colwise() * (branch.fraction * branch.held_share * rigidity_.array());
    }
    return moments;
}

VectorXd BeamModel::out_of_balance_at_rest(const VectorXd& q, double finger) const {
    const BranchMoments held = held_branches(q);
    BeamState state{q, VectorXd::Zero(freedoms()), VectorXd::Zero(freedoms()), 0.0};
    VectorXd sum = out_of_balance(state, finger, {&held, 0.0});
    // Neither a moving support nor dry friction nor the dispersion of the second mode belongs to
    // rest.
    VectorXd second = VectorXd::Zero(freedoms());
    add_second_mode(q, VectorXd::Zero(freedoms()), second);
    sum -= second;
    if (terms_.support)
        sum.head(grid_.functions()) -=
            grid_.deflection.transpose() * point_mass_ * support_acceleration(terms_.support, 0.0);
    for (const PointLaw& law : point_laws_)
        sum -= law.direction * law.force(law.direction.dot(q), 0.0);
    return sum;
}

VectorXd BeamModel::finger_direction() const {
    VectorXd direction = VectorXd::Zero(freedoms());
    direction.head(grid_.functions()) = grid_.deflection.bottomRows(1).transpose();
    return direction;
}

void BeamModel::add_slip() {
    VectorXd direction = VectorXd::Zero(freedoms());
    direction[0] = 1.0;
    struct Memory {
        double turn = 0.0;
        double moment = 0.0;
    };
    const auto memory = std::make_shared<Memory>();
    // The moment after a turn from the last one that was reached, in small parts.
    const auto moment_at = [memory, stiffness = terms_.clamp->stiffness,
                            slip = *terms_.slip](double turn) {
        constexpr int parts = 8;
        const double part = (turn - memory->turn) / parts;
        const auto slope = [&](double moment) {
            return moment * part > 0.0
                       ? stiffness * (1.0 - slip.share * std::pow(std::abs(moment), slip.power))
                       : stiffness;
        };
        double moment = memory->moment;
        for (int k = 0; k < parts; ++k)
            moment += part * slope(moment + 0.5 * part * slope(moment));
        return moment;
    };
    point_laws_.push_back({direction,
                           [moment_at](double slope, double) {
                               return -moment_at(std::asin(slope)) / std::sqrt(1.0 - slope * slope);
                           },
                           [moment_at, memory](double slope) {
                               memory->moment = moment_at(std::asin(slope));
                               memory->turn = std::asin(slope);
                           }});
}

void BeamModel::add_point_laws() {
    if (terms_.slip)
        add_slip();
    if (terms_.clamp && terms_.clamp->friction_moment != 0.0) {
        const TurningClamp clamp = *terms_.clamp;
        VectorXd direction = VectorXd::Zero(freedoms());
        direction[0] = 1.0;
        point_laws_.push_back({direction, [clamp](double slope, double rate) {
                                   const double cosine = std::sqrt(1.0 - slope * slope);
                                   return -clamp.friction_moment / cosine *
                                          std::tanh(rate / cosine / clamp.friction_rate);
                               }});
    }
    if (terms_.magnet)
        point_laws_.push_back({finger_direction(), [magnet = *terms_.magnet](double y, double) {
                                   const double z = y / magnet.reach;
                                   return -magnet.force * z * std::exp(0.5 * (1.0 - z * z));
                               }});
    if (terms_.cable)
        point_laws_.push_back({finger_direction(), [cable = *terms_.cable](double, double rate) {
                                   const double v = rate / cable.speed;
                                   return -2.0 * cable.force * v / (1.0 + v * v);
                               }});
    if (terms_.stop) {
        VectorXd direction = VectorXd::Zero(freedoms());
        direction.head(grid_.functions()) = grid_.deflection.topRows(grid_.points()).transpose() *
                                            grid_.interpolation(terms_.stop->height);
        point_laws_.push_back({direction, [stop = *terms_.stop](double y, double rate) {
                                   const double depth = -stop.gap - y;
                                   return depth <= 0.0 ? 0.0
                                                       : std::max(0.0, stop.stiffness * depth -
                                                                           stop.damping * rate);
                               }});
    }
}

} // namespace culm::beam
