// SPDX-License-Identifier: BSD-3-Clause
// The orders of the Rosenbrock methods on the chain, and the independence of SIMD lanes.
// sundials.cpp compares RODAS5 with ARKODE.
#include "integrate/rosenbrock.hpp"

#include "core/error.hpp"
#include "integrate/implicit.hpp"
#include "integrate/recording.hpp"
#include "integrate/rosenbrock_methods.hpp"
#include "integrate/statics.hpp"
#include "support/integrate_implicit.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

namespace culm::integrate {
namespace {

using core::Lanes;

physics::StemParameters<double> stem_of(int spheres, double youngs_modulus, double damping) {
    physics::StemParameters<double> stem;
    stem.sphere_count = spheres;
    stem.bond_youngs_modulus = youngs_modulus;
    stem.bond_damping = damping;
    return stem;
}

template <class Method>
class RosenbrockOrder : public testing::Test {};
struct MethodNames {
    template <class Method>
    static std::string GetName(int) {
        return std::string(Method::name);
    }
};
using Methods = testing::Types<Rodas4, Rodas4p, Rodas5, Rodas5p>;
TYPED_TEST_SUITE(RosenbrockOrder, Methods, MethodNames);

/// A stem one period after its release, bent far beyond the linear range. The strong damping has
/// removed its higher modes, so that the solution is smooth although the system is stiff.
struct SmoothMotion {
    physics::StemParameters<double> stem = stem_of(20, 1e9, 100.0);
    physics::Chain<2, double> chain{stem, physics::schramm2019_law()};
    ErrorScales scales = cantilever_scales(stem, 15e-3);
    double period = 2.0 * std::numbers::pi * scales.displacement / scales.velocity;
    std::vector<double> state = deflected_equilibrium(chain, 15e-3).state;

    SmoothMotion() {
        ImplicitOptions options;
        options.relative_tolerance = 1e-11;
        integrate_implicit(
            chain, state, scales, period, [](double, std::span<const double>) {}, options);
    }

    /// Lateral deflection of the tip one more period later, in equal steps.
    template <class Method>
    [[nodiscard]] double tip_after(int steps) const {
        Rosenbrock<2, double, Method> rosenbrock(chain, state, scales, 1e-6, 0.0);
        rosenbrock.fix_step(period / steps);
        for (int step = 0; step < steps; ++step)
            EXPECT_TRUE(rosenbrock.try_step({true})[0]);
        return chain.layout()
            .sphere(rosenbrock.state().data(), chain.layout().bond_count())
            .position[1];
    }
};

TYPED_TEST(RosenbrockOrder, EqualsTheNominalOrderOnTheChain) {
    const SmoothMotion motion;
    const double exact = motion.tip_after<Rodas5>(1000);
    const auto error = [&](int steps) {
        return std::abs(motion.tip_after<TypeParam>(steps) - exact) / 15e-3;
    };
    const double coarse = error(20);
    const double fine = error(80);
    // The errors are far above rounding, 1e-11 here, and far below the size of the motion.
    EXPECT_LT(coarse, 3e-6);
    // With 20 steps per period the higher terms are still visible; they raise the order.
    const double order = std::log2(coarse / fine) / 2.0;
    EXPECT_GT(order, TypeParam::order - 0.3) << coarse << " -> " << fine;
    EXPECT_LT(order, TypeParam::order + 0.8) << coarse << " -> " << fine;
}

/// One stem for each lane, and one more for the tests of neighbours.
std::vector<physics::StemParameters<double>> different_stems() {
    std::vector<physics::StemParameters<double>> stems;
    for (std::size_t k = 0; k <= core::lane_count; ++k) {
        const auto place = static_cast<double>(k);
        stems.push_back(stem_of(14, 1e9 * (1.0 + place), 3.0 * std::pow(1.7, place)));
    }
    return stems;
}

/// Stems released together, one per lane; each runs for a given number of its periods.
template <int Dim>
class StemsInLanes {
    using Stems = std::vector<physics::StemParameters<double>>;

  public:
    explicit StemsInLanes(Stems stems) : stems_(std::move(stems)) {}

    /// Sets the state of lane `lane` to NaN.
    void spoil(std::size_t lane) { spoiled_ = lane; }

    /// Runs the lanes and returns their histories, which are empty for lanes that failed.
    [[nodiscard]] std::vector<History> run() {
        const auto packed = pack();
        const physics::Chain<Dim, Lanes> chain(packed, physics::consistent_law());
        std::array<double, core::lane_count> durations{};
        std::vector<std::unique_ptr<Recording<Dim>>> recordings;
        for (std::size_t lane = 0; lane < core::lane_count; ++lane) {
            durations[lane] = duration(lane);
            recordings.push_back(std::make_unique<Recording<Dim>>(
                chain.layout(), durations[lane] / 100.0, std::size_t{101}));
        }
        outcomes_ = integrate_lanes<Dim, Lanes>(
            chain, released(), cantilever_scales(packed, Lanes(deflection)), durations,
            [&](std::size_t lane, double time, std::span<const Lanes> state) {
                recordings[lane]->sampler().observe(time, state, lane);
            },
            {});
        std::vector<History> histories(core::lane_count);
        for (std::size_t lane = 0; lane < core::lane_count; ++lane)
            if (!outcomes_[lane].failure)
                histories[lane] = recordings[lane]->finished();
        return histories;
    }
    [[nodiscard]] const LaneOutcome& outcome(std::size_t lane) const { return outcomes_[lane]; }

