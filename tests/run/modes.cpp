// SPDX-License-Identifier: BSD-3-Clause
#include "run/modes.hpp"

#include "physics/effects/selection.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace culm::tests {
namespace {

run::CaseSpec plain_case() {
    run::CaseSpec spec;
    spec.stem.sphere_count = 40;
    spec.stem.bond_damping = 1.0; // so that modes 2 and 3 are slowed by less than 1e-3
    return spec;
}

run::CaseSpec case_with(const char* effect) {
    run::CaseSpec spec = plain_case();
    for (const physics::SelectedEffect& selected : physics::parse_effects(effect, {}))
        spec.effects.push_back(physics::with_defaults(selected, spec.stem));
    return spec;
}

TEST(ChainModes, EqualThoseOfTheCalibrationForThePlainChain) {
    const auto modes = run::chain_modes(plain_case(), 3);
    ASSERT_EQ(modes.size(), 3u);
    // Both are the same eigenvalue from the same routine.
    EXPECT_NEAR(modes[0].frequency, run::first_mode(plain_case()).frequency, 1e-6);
    // Shear and the finite spheres lower the Euler-Bernoulli values, 6.267 and 17.55.
    EXPECT_NEAR(modes[1].frequency / modes[0].frequency, 6.267, 0.06);
    EXPECT_NEAR(modes[2].frequency / modes[0].frequency, 17.55, 0.5);
}

TEST(ChainModes, AreLowerForACompliantClamp) {
    const double rigid = run::chain_modes(plain_case(), 1).front().frequency;
    const double yielding = run::chain_modes(case_with("clamp_compliance"), 1).front().frequency;
    // The default spring has 50 E I/L: −2 EI/(k L) to first order, less the second order's 1e-3.
    EXPECT_NEAR(yielding / rigid - 1.0, -2.0 / 50.0, 3e-3);
}

TEST(ChainModes, AreStiffenedByBranchesThatRelaxSlowly) {
    const double relaxed = run::chain_modes(plain_case(), 1).front().frequency;
    const double stiff =
        run::chain_modes(case_with("relaxation(fraction=0.06,time_s=10)"), 1).front().frequency;
    EXPECT_NEAR(stiff / relaxed, std::sqrt(1.06), 1e-4);
}

} // namespace
} // namespace culm::tests
