// SPDX-License-Identifier: BSD-3-Clause
// The eight trajectories of a public DEM code (tests/data/peer-liggghts/README.md).
#include "run/simulate.hpp"
#include "support/peer_trajectory.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace culm::run {
namespace {

struct PeerCase {
    const char* name;
    double youngs_modulus;
    double damping;
    double gravity;
};

std::ostream& operator<<(std::ostream& out, const PeerCase& c) {
    return out << c.name;
}

/// The set-up in the README of the reference: the spring holds the tip at 14.99924 mm.
CaseSpec spec_of(const PeerCase& peer, double end) {
    CaseSpec spec;
    spec.stem.bond_youngs_modulus = peer.youngs_modulus;
    spec.stem.bond_damping = peer.damping;
    spec.stem.axial_acceleration_of_gravity = peer.gravity;
    spec.tip_deflection = 14.99924e-3;
    spec.duration = end;
    spec.sample_interval = 5e-5;
    spec.store = StoreLevel::Full;
    return spec;
}

/// Root mean square difference over all recorded spheres and times, over the tip's deflection.
double rms_difference(const tests::PeerTrajectory& peer, const CaseResult& result) {
    double sum = 0.0;
    std::size_t count = 0;
    for (std::size_t k = 0; k < peer.times.size(); ++k)
        for (std::size_t s = 0; s < peer.spheres.size(); ++s) {
            const auto sphere = static_cast<std::size_t>(peer.spheres[s]);
            const double lateral = result.positions[(k * 56 + sphere) * 3 + 1];
            sum += std::pow(lateral - peer.lateral[k][s], 2);
            ++count;
        }
    return std::sqrt(sum / static_cast<double>(count)) / 14.99924e-3;
}

tests::PeerTrajectory trajectory_of(const PeerCase& peer) {
    return tests::read_peer_trajectory(std::string(CULM_TEST_DATA_DIR) + "/peer-liggghts/" +
                                       peer.name + ".csv");
}

class ReferenceTrajectory : public testing::TestWithParam<PeerCase> {};

TEST_P(ReferenceTrajectory, IsReproducedByTheImplicitIntegratorOverItsWholeLength) {
    const tests::PeerTrajectory peer = trajectory_of(GetParam());
    ASSERT_EQ(peer.spheres.size(), 12U);
    ASSERT_GE(peer.times.size(), 2001U);
    CaseSpec spec = spec_of(GetParam(), peer.times.back());
    spec.integrator.relative_tolerance = 1e-8;
    const CaseOutcome outcome = simulate(spec);
    ASSERT_TRUE(std::holds_alternative<CaseResult>(outcome));
    const double difference = rms_difference(peer, std::get<CaseResult>(outcome));
    RecordProperty("rms_difference_percent", std::to_string(100 * difference));
    // The errors of the reference are the rounding of the tip's deflection in its README (5e-9 m of
    // 15 mm: 3e-7), seven printed digits, and a first-order step error hc/2, which the README
    // bounds by 7e-6 mm (5e-7). The error of culm is the tolerance, over up to 18 cycles.
    EXPECT_LT(difference, 3e-6);
}

INSTANTIATE_TEST_SUITE_P(
    PublicCode, ReferenceTrajectory,
    testing::Values(PeerCase{"Y1_b1", 1e9, 1, 0}, PeerCase{"Y1_b5", 1e9, 5, 0},
                    PeerCase{"Y1_b5_gravity", 1e9, 5, -9.81}, PeerCase{"Y1_b25", 1e9, 25, 0},
                    PeerCase{"Y1_b100", 1e9, 100, 0}, PeerCase{"Y4_b2", 4e9, 2, 0},
                    PeerCase{"Y4_b25", 4e9, 25, 0}, PeerCase{"Y10_b10", 10e9, 10, 0}),
    [](const auto& peer) { return std::string(peer.param.name); });

TEST(ReferenceTrajectoryExplicit, IsReproducedWithTheReferencesOwnTimeStep) {
    const PeerCase peer_case{"Y1_b1", 1e9, 1, 0};
    const tests::PeerTrajectory peer = trajectory_of(peer_case);
    CaseSpec spec = spec_of(peer_case, peer.times.back());
    spec.integrator.method = IntegrationMethod::Explicit;
    spec.integrator.timestep = 5e-5 / 258; // the reference's: 258 steps per row
    const CaseOutcome outcome = simulate(spec);
    ASSERT_TRUE(std::holds_alternative<CaseResult>(outcome));
    const double difference = rms_difference(peer, std::get<CaseResult>(outcome));
    RecordProperty("rms_difference_percent", std::to_string(100 * difference));
    // The scheme and the step are the same; only the digits and the rounded deflection differ.
    EXPECT_LT(difference, 3e-6);
}

} // namespace
} // namespace culm::run