    /// The same stem, computed with doubles.
    [[nodiscard]] History run_alone(std::size_t lane) const {
        const physics::Chain<Dim, double> chain(stems_[lane], physics::consistent_law());
        auto state = deflected_equilibrium(chain, deflection).state;
        Recording<Dim> recording(chain.layout(), duration(lane) / 100.0, 101);
        integrate_implicit(
            chain, state, cantilever_scales(stems_[lane], deflection), duration(lane),
            [&](double time, std::span<const double> at) { recording.sampler().observe(time, at); },
            {});
        return recording.finished();
    }

    static constexpr double deflection = 4e-3;

  private:
    [[nodiscard]] double duration(std::size_t lane) const {
        const auto scales = cantilever_scales(stems_[lane], deflection);
        const double period = 2.0 * std::numbers::pi * scales.displacement / scales.velocity;
        return period * (1.0 + static_cast<double>(lane % 3));
    }
    [[nodiscard]] physics::StemParameters<Lanes> pack() const {
        physics::StemParameters<Lanes> packed;
        packed.sphere_count = stems_.front().sphere_count;
        packed.bond_youngs_modulus =
            Lanes([this](auto lane) { return stems_[lane].bond_youngs_modulus; });
        packed.bond_damping = Lanes([this](auto lane) { return stems_[lane].bond_damping; });
        return packed;
    }
    [[nodiscard]] std::vector<Lanes> released() const {
        std::vector<std::vector<double>> states;
        for (std::size_t lane = 0; lane < core::lane_count; ++lane) {
            const physics::Chain<Dim, double> chain(stems_[lane], physics::consistent_law());
            states.push_back(deflected_equilibrium(chain, deflection).state);
        }
        if (spoiled_)
            std::fill(states[*spoiled_].begin(), states[*spoiled_].end(),
                      std::numeric_limits<double>::quiet_NaN());
        std::vector<Lanes> packed(states.front().size());
        for (std::size_t k = 0; k < packed.size(); ++k)
            packed[k] = Lanes([&](auto lane) { return states[lane][k]; });
        return packed;
    }

    Stems stems_;
    std::optional<std::size_t> spoiled_;
    std::array<LaneOutcome, core::lane_count> outcomes_{};
};

template <int Dim>
void expect_lanes_like_doubles() {
    StemsInLanes<Dim> stems(different_stems());
    const auto together = stems.run();
    for (std::size_t lane = 0; lane < core::lane_count; ++lane) {
        ASSERT_FALSE(stems.outcome(lane).failure) << "lane " << lane;
        // The compiler orders and fuses operations differently. The stiffness amplifies this
        // rounding, which changes the error estimates and hence the steps. A wrong formula would
        // cause a difference of at least the tolerance, 1e-6.
        EXPECT_LT(largest_difference(together[lane], stems.run_alone(lane)),
                  1e-9 * stems.deflection)
            << "lane " << lane;
    }
}

TEST(RosenbrockLanes, AgreeWithDoubles) {
    expect_lanes_like_doubles<2>();
    expect_lanes_like_doubles<3>();
}

TEST(RosenbrockLanes, DoNotDependOnTheirNeighbours) {
    auto stems = different_stems();
    const auto before = StemsInLanes<2>(stems).run();
    // With another stem in lane 0 the other lanes must not change by a single bit.
    stems[0] = stems.back();
    const auto after = StemsInLanes<2>(stems).run();
    EXPECT_NE(before[0], after[0]);
    for (std::size_t lane = 1; lane < core::lane_count; ++lane)
        EXPECT_EQ(before[lane], after[lane]) << "lane " << lane;
}

TEST(RosenbrockLanes, KeepTheirHistoriesWhenAnotherLaneFails) {
    if (core::lane_count < 2)
        GTEST_SKIP() << "this machine has one lane";
    const auto whole = StemsInLanes<2>(different_stems()).run();
    StemsInLanes<2> stems(different_stems());
    stems.spoil(1);
    const auto others = stems.run();
    ASSERT_TRUE(stems.outcome(1).failure);
    EXPECT_EQ(stems.outcome(1).failure->kind(), core::FailureKind::SolverFailed);
    EXPECT_EQ(stems.outcome(1).work.steps, 0);
    for (std::size_t lane = 0; lane < core::lane_count; ++lane) {
        if (lane == 1)
            continue;
        EXPECT_FALSE(stems.outcome(lane).failure) << "lane " << lane;
        EXPECT_EQ(others[lane], whole[lane]) << "lane " << lane;
    }
}

TEST(StepController, RejectsAnErrorThatIsNotANumberAndFinallyGivesUp) {
    StepController controller(1e-3, 4);
    EXPECT_FALSE(controller.judge(std::nan("")));
    EXPECT_EQ(controller.step(), 1e-4);
    EXPECT_EQ(controller.time(), 0.0);
    EXPECT_FALSE(controller.has_failed());
    for (int k = 0; k < 20; ++k)
        EXPECT_FALSE(controller.judge(std::nan("")));
    EXPECT_TRUE(controller.has_failed());
    EXPECT_EQ(controller.rejected_steps(), 21);
}

TEST(StepController, FollowsTheErrorOfAFifthOrderMethod) {
    // The error per step of a smooth problem is (h/h₁)⁵: the step converges to h₁ times about the
    // controller's safety factor.
    StepController controller(1e-6, 4);
    constexpr double allowed = 2e-3;
    for (int k = 0; k < 200; ++k)
        (void)controller.judge(std::pow(controller.step() / allowed, 5.0));
    EXPECT_GT(controller.step(), 0.7 * allowed);
    EXPECT_LT(controller.step(), allowed);
    EXPECT_LT(controller.rejected_steps(), 2);
}

} // namespace
} // namespace culm::integrate
