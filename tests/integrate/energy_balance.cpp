// SPDX-License-Identifier: BSD-3-Clause
// Stored plus dissipated energy of a released stem.
#include "integrate/implicit.hpp"
#include "integrate/statics.hpp"
#include "physics/energy.hpp"
#include "support/dissipated_power.hpp"
#include "support/integrate_implicit.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace culm::integrate {
namespace {

/// ∫ power dt over unevenly spaced samples: a parabola through each three neighbours.
double integral(const std::vector<double>& times, const std::vector<double>& power) {
    double sum = 0.0;
    std::size_t k = 0;
    for (; k + 2 < times.size(); k += 2) {
        const double h0 = times[k + 1] - times[k];
        const double h1 = times[k + 2] - times[k + 1];
        sum += (h0 + h1) / 6.0 *
               ((2.0 - h1 / h0) * power[k] + (h0 + h1) * (h0 + h1) / (h0 * h1) * power[k + 1] +
                (2.0 - h0 / h1) * power[k + 2]);
    }
    if (k + 1 < times.size())
        sum += 0.5 * (times[k + 1] - times[k]) * (power[k] + power[k + 1]);
    return sum;
}

TEST(ReleasedStem, ConservesStoredPlusDissipatedEnergy) {
    for (const auto& law : {physics::consistent_law(), physics::schramm2019_law()}) {
        physics::StemParameters<double> stem;
        stem.sphere_count = 20;
        stem.bond_damping = 20.0;
        stem.axial_acceleration_of_gravity = -9.81;
        const physics::Chain<2, double> chain(stem, law);
        auto state = deflected_equilibrium(chain, 5e-3).state;
        const double initial = physics::stored_energy(chain, state.data());
        const double rest = physics::stored_energy(chain, chain.straight_state().data());
        std::vector<double> times;
        std::vector<double> power;
        double stored = 0.0;
        ImplicitOptions options;
        options.relative_tolerance = 1e-9;
        options.rate_error_weight = 1.0;
        integrate_implicit(
            chain, state, cantilever_scales(stem, 5e-3), 4e-3,
            [&](double time, std::span<const double> at) {
                times.push_back(time);
                power.push_back(tests::dissipated_power(chain, at.data()));
                stored = physics::stored_energy(chain, at.data());
            },
            options);
        const double released = initial - rest;
        const double dissipated = integral(times, power);
        EXPECT_NEAR((stored - rest + dissipated) / released, 1.0, 1e-6);
        EXPECT_GT(dissipated, 0.1 * released) << "hardly any damping: the test sees nothing";
    }
}

} // namespace
} // namespace culm::integrate
