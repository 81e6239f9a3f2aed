// SPDX-License-Identifier: BSD-3-Clause
#include "run/explicit_lanes.hpp"

#include "core/lanes.hpp"
#include "integrate/statics.hpp"
#include "integrate/velocity_verlet.hpp"
#include "physics/energy.hpp"
#include "run/recorder.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>

#include <fmt/core.h>

namespace culm::run {
namespace {

using core::Lanes;

/// Steps between two looks at the heartbeat: about a millisecond for 56 spheres.
constexpr std::int64_t steps_per_beat = 1000;
/// A released stem only loses energy. One that has gained this share of what it was released with
/// is unstable: the step is too large. The deflection alone would not tell, because an unstable
/// axial mode saturates in a crumpled chain whose tip looks harmless. Velocity Verlet's own energy
/// error stays far below at any stable step.
constexpr double unstable_energy_gain = 0.05;

/// The specification in lane `lane`; lanes beyond the cases repeat the first.
const CaseSpec& in_lane(std::span<const CaseSpec> specs, std::size_t lane) {
    return specs[lane < specs.size() ? lane : 0];
}

/// One number of every lane's stem.
Lanes gathered(std::span<const CaseSpec> specs, double physics::StemParameters<double>::*member) {
    return Lanes([&](auto lane) { return in_lane(specs, lane).stem.*member; });
}

physics::StemParameters<Lanes> gathered_stems(std::span<const CaseSpec> specs) {
    using Stem = physics::StemParameters<double>;
    physics::StemParameters<Lanes> stems;
    stems.sphere_count = specs.front().stem.sphere_count;
    stems.sphere_diameter = gathered(specs, &Stem::sphere_diameter);
    stems.bond_length = gathered(specs, &Stem::bond_length);
    stems.bond_outer_diameter = gathered(specs, &Stem::bond_outer_diameter);
    stems.bond_inner_diameter = gathered(specs, &Stem::bond_inner_diameter);
    stems.density = gathered(specs, &Stem::density);
    stems.poissons_ratio = gathered(specs, &Stem::poissons_ratio);
    stems.bond_youngs_modulus = gathered(specs, &Stem::bond_youngs_modulus);
    stems.bond_damping = gathered(specs, &Stem::bond_damping);
    stems.axial_acceleration_of_gravity = gathered(specs, &Stem::axial_acceleration_of_gravity);
    return stems;
}

/// The batch while it runs.
template <int Dim>
class LaneBatch {
  public:
    explicit LaneBatch(std::span<const CaseSpec> specs) : specs_(specs), failures_(specs.size()) {
        for (const CaseSpec& spec : specs)
            recorders_.emplace_back(spec);
    }

    [[nodiscard]] std::vector<CaseOutcome> run(const Heartbeat& heartbeat) {
        const auto start = std::chrono::steady_clock::now();
        const CaseSpec& first = specs_.front();
        const physics::Chain<Dim, Lanes> chain(gathered_stems(specs_), first.law);
        integrate::VelocityVerlet<Dim, Lanes> verlet(chain, released_states(),
                                                     first.integrator.timestep);
        const std::int64_t steps_per_sample =
            std::llround(first.sample_interval / first.integrator.timestep);
        const std::size_t samples = first.sample_count();

        released_energy_ = stored_energy(chain, verlet);
        record(0, verlet);
        for (std::size_t sample = 1; sample < samples && any_lane_runs(); ++sample) {
            for (std::int64_t done = 0; done < steps_per_sample; done += steps_per_beat) {
                verlet.advance(std::min(steps_per_beat, steps_per_sample - done));
                if (heartbeat && !heartbeat())
                    throw Abandoned{};
            }
            check_stability(stored_energy(chain, verlet), sample);
            record(sample, verlet);
        }
        const double wall =
            std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        return outcomes(static_cast<std::int64_t>(samples - 1) * steps_per_sample, wall);
    }

  private:
    /// The equilibria that the lanes are released from; a lane without one fails here and goes on
    /// with the first lane's state, or at rest.
    [[nodiscard]] std::vector<Lanes> released_states() {
        std::vector<std::vector<double>> states;
        for (std::size_t lane = 0; lane < specs_.size(); ++lane) {
            const physics::Chain<Dim, double> chain(specs_[lane].stem, specs_[lane].law);
            try {
                states.push_back(
                    integrate::deflected_equilibrium(chain, specs_[lane].tip_deflection).state);
            } catch (const core::NumericalError& error) {
                failures_[lane] = CaseFailure{error.kind(), error.what()};
                states.push_back(chain.straight_state());
            }
        }
        std::vector<Lanes> packed(states.front().size());
        for (std::size_t k = 0; k < packed.size(); ++k)
            packed[k] =
                Lanes([&](auto lane) { return states[lane < states.size() ? lane : 0][k]; });
        return packed;
    }

