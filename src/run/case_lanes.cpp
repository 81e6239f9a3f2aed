// SPDX-License-Identifier: BSD-3-Clause
#include "run/case_lanes.hpp"

#include "core/cantilever.hpp"
#include "integrate/statics.hpp"
#include "physics/effects/stem_scales.hpp"
#include "run/case_model.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace culm::run {
namespace {

/// One number of every lane's stem.
template <class T>
T packed(std::span<const CaseSpec> specs, double physics::StemParameters<double>::*member) {
    return core::by_lane<T>([&](std::size_t lane) { return in_lane(specs, lane).stem.*member; });
}

/// A chain that is pulled aside at the tip and has higher modes: each is held by the forces of its
/// inertia, and its speed is added.
template <int Dim>
integrate::StaticState released_state(const physics::Chain<Dim, double>& chain,
                                      const CaseSpec& spec) {
    const auto& modes = spec.released_modes;
    double tip = spec.tip_deflection;
    std::vector<double> loads;
    const auto spheres = static_cast<std::size_t>(spec.stem.sphere_count);
    const auto shape = [&](std::size_t k, std::size_t sphere) {
        return core::cantilever_shape(k + 1, static_cast<double>(sphere) /
                                                 static_cast<double>(spheres - 1));
    };
    if (std::ranges::any_of(modes, [](const auto& mode) { return mode.deflection != 0.0; }))
        loads.assign(spheres, 0.0);
    for (std::size_t k = 0; k < modes.size(); ++k) {
        tip += modes[k].deflection;
        const double omega =
            2.0 * std::numbers::pi * physics::first_frequency(spec.stem) *
            std::pow(core::cantilever_roots[k + 1] / core::cantilever_roots.front(), 2);
        for (std::size_t i = 0; i < loads.size(); ++i)
            loads[i] += modes[k].deflection * omega * omega *
                        chain.sphere_inertia(static_cast<int>(i)).mass * shape(k, i).value;
    }
    integrate::StaticState held = integrate::deflected_equilibrium(chain, tip, loads);
    for (std::size_t k = 0; k < modes.size(); ++k)
        for (std::size_t i = 1; i < spheres && modes[k].speed != 0.0; ++i) {
            auto sphere = chain.layout().sphere(held.state.data(), static_cast<int>(i));
            const core::ModeShape at = shape(k, i);
            sphere.velocity[1] += modes[k].speed * at.value;
            sphere.spin[physics::bending_axis<Dim>] +=
                modes[k].speed * at.slope / spec.stem.free_length();
            chain.layout().set_sphere(held.state.data(), static_cast<int>(i), sphere);
        }
    return held;
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
            integrate::StaticState held = released_state(chain, spec);
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
