// SPDX-License-Identifier: BSD-3-Clause
// The slowest mode against all modes, from lightly damped stems to aperiodic ones.
#include "integrate/modes.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace culm::integrate {
namespace {

LinearisedChain stem(double bond_damping, const physics::BondLawOptions& law) {
    physics::StemParameters<double> stem;
    stem.bond_youngs_modulus = 2e9;
    stem.bond_damping = bond_damping;
    return linearise_transverse(stem, law);
}

void expect_first_of_all(const LinearisedChain& chain, double damping) {
    const auto all = vibration_modes(chain, static_cast<std::size_t>(chain.mass.size()));
    const auto slowest = vibration_modes(chain, 1);
    ASSERT_EQ(slowest.empty(), all.empty()) << damping;
    if (all.empty())
        return;
    // All modes are computed from a companion matrix, whose rounding dominates.
    const VibrationMode& found = slowest.front();
    EXPECT_NEAR(found.frequency / all.front().frequency, 1.0, 1e-8) << damping;
    EXPECT_NEAR(found.decay_rate / all.front().decay_rate, 1.0, 1e-6) << damping;
    EXPECT_NEAR(found.decay_per_cycle / all.front().decay_per_cycle, 1.0, 1e-6) << damping;
}

TEST(SlowestMode, IsTheFirstOfAllModes) {
    for (const double damping : {0.01, 1.0, 50.0, 200.0, 800.0, 1500.0, 4000.0, 20000.0})
        for (const auto& law : {physics::consistent_law(), physics::schramm2019_law()})
            expect_first_of_all(stem(damping, law), damping);
}

TEST(SlowestMode, IncludesTheRotationOfACompliantClamp) {
    physics::StemParameters<double> parameters;
    parameters.bond_youngs_modulus = 2e9;
    const auto law = physics::consistent_law();
    physics::ChainModel<double> model = physics::plain_chain(parameters, law);
    model.hinge = physics::BaseHinge<double>{0.5, 0.0, 1.0};
    const physics::Chain<2, double> chain(parameters.sphere_count, model, law);
    expect_first_of_all(linearise_transverse(chain), parameters.bond_damping);
}

} // namespace
} // namespace culm::integrate