    void record(std::size_t sample, const integrate::VelocityVerlet<Dim, Lanes>& verlet) {
        const int tip = specs_.front().stem.sphere_count - 1;
        for (std::size_t lane = 0; lane < specs_.size(); ++lane) {
            if (failures_[lane])
                continue;
            positions_.clear();
            for (int i = recorders_[lane].first_watched_sphere(); i <= tip; ++i)
                for (int d = 0; d < Dim; ++d)
                    positions_.push_back(verlet.position(i)[d][lane]);
            recorders_[lane].record(sample, positions_);
        }
    }

    /// Stored energy above that of the straight chain at rest, J.
    [[nodiscard]] static Lanes stored_energy(const physics::Chain<Dim, Lanes>& chain,
                                             const integrate::VelocityVerlet<Dim, Lanes>& verlet) {
        return physics::chain_energy(chain, verlet.state().data()).stored() -
               physics::chain_energy(chain, chain.straight_state().data()).stored();
    }

    /// Fails the lanes whose energy has grown or is not a number.
    void check_stability(const Lanes& energy, std::size_t sample) {
        for (std::size_t lane = 0; lane < specs_.size(); ++lane) {
            if (failures_[lane] ||
                energy[lane] <= (1.0 + unstable_energy_gain) * std::abs(released_energy_[lane]))
                continue;
            const CaseSpec& spec = specs_[lane];
            failures_[lane] = CaseFailure{
                core::FailureKind::Instability,
                fmt::format("the motion gained energy ({:.3g} J at t = {:.6g} s, released with "
                            "{:.3g} J): the time step of {:.4g} s is above the largest stable one, "
                            "{:.4g} s",
                            double(energy[lane]),
                            static_cast<double>(sample) * spec.sample_interval,
                            double(released_energy_[lane]), spec.integrator.timestep,
                            largest_stable_timestep(spec))};
        }
    }

    [[nodiscard]] bool any_lane_runs() const {
        return std::any_of(failures_.begin(), failures_.end(),
                           [](const auto& failure) { return !failure.has_value(); });
    }

    [[nodiscard]] std::vector<CaseOutcome> outcomes(std::int64_t steps, double wall_seconds) {
        std::vector<CaseOutcome> out;
        for (std::size_t lane = 0; lane < specs_.size(); ++lane) {
            if (failures_[lane]) {
                out.emplace_back(*failures_[lane]);
                continue;
            }
            CaseResult& result = recorders_[lane].result();
            result.work.steps = steps;
            result.work.rhs_evaluations = steps + 1;
            result.wall_seconds = wall_seconds / static_cast<double>(specs_.size());
            out.emplace_back(std::move(result));
        }
        return out;
    }

    std::span<const CaseSpec> specs_;
    std::vector<Recorder> recorders_;
    std::vector<std::optional<CaseFailure>> failures_;
    std::vector<double> positions_;
    Lanes released_energy_ = 0.0;
};

} // namespace

std::size_t lanes_per_batch() {
    return core::lane_count;
}

bool can_share_lanes(const CaseSpec& a, const CaseSpec& b) {
    const auto same_law = [](const physics::BondLawOptions& p, const physics::BondLawOptions& q) {
        return p.shear_damping_torque == q.shear_damping_torque &&
               p.lever_arms_follow_bond == q.lever_arms_follow_bond &&
               p.damping_factor == q.damping_factor && p.damping_inertia == q.damping_inertia;
    };
    return a.integrator.method == IntegrationMethod::Explicit &&
           b.integrator.method == IntegrationMethod::Explicit &&
           a.stem.sphere_count == b.stem.sphere_count && a.dimensions == b.dimensions &&
           same_law(a.law, b.law) && a.integrator.timestep == b.integrator.timestep &&
           a.duration == b.duration && a.sample_interval == b.sample_interval;
}

std::vector<CaseOutcome> simulate_explicit_lanes(std::span<const CaseSpec> specs,
                                                 const Heartbeat& heartbeat) {
    return specs.front().dimensions == 2 ? LaneBatch<2>(specs).run(heartbeat)
                                         : LaneBatch<3>(specs).run(heartbeat);
}

} // namespace culm::run
