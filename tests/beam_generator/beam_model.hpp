// SPDX-License-Identifier: BSD-3-Clause
// The equations of motion of a slender, inextensible, geometrically exact beam.
#pragma once

#include "beam_generator/beam_grid.hpp"
#include "beam_generator/beam_stem.hpp"
#include "beam_generator/beam_terms.hpp"

#include <functional>
#include <vector>

#include <Eigen/Core>

namespace culm::beam {

/// Generalised coordinates, velocities and accelerations, (freedoms) each; `time` in s from the
/// release.
struct BeamState {
    Eigen::VectorXd q;
    Eigen::VectorXd v;
    Eigen::VectorXd a;
    double time = 0.0;
};

/// A force law of one scalar z = direction · q and its rate, which acts on that scalar. May be
/// stiff, but must not grow with z or its rate.
struct PointLaw {
    Eigen::VectorXd direction; ///< (freedoms)
    std::function<double(double z, double rate)> force;
    std::function<void(double z)> arrive = {}; ///< z is reached: of a law with a memory
};

/// Moments of the relaxing branches at every point, (P, fields · branches), N m.
using BranchMoments = Eigen::MatrixXd;

/// How the branches' moments follow the curvature's rate in the step of an integrator that is
/// being taken: q = predicted + step · q̇.
struct BranchStep {
    const BranchMoments* predicted = nullptr;
    double step = 0.0;
};

/// The tangent of the stem's line is t = (√(1−u²−w²), u, w), with the slopes u toward the pull and
/// w across it as the unknown fields: deflections are their integrals, linear in the unknowns, and
/// the stem cannot stretch. Bending is that of Kirchhoff's rod without twist: the components of
/// t' in the normals that the smallest rotation from the stem's axis to t carries along. Galerkin's
/// method with the functions of BeamGrid; the fields' coefficients follow one after the other.
/// The model shares only the physics with the chain of spheres.
class BeamModel {
  public:
    BeamModel(const BeamStem& stem, const BeamTerms& terms);

    [[nodiscard]] const BeamStem& stem() const { return stem_; }
    [[nodiscard]] const BeamTerms& terms() const { return terms_; }
    [[nodiscard]] const BeamGrid& grid() const { return grid_; }
    [[nodiscard]] Eigen::Index fields() const { return terms_.is_spatial ? 2 : 1; }
    [[nodiscard]] Eigen::Index freedoms() const { return fields() * grid_.functions(); }

    /// Inertia and inner forces less outer ones, (freedoms); zero in motion. The finger's force is
    /// `finger` times finger_direction(); point laws are omitted. `rates` (if not null)
    /// gets the branches' q̇.
    [[nodiscard]] Eigen::VectorXd out_of_balance(const BeamState& state, double finger,
                                                 const BranchStep& branches,
                                                 BranchMoments* rates = nullptr) const;
    /// The same at rest, with point laws and the moments of the branches after a long hold.
    [[nodiscard]] Eigen::VectorXd out_of_balance_at_rest(const Eigen::VectorXd& q,
                                                         double finger) const;
    /// Moments of the branches at the release.
    [[nodiscard]] BranchMoments held_branches(const Eigen::VectorXd& q) const;

    /// Derivative of the tip's deflection by the coordinates.
    [[nodiscard]] Eigen::VectorXd finger_direction() const;
    [[nodiscard]] const std::vector<PointLaw>& point_laws() const { return point_laws_; }

    /// Mass, damping and stiffness of small motions about the straight stem, (freedoms, freedoms).
    /// `branch_step`: a step of the branches, s, whose stiffness is added to the damping. The
    /// damping by curvature is that at the coordinates `q`.
    [[nodiscard]] Eigen::MatrixXd mass_matrix() const;
    [[nodiscard]] Eigen::MatrixXd damping_matrix(double branch_step,
                                                 const Eigen::VectorXd& q) const;
    [[nodiscard]] Eigen::MatrixXd stiffness_matrix() const;

    /// Kinetic energy, bending energy and that of the clamp's spring and gravity, J.
    [[nodiscard]] double energy(const Eigen::VectorXd& q, const Eigen::VectorXd& v) const;

  private:
    /// The stem's line at the points.
    struct Kinematics {
        Eigen::MatrixXd slope;  ///< (P, fields): u and w
        Eigen::VectorXd cosine; ///< (P): axial component of the tangent
        Eigen::MatrixXd along;  ///< (P, fields): −u/c, derivative of the cosine by the slope
    };
    /// Curvatures and their derivatives: ∂κ_i/∂slope_j and ∂κ_i/∂(slope_j)'.
    struct Bending {
        Eigen::MatrixXd curvature;                  ///< (P, fields), 1/m
        std::vector<Eigen::VectorXd> by_slope;      ///< (fields²), i · fields + j
        std::vector<Eigen::VectorXd> by_slope_rate; ///< (fields²)
    };
    [[nodiscard]] Kinematics kinematics(const Eigen::VectorXd& q) const;
    [[nodiscard]] Bending bending(const Kinematics& at, const Eigen::VectorXd& q) const;
    /// Elastic moments (P, fields) of the curvatures less those at rest.
    [[nodiscard]] Eigen::MatrixXd elastic_moments(const Eigen::MatrixXd& curvatures) const;
    [[nodiscard]] Eigen::MatrixXd field_rows(const Eigen::VectorXd& coefficients,
                                             const Eigen::MatrixXd& functions) const;
    void add_inertia_and_loads(const Kinematics& at, const BeamState& state,
                               Eigen::VectorXd& sum) const;
    void add_bending(const Bending& bent, const Eigen::MatrixXd& moments,
                     Eigen::VectorXd& sum) const;
    void add_clamp(const Eigen::VectorXd& q, Eigen::VectorXd& sum) const;
    void add_point_laws();
    void add_slip();
    /// Air that moves with the points and its drag; `lateral` (P + 1, fields) is a sum of forces.
    void add_air(const BeamState& state, const Eigen::MatrixXd& velocity,
                 Eigen::MatrixXd& lateral) const;
    /// Damping time of the bends κ², (P).
    [[nodiscard]] Eigen::ArrayXd bending_time(const Eigen::VectorXd& squared_curvature) const;
    void set_second_mode();
    /// mᵀq or mᵀv of a field.
    [[nodiscard]] double second_coordinate(const Eigen::VectorXd& all, Eigen::Index field) const;
    void add_second_mode(const Eigen::VectorXd& q, const Eigen::VectorXd& v,
                         Eigen::VectorXd& sum) const;

    BeamStem stem_;
    BeamTerms terms_;
    BeamGrid grid_;
    Eigen::VectorXd rigidity_;       ///< (P), N m²
    Eigen::VectorXd point_mass_;     ///< (P + 1), weighted; the last one is the tip's, kg
    Eigen::VectorXd curved_at_rest_; ///< (P), 1/m
    std::vector<PointLaw> point_laws_;
    /// A spring and a dashpot on m = Mφ, φ the second mode of norm φᵀMφ = 1: forces −m (k mᵀq +
    /// c mᵀv) in each field. Empty without BeamTerms::second_mode.
    Eigen::VectorXd second_mode_;
    double second_stiffness_ = 0.0; ///< k, 1/s²
    double second_damping_ = 0.0;   ///< c, 1/s
};

} // namespace culm::beam
