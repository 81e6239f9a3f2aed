// SPDX-License-Identifier: BSD-3-Clause
// The implicit integrator against the eigenvalues of the linearised chain, and its order.
#include "integrate/implicit.hpp"

#include "core/error.hpp"
#include "integrate/history_sampler.hpp"
#include "integrate/statics.hpp"
#include "reduce/ring_down/ring_down_fit.hpp"
#include "support/integrate_implicit.hpp"
#include "support/modal_state.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace culm::integrate {
namespace {

struct Case {
    const char* law;
    double youngs_modulus;
    double damping;
};

std::ostream& operator<<(std::ostream& out, const Case& c) {
    return out << c.law << ", Y = " << c.youngs_modulus << " Pa, beta = " << c.damping;
}

physics::StemParameters<double> stem_of(const Case& c) {
    physics::StemParameters<double> stem;
    stem.bond_youngs_modulus = c.youngs_modulus;
    stem.bond_damping = c.damping;
    return stem;
}

/// Lateral tip history of `count` samples from `state`.
template <int Dim>
std::vector<double> tip_history(const physics::Chain<Dim, double>& chain, std::vector<double> state,
                                const ErrorScales& scales, double interval, std::size_t count,
                                const ImplicitOptions& options = {}) {
    std::vector<double> history(count);
    const int tip = chain.layout().sphere_count() - 1;
    HistorySampler<Dim> sampler(
        chain.layout(), tip, tip, interval, count, false,
        [&](std::size_t k, const auto& rates) { history[k] = rates[0][1]; });
    integrate_implicit(
        chain, state, scales, interval * static_cast<double>(count - 1),
        [&](double time, std::span<const double> at) { sampler.observe(time, at); }, options);
    sampler.finish();
    EXPECT_EQ(sampler.emitted(), count);
    return history;
}

class SmallAmplitude : public testing::TestWithParam<Case> {};

TEST_P(SmallAmplitude, HasTheFrequencyAndDecayOfTheLinearisedChain) {
    const auto stem = stem_of(GetParam());
    const auto law = *physics::law_by_name(GetParam().law);
    const physics::Chain<2, double> chain(stem, law);
    // Geometric nonlinearity shifts the frequency by (δ/L)² ~ 4e-7 at this amplitude.
    const double amplitude = 1e-4;
    const auto mode = tests::first_mode_state(chain, linearise_transverse(stem, law), amplitude);
    const double period = 2 * 3.14159265358979323846 / mode.eigenvalue.imag();
    const std::size_t count = 1001;
    const double interval = 8 * period / (count - 1);
    const auto history =
        tip_history(chain, mode.state, cantilever_scales(stem, amplitude), interval, count);
    std::vector<double> times(count);
    for (std::size_t k = 0; k < count; ++k)
        times[k] = interval * static_cast<double>(k);
    // Re(e^{λt}) starts with a phase of zero because the velocity at t = 0 is Re λ.
    const auto fit = reduce::fit_ring_down(times, history);
    const double frequency = mode.eigenvalue.imag() / (2 * 3.14159265358979323846);
    const double decay_per_cycle = mode.eigenvalue.real() / frequency;
    // The default tolerance guarantees 0.1 % of both.
    EXPECT_NEAR(fit.frequency.value / frequency, 1.0, 1e-5);
    EXPECT_NEAR(fit.decay_per_cycle.value / decay_per_cycle, 1.0, 1e-3);
}

INSTANTIATE_TEST_SUITE_P(BothLaws, SmallAmplitude,
                         testing::Values(Case{"schramm2019", 0.4e9, 1}, Case{"schramm2019", 1e9, 1},
                                         Case{"schramm2019", 1e9, 25},
                                         Case{"schramm2019", 1e9, 200},
                                         Case{"schramm2019", 10e9, 1},
                                         Case{"schramm2019", 10e9, 25},
                                         Case{"schramm2019", 10e9, 200}, Case{"consistent", 1e9, 1},
                                         Case{"consistent", 1e9, 25}, Case{"consistent", 1e9, 200},
                                         Case{"consistent", 10e9, 1}, Case{"consistent", 10e9, 25},
                                         Case{"consistent", 10e9, 200}));

TEST(ImplicitOrder, IsFiveWithDampingOn) {
    // Modal motion at small amplitude, where the exact solution is known; β = 100 makes the
    // damping strong (decay 0.36 per cycle) and the other modes stiff.
    const auto stem = stem_of({"", 1e9, 100});
    const auto law = physics::schramm2019_law();
    const physics::Chain<2, double> chain(stem, law);
    const double amplitude = 1e-5; // (δ/L)² = 4e-9 below the smallest error measured here
    const auto mode = tests::first_mode_state(chain, linearise_transverse(stem, law), amplitude);
    const double period = 2 * 3.14159265358979323846 / mode.eigenvalue.imag();
    std::vector<double> errors;
    for (const int steps_per_period : {10, 20, 40}) {
        ImplicitOptions options;
        options.fixed_step = period / steps_per_period;
        options.relative_tolerance = 1e-7; // of the Newton iteration
        std::vector<double> state = mode.state;
        double time = 0.0;
        integrate_implicit(
            chain, state, cantilever_scales(stem, amplitude), 2 * period * (1 - 1e-9),
            [&](double t, std::span<const double>) { time = t; }, options);
        const double exact = amplitude * std::exp(mode.eigenvalue * time).real();
        const double tip = chain.layout().sphere(state.data(), 55).position[1];
        errors.push_back(std::abs(tip - exact) / amplitude);
    }
    for (std::size_t k = 1; k < errors.size(); ++k) {
        const double order = std::log2(errors[k - 1] / errors[k]);
        EXPECT_GT(order, 4.5) << errors[k - 1] << " -> " << errors[k];
        EXPECT_LT(order, 5.5) << errors[k - 1] << " -> " << errors[k];
    }
}

TEST(ImplicitTolerance, BoundsTheErrorOfAReleasedStemAndConverges) {
    const auto stem = stem_of({"", 1e9, 25});
    const physics::Chain<2, double> chain(stem, physics::schramm2019_law());
    const auto released = deflected_equilibrium(chain, 15e-3).state;
    const auto scales = cantilever_scales(stem, 15e-3);
    const auto run = [&](double tolerance) {
        ImplicitOptions options;
        options.relative_tolerance = tolerance;
        return tip_history(chain, released, scales, 5e-5, 801, options);
    };
    const auto reference = run(1e-9);
    std::vector<double> errors;
    for (const double tolerance : {1e-4, 1e-5, 1e-6, 1e-7}) {
        const auto history = run(tolerance);
        double worst = 0.0;
        for (std::size_t k = 0; k < history.size(); ++k)
            worst = std::max(worst, std::abs(history[k] - reference[k]) / 15e-3);
        // The tolerance applies to one step; the errors of some hundred steps add up.
        EXPECT_LT(worst, 300 * tolerance);
        errors.push_back(worst);
    }
    EXPECT_LT(errors.back(), 1e-2 * errors.front());
}

TEST(ImplicitSolver, AgreesInSpaceWithThePlane) {
    auto stem = stem_of({"", 2e9, 50});
    stem.sphere_count = 20;
    const physics::Chain<2, double> planar(stem, physics::consistent_law());
    const physics::Chain<3, double> spatial(stem, physics::consistent_law());
    const auto scales = cantilever_scales(stem, 5e-3);
    ImplicitOptions options;
    options.relative_tolerance = 1e-8;
    const auto flat =
        tip_history(planar, deflected_equilibrium(planar, 5e-3).state, scales, 1e-5, 201, options);
    const auto space = tip_history(spatial, deflected_equilibrium(spatial, 5e-3).state, scales,
                                   1e-5, 201, options);
    for (std::size_t k = 0; k < flat.size(); ++k) // both are within some hundred tolerances
        EXPECT_NEAR(space[k], flat[k], 1e-6 * 5e-3) << "sample " << k;
}

TEST(ImplicitSolver, StopsAtItsStepLimitAndOnRequest) {
    const auto stem = stem_of({"", 1e9, 25});
    const physics::Chain<2, double> chain(stem, physics::schramm2019_law());
    auto state = deflected_equilibrium(chain, 15e-3).state;
    const auto scales = cantilever_scales(stem, 15e-3);
    const auto ignore = [](double, std::span<const double>) {};
    ImplicitOptions options;
    options.step_limit = 5;
    try {
        integrate_implicit(chain, state, scales, 0.1, ignore, options);
        FAIL() << "five steps cannot reach 0.1 s";
    } catch (const core::NumericalError& error) {
        EXPECT_EQ(error.kind(), core::FailureKind::StepLimit);
    }
    options.step_limit = 1'000'000;
    int beats = 0;
    options.heartbeat = [&beats] { return ++beats < 3; };
    EXPECT_THROW(integrate_implicit(chain, state, scales, 0.1, ignore, options), Interrupted);
    EXPECT_EQ(beats, 3);
}

} // namespace
} // namespace culm::integrate
