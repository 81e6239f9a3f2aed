// SPDX-License-Identifier: BSD-3-Clause
// Time per bond and step of the explicit integrator: one stem, and one stem per SIMD lane.
#include "bench/cpu_time.hpp"
#include "bench/run_program.hpp"
#include "core/error.hpp"
#include "core/lanes.hpp"
#include "integrate/statics.hpp"
#include "integrate/velocity_verlet.hpp"

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <string_view>
#include <type_traits>
#include <vector>

#include <fmt/core.h>

namespace culm::bench {
namespace {

using core::Lanes;

/// The published time step, s.
constexpr double timestep = 1e-10;
constexpr std::int64_t steps_per_repeat = 10'000;
constexpr int repeats = 15;

template <class T>
double lane_of(const T& value, std::size_t lane) {
    if constexpr (std::is_same_v<T, double>)
        return value;
    else
        return value[lane];
}

/// A stem of the published design in each lane.
template <class T>
physics::StemParameters<T> design_stems() {
    physics::StemParameters<T> stems;
    if constexpr (std::is_same_v<T, double>) {
        stems.bond_youngs_modulus = 1e9;
        stems.bond_damping = 25.0;
    } else {
        stems.bond_youngs_modulus = T([](auto lane) { return 1e9 * (1.0 + double(lane)); });
        stems.bond_damping = T([](auto lane) { return 25.0 * (1.0 + double(lane)); });
    }
    return stems;
}

/// Every lane starts from the equilibrium of one stem at 15 mm: the work does not depend on values.
template <int Dim, class T>
std::vector<T> deflected_state() {
    const physics::Chain<Dim, double> chain(physics::StemParameters<double>{},
                                            physics::schramm2019_law());
    const std::vector<double> at_rest = integrate::deflected_equilibrium(chain, 15e-3).state;
    return {at_rest.begin(), at_rest.end()};
}

template <int Dim, class T>
void print_row(std::string_view name, std::size_t lanes) {
    const physics::Chain<Dim, T> chain(design_stems<T>(), physics::schramm2019_law());
    integrate::VelocityVerlet<Dim, T> verlet(chain, deflected_state<Dim, T>(), timestep);
    const Timings timings = time_repeats(repeats, [&] { verlet.advance(steps_per_repeat); });

    const int tip = chain.layout().sphere_count() - 1;
    for (std::size_t lane = 0; lane < lanes; ++lane)
        if (!std::isfinite(lane_of(verlet.position(tip)[1], lane)))
            throw core::NumericalError(core::FailureKind::NotANumber,
                                       fmt::format("{}: the tip's position is not finite", name));

    const double bond_steps = static_cast<double>(steps_per_repeat) * chain.layout().bond_count();
    const double median = 1e9 * timings.median() / bond_steps;
    const double least = 1e9 * timings.least() / bond_steps;
    const auto count = static_cast<double>(lanes);
    fmt::print("| {} | {} | {:.2f} | {:.2f} | {:.2f} | {:.2f} |\n", name, lanes, median, least,
               median / count, least / count);
}

void run() {
    fmt::print("Explicit step, 56 spheres, ns per bond and step; median and least processor time "
               "of {} repeats of {} steps.\n"
               "build {}, architecture flag '{}', {} SIMD lanes of double\n\n",
               repeats, steps_per_repeat, CULM_BUILD_TYPE, CULM_ARCHITECTURE, core::lane_count);
    fmt::print("| variant | lanes | all lanes, median | least | per stem, median | per stem, least "
               "|\n|---|---:|---:|---:|---:|---:|\n");
    print_row<2, double>("planar, scalar", 1);
    print_row<2, Lanes>("planar, lanes", core::lane_count);
    print_row<3, double>("spatial, scalar", 1);
    print_row<3, Lanes>("spatial, lanes", core::lane_count);
}

} // namespace
} // namespace culm::bench

int main() {
    return culm::bench::run_program(culm::bench::run);
}
