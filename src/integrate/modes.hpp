// SPDX-License-Identifier: BSD-3-Clause
// The chain linearised about a state at rest, and how it vibrates: frequencies, decay, and the
// largest stable explicit step.
// physics::first_frequency() is the frequency of the slender beam; run/modes.hpp applies both to a
// case. There is no other code for frequencies of the model.
#pragma once

#include "physics/chain.hpp"

#include <cstddef>
#include <vector>

#include <Eigen/Core>

namespace culm::integrate {

/// M ü + C u̇ + K u = 0 for small displacements and rotations u of the moving spheres.
/// Each sphere contributes its Dim displacements, then its 1 (planar) or 3 rotations, from the
/// clamp to the tip. Forces from bond histories are part of the stiffness: the histories'
/// increments are linear in u. K and C need not be symmetric (law "schramm2019").
struct LinearisedChain {
    Eigen::VectorXd mass;      ///< (dof), diagonal of M, kg and kg m²
    Eigen::MatrixXd damping;   ///< (dof, dof)
    Eigen::MatrixXd stiffness; ///< (dof, dof)
};

/// Linearises about `state`, which must be at rest. The derivatives are exact. If an effect lets
/// the clamp turn, its rotation is the first degree of freedom. Maxwell branches count as relaxed.
template <int Dim>
[[nodiscard]] LinearisedChain linearise(const physics::Chain<Dim, double>& chain,
                                        const std::vector<double>& state);

/// The transverse motion (lateral displacement and rotation about z) of the straight planar chain,
/// which does not couple with the axial one.
[[nodiscard]] LinearisedChain linearise_transverse(const physics::StemParameters<double>& stem,
                                                   const physics::BondLawOptions& law);

/// The same of a chain with effects, the clamp's rotation included if it turns. `chain` lies in the
/// plane.
[[nodiscard]] LinearisedChain linearise_transverse(const physics::Chain<2, double>& chain);

/// The axial motion of the straight planar chain.
[[nodiscard]] LinearisedChain linearise_axial(const physics::StemParameters<double>& stem,
                                              const physics::BondLawOptions& law);

/// One vibration mode.
struct VibrationMode {
    double frequency;       ///< Im λ/2π, Hz: b2 of Eq. 1
    double decay_rate;      ///< Re λ, 1/s: b1 of Eq. 1, negative
    double decay_per_cycle; ///< decay_rate/frequency: b1 in normalised time

    /// ζ of decay_per_cycle = −2πζ/√(1 − ζ²).
    [[nodiscard]] double damping_ratio() const;
    /// The frequency without damping, Hz: frequency/√(1 − ζ²).
    [[nodiscard]] double natural_frequency() const;
};

/// The vibrating modes (complex pairs), slowest first, `count` of them at most. Each of a few modes
/// is found by Newton's method on (λ²M + λC + K) u = 0 (inverse iteration: Ruhe 1973, SIAM J.
/// Numer. Anal. 10:674) from a mode without damping. If this finds no vibration near an undamped
/// mode, for example because damping is nearly aperiodic, all modes are computed, at a much higher
/// cost.
[[nodiscard]] std::vector<VibrationMode> vibration_modes(const LinearisedChain& chain,
                                                         std::size_t count);

/// The first of transverse_modes() to first order in the damping, by inverse iteration, which costs
/// much less than all modes: its frequency is the natural one. NaN if the stiffness is singular or
/// the chain leans further.
[[nodiscard]] VibrationMode lightly_damped_mode(const physics::Chain<2, double>& chain);

/// The largest step (s) for which velocity Verlet, with damping evaluated from the half-step
/// velocity, is stable for the linearised chain: the one-step map's spectral radius is 1 there.
[[nodiscard]] double largest_stable_step(const LinearisedChain& chain);

/// The slowest transverse modes of a planar chain with effects, at most `count`; none if it does
/// not vibrate. Effects are linearised about the straight line, so that quadratic drag has no
/// influence. Maxwell branches stiffen all modes alike, by the factor at the first mode's
/// frequency.
[[nodiscard]] std::vector<VibrationMode> transverse_modes(const physics::Chain<2, double>& chain,
                                                          std::size_t count);

} // namespace culm::integrate
