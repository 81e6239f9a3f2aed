// SPDX-License-Identifier: BSD-3-Clause
// ARKODE against RODAS5, which shares only the chain's equations with it; the reuse of an
// integrator for another chain; failures.
#include "core/error.hpp"
#include "integrate/recording.hpp"
#include "integrate/statics.hpp"
#include "integrate/sundials/integrator.hpp"
#include "support/integrate_implicit.hpp"

#include <limits>
#include <vector>

#include <gtest/gtest.h>

namespace culm::integrate {
namespace {

using physics::BondLawOptions;
using physics::StemParameters;

StemParameters<double> stiff_stem(int spheres, double youngs_modulus, double damping) {
    StemParameters<double> stem;
    stem.sphere_count = spheres;
    stem.bond_youngs_modulus = youngs_modulus;
    stem.bond_damping = damping;
    return stem;
}

/// A stem whose tip was deflected by a tenth of its length.
template <int Dim>
struct ReleasedStem {
    StemParameters<double> stem;
    physics::Chain<Dim, double> chain;
    double deflection = 0.1 * stem.free_length();
    std::vector<double> state = deflected_equilibrium(chain, deflection).state;
    ErrorScales scales = cantilever_scales(stem, deflection);

    ReleasedStem(const StemParameters<double>& of, const BondLawOptions& law)
        : stem(of), chain(stem, law) {}
};

StepObserver into(auto& recording) {
    return [&recording](double time, std::span<const double> at) {
        recording.sampler().observe(time, at);
    };
}

constexpr std::size_t samples = 101;

ImplicitOptions with_tolerance(double tolerance) {
    ImplicitOptions options;
    options.relative_tolerance = tolerance;
    return options;
}

template <int Dim>
History by_rodas5(const ReleasedStem<Dim>& stem, double duration, double tolerance) {
    Recording<Dim> recording(stem.chain.layout(), duration / (samples - 1), samples);
    std::vector<double> state = stem.state;
    integrate_implicit(stem.chain, state, stem.scales, duration, into(recording),
                       with_tolerance(tolerance));
    return recording.finished();
}

template <int Dim>
History by_sundials(SundialsIntegrator<Dim>& integrator, const ReleasedStem<Dim>& stem,
                    double duration, double tolerance) {
    Recording<Dim> recording(stem.chain.layout(), duration / (samples - 1), samples);
    const LaneOutcome outcome = integrator.integrate(stem.chain, stem.state, stem.scales, duration,
                                                     into(recording), with_tolerance(tolerance));
    EXPECT_FALSE(outcome.failure);
    EXPECT_GT(outcome.work.steps, 0);
    return recording.finished();
}

/// Largest difference of the two integrators as a share of the deflection.
template <int Dim>
double disagreement(const StemParameters<double>& stem, const BondLawOptions& law, double duration,
                    double tolerance) {
    const ReleasedStem<Dim> released(stem, law);
    SundialsIntegrator<Dim> integrator(released.chain.layout());
    return largest_difference(by_rodas5(released, duration, 1e-10),
                              by_sundials(integrator, released, duration, tolerance)) /
           released.deflection;
}

// At a tolerance of 1e-8 the error of the method is about 1e-7. The error of Newton's iteration in
// the bonds' histories is larger.
constexpr double arkode_accuracy = 3e-6;

TEST(Sundials, ArkodeAgreesWithRodas5ForBothLaws) {
    for (const auto& law : {physics::schramm2019_law(), physics::consistent_law()})
        for (const double damping : {1.0, 25.0, 200.0})
            EXPECT_LT(disagreement<2>(stiff_stem(30, 2e9, damping), law, 3e-3, 1e-8),
                      arkode_accuracy)
                << "beta = " << damping;
}

TEST(Sundials, AgreesWithRodas5InSpace) {
    const auto stem = stiff_stem(12, 2e9, 25.0);
    const auto law = physics::schramm2019_law();
    EXPECT_LT(disagreement<3>(stem, law, 1e-3, 1e-8), arkode_accuracy);
}

TEST(Sundials, ToleranceControlsTheError) {
    const auto stem = stiff_stem(20, 1e9, 25.0);
    const auto error = [&](double tolerance) {
        return disagreement<2>(stem, physics::consistent_law(), 3e-3, tolerance);
    };
    const double loose = error(1e-4);
    EXPECT_LT(loose, 1e-2);
    EXPECT_LT(error(1e-6), 0.1 * loose);
}

TEST(Sundials, DoesNotDependOnEarlierChains) {
    const auto law = physics::consistent_law();
    const ReleasedStem<2> wanted(stiff_stem(20, 1e9, 25.0), law);
    const ReleasedStem<2> other(stiff_stem(20, 5e9, 2.0), law);
    SundialsIntegrator<2> fresh(wanted.chain.layout());
    SundialsIntegrator<2> used(wanted.chain.layout());
    static_cast<void>(by_sundials(used, other, 2e-3, 1e-5));
    static_cast<void>(by_sundials(used, wanted, 1e-3, 1e-7));
    EXPECT_EQ(by_sundials(fresh, wanted, 3e-3, 1e-6), by_sundials(used, wanted, 3e-3, 1e-6));
}

TEST(Sundials, CountsItsWork) {
    const ReleasedStem<2> stem(stiff_stem(20, 1e9, 25.0), physics::consistent_law());
    SundialsIntegrator<2> integrator(stem.chain.layout());
    std::int64_t observed = -1; // the state at t = 0 does not belong to a step
    const auto run = [&] {
        observed = -1;
        return integrator
            .integrate(
                stem.chain, stem.state, stem.scales, 3e-3,
                [&observed](double, std::span<const double>) { ++observed; }, with_tolerance(1e-6))
            .work;
    };
    const SolveSummary first = run();
    EXPECT_EQ(first.steps, observed);
    EXPECT_GE(first.rhs_evaluations, first.linear_solves);
    EXPECT_GE(first.factorisations, first.jacobian_evaluations);
    EXPECT_GE(first.jacobian_evaluations, 1);
    EXPECT_EQ(run().rhs_evaluations, first.rhs_evaluations) << "counts of two runs add up";
}

TEST(Sundials, ReportsTheStepLimit) {
    const ReleasedStem<2> stem(stiff_stem(20, 1e9, 25.0), physics::consistent_law());
    SundialsIntegrator<2> integrator(stem.chain.layout());
    ImplicitOptions options = with_tolerance(1e-6);
    options.step_limit = 5;
    const auto outcome = integrator.integrate(
        stem.chain, stem.state, stem.scales, 3e-3, [](double, std::span<const double>) {}, options);
    ASSERT_TRUE(outcome.failure);
    EXPECT_EQ(outcome.failure->kind(), core::FailureKind::StepLimit);
    EXPECT_NE(std::string(outcome.failure->what()).find("used up its 5 steps"), std::string::npos);
    EXPECT_EQ(outcome.work.steps, 5);
}

TEST(Sundials, ReportsTheCauseAndTheFlagOfAFailure) {
    const ReleasedStem<2> stem(stiff_stem(20, 1e9, 25.0), physics::consistent_law());
    std::vector<double> broken = stem.state;
    broken[stem.chain.layout().bond_offset(3)] = std::numeric_limits<double>::quiet_NaN();
    SundialsIntegrator<2> integrator(stem.chain.layout());
    const auto outcome = integrator.integrate(
        stem.chain, broken, stem.scales, 3e-3, [](double, std::span<const double>) {},
        with_tolerance(1e-6));
    ASSERT_TRUE(outcome.failure);
    EXPECT_EQ(outcome.failure->kind(), core::FailureKind::SolverFailed);
    const std::string text = outcome.failure->what();
    EXPECT_NE(text.find("at t = 0 s: the right-hand side is not a number"), std::string::npos)
        << text;
    EXPECT_NE(text.find("(ARK_"), std::string::npos) << text;
    // The integrator can still be used for the next chain.
    EXPECT_FALSE(by_sundials(integrator, stem, 1e-3, 1e-6).empty());
}

} // namespace
} // namespace culm::integrate
