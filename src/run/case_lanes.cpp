// SPDX-License-Identifier: BSD-3-Clause
#include "run/case_lanes.hpp"

#include "core/cantilever.hpp"
#include "integrate/statics.hpp"
#include "physics/effects/stem_scales.hpp"
#include "run/case_model.hpp"

#include <cmath>
#include <numbers>

namespace culm::run {
namespace {

/// One number of every lane's stem.
template <class T>
T packed(std::span<const CaseSpec> specs, double physics::StemParameters<double>::*member) {
    return core::by_lane<T>([&](std::size_t lane) { return in_lane(specs, lane).stem.*member; });
}

/// A chain that is pulled aside at the tip. For the first mode alone, the parts 12/β⁴ of modes 2
/// and 3 in the shape of a pulled cantilever are taken back by the forces of their inertia.
template <int Dim>
integrate::StaticState held_state(const physics::Chain<Dim, double>& chain, const CaseSpec& spec) {
    double tip = spec.tip_deflection;
    std::vector<double> loads;
    if (spec.release == Release::FirstMode)
        loads.assign(static_cast<std::size_t>(spec.stem.sphere_count), 0.0);
    for (std::size_t mode = 1; !loads.empty() && mode < 3; ++mode) {
        const double root = core::cantilever_roots[mode];
        const double part = -12.0 / std::pow(root, 4) * spec.tip_deflection;
        const double omega = 2.0 * std::numbers::pi * physics::first_frequency(spec.stem) *
                             std::pow(root / core::cantilever_roots.front(), 2);
        tip += part;
        for (std::size_t i = 0; i < loads.size(); ++i) {
            const double place = static_cast<double>(i) / static_cast<double>(loads.size() - 1);
            loads[i] += part * omega * omega * chain.sphere_inertia(static_cast<int>(i)).mass *
                        core::cantilever_shape(mode, place).value;
        }
    }
    return integrate::deflected_equilibrium(chain, tip, loads);
}

} // namespace

template <class T>
physics::StemParameters<T> packed_stems(std::span<const CaseSpec> specs) {
    using Stem = physics::StemParameters<double>;
    physics::StemParameters<T> stems;
    stems.sphere_count = specs.front().stem.sphere_count;
    stems.sphere_diameter = packed<T>(specs, &Stem::sphere_diameter);
    stems.bond_length = packed<T>(specs, &Stem::bond_length);
    stems.bond_outer_diameter = packed<T>(specs, &Stem::bond_outer_diameter);
    stems.bond_inner_diameter = packed<T>(specs, &Stem::bond_inner_diameter);
    stems.density = packed<T>(specs, &Stem::density);
    stems.poissons_ratio = packed<T>(specs, &Stem::poissons_ratio);
    stems.bond_youngs_modulus = packed<T>(specs, &Stem::bond_youngs_modulus);
    stems.bond_damping = packed<T>(specs, &Stem::bond_damping);
    stems.axial_acceleration_of_gravity = packed<T>(specs, &Stem::axial_acceleration_of_gravity);
    return stems;
}

template <int Dim, class T>
ReleasedState<T> released_lanes(std::span<const CaseSpec> specs) {
    ReleasedState<T> released;
    released.failures.resize(specs.size());
    std::vector<CaseModel> models;
    std::vector<std::vector<double>> states;
    for (std::size_t lane = 0; lane < specs.size(); ++lane) {
        const CaseSpec& spec = specs[lane];
        CaseModel& model = models.emplace_back(case_model(spec));
        const physics::Chain<Dim, double> chain(spec.stem.sphere_count, model.chain, spec.law);
        if (spec.release == Release::HeldStraight) {
            states.push_back(chain.held_straight_state());
            continue;
        }
        try {
            integrate::StaticState held = held_state(chain, spec);
            states.push_back(std::move(held.state));
            if (model.chain.release)
                model.chain.release->holding_force = held.holding_force;
        } catch (const core::NumericalError& error) {
            released.failures[lane] = CaseFailure{error.kind(), error.what()};
            states.push_back(chain.straight_state());
        }
    }
    released.model = packed_model<T>(models);
    released.state.resize(states.front().size());
    for (std::size_t k = 0; k < released.state.size(); ++k)
        released.state[k] = core::by_lane<T>(
            [&](std::size_t lane) { return states[lane < states.size() ? lane : 0][k]; });
    return released;
}

template physics::StemParameters<double> packed_stems(std::span<const CaseSpec>);
template physics::StemParameters<core::Lanes> packed_stems(std::span<const CaseSpec>);
template ReleasedState<double> released_lanes<2, double>(std::span<const CaseSpec>);
template ReleasedState<double> released_lanes<3, double>(std::span<const CaseSpec>);
template ReleasedState<core::Lanes> released_lanes<2, core::Lanes>(std::span<const CaseSpec>);
template ReleasedState<core::Lanes> released_lanes<3, core::Lanes>(std::span<const CaseSpec>);

} // namespace culm::run
