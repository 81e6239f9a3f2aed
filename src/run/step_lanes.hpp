// SPDX-License-Identifier: BSD-3-Clause
// One stem in every SIMD lane, each lane with its own time step.
#pragma once

#include "core/lanes.hpp"
#include "integrate/statics.hpp"
#include "integrate/velocity_verlet.hpp"
#include "physics/energy.hpp"
#include "run/case_spec.hpp"
#include "run/lane_packing.hpp"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace culm::run {

/// Lanes advance by one common step h₀, so a lane's own step h is obtained by a change of the
/// unit of time: a chain of modulus Y·(h/h₀)² (and gravity g·(h/h₀)²) stepped by h₀ has the same
/// positions as one of modulus Y stepped by h. That is exact, because every damping
/// coefficient 2β√(inertia·stiffness) scales as a stiffness times a time.
template <int Dim>
class StepLanes {
    using Lanes = core::Lanes;

  public:
    /// Releases the case's stem from its deflection with 1 … core::lane_count steps (s); the last
    /// one fills the remaining lanes. Throws core::NumericalError(StaticFailed).
    StepLanes(const CaseSpec& spec, std::span<const double> steps)
        : used_(steps.size()), common_step_(steps.front()),
          steps_([&](auto lane) { return steps[lane < steps.size() ? lane : steps.size() - 1]; }),
          chain_(scaled_stems(spec), spec.law), verlet_(chain_, scaled_states(spec), common_step_),
          straight_(physics::chain_energy(chain_, chain_.straight_state().data()).stored()),
          released_(stored_energy()) {}

    StepLanes(const StepLanes&) = delete; // the integrator refers to the chain
    StepLanes& operator=(const StepLanes&) = delete;

    /// `count` steps in every lane.
    void advance(std::int64_t count) { verlet_.advance(count); }

    /// Lateral position of the tip in a lane, m.
    [[nodiscard]] double tip(std::size_t lane) const {
        return verlet_.position(chain_.layout().sphere_count() - 1)[1][lane];
    }

    /// Whether the motion of each lane has gained more than this share of its initial energy, or
    /// its energy is not a number. A released stem only loses energy.
    [[nodiscard]] std::vector<bool> have_gained(double share) const {
        const Lanes energy = stored_energy();
        std::vector<bool> gained(used_);
        for (std::size_t lane = 0; lane < used_; ++lane)
            gained[lane] = !(energy[lane] <= (1.0 + share) * std::abs(released_[lane]));
        return gained;
    }

  private:
    [[nodiscard]] Lanes unit_of_time() const { return steps_ / Lanes(common_step_); }

    [[nodiscard]] physics::StemParameters<Lanes> scaled_stems(const CaseSpec& spec) const {
        const Lanes square = unit_of_time() * unit_of_time();
        physics::StemParameters<Lanes> stems = packed_stems<Lanes>({&spec, 1});
        stems.bond_youngs_modulus *= square;
        stems.axial_acceleration_of_gravity *= square;
        return stems;
    }

    /// The same shape, held at the tip, in every lane; forces and moments scale as the modulus.
    [[nodiscard]] std::vector<Lanes> scaled_states(const CaseSpec& spec) const {
        const physics::Chain<Dim, double> chain(spec.stem, spec.law);
        const std::vector<double> state =
            integrate::deflected_equilibrium(chain, spec.tip_deflection).state;
        const Lanes square = unit_of_time() * unit_of_time();
        const std::size_t first_history = chain_.layout().bond_offset(0);
        std::vector<Lanes> states(state.begin(), state.end());
        for (std::size_t k = first_history; k < states.size(); ++k)
            states[k] *= square;
        return states;
    }

    /// Energy above that of the straight chain at rest, in each lane's own unit of time.
    [[nodiscard]] Lanes stored_energy() const {
        return physics::chain_energy(chain_, verlet_.state().data()).stored() - straight_;
    }

    std::size_t used_;
    double common_step_; ///< h₀, s
    Lanes steps_;        ///< h of each lane, s
    physics::Chain<Dim, Lanes> chain_;
    integrate::VelocityVerlet<Dim, Lanes> verlet_;
    Lanes straight_; ///< energy of the straight chain
    Lanes released_; ///< energy at the release
};

} // namespace culm::run
