// SPDX-License-Identifier: BSD-3-Clause
// Times the kernels of an implicit step separately, for one stem and for one stem per SIMD lane,
// and compares them with their numbers of operations.
#include "bench/cpu_time.hpp"
#include "bench/implicit_kernels.hpp"
#include "bench/run_program.hpp"
#include "core/error.hpp"
#include "core/lanes.hpp"
#include "integrate/error_weights.hpp"
#include "integrate/rosenbrock.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <vector>

#include <fmt/core.h>

namespace culm::bench {
namespace {

using core::Lanes;

constexpr int rounds = 10; ///< over all kernels, so that a slow moment affects all of them
constexpr int repeats = 5;

/// Seconds of processor time a call, least of the repeats.
template <int Dim, class T>
Kernels time_once() {
    const physics::Chain<Dim, T> chain(kernel_stem<T>(), physics::schramm2019_law());
    const std::vector<T> state = kernel_state<Dim, T>();
    constexpr int calls = Dim == 2 ? 100 : 30;
    const auto time_of_call = [](auto&& kernel) {
        return time_repeats(repeats,
                            [&] {
                                for (int k = 0; k < calls; ++k)
                                    kernel();
                            })
                   .least() /
               calls;
    };
    Kernels kernels = each_kernel<Dim, T>(chain, state, time_of_call);

    const auto scales = integrate::cantilever_scales(kernel_stem<T>(), T(kernel_deflection));
    integrate::Rosenbrock<Dim, T> rosenbrock(chain, state, scales, 1e-6, 0.0);
    std::array<bool, core::lanes_of<T>> all{};
    all.fill(true);
    kernels.step = time_of_call([&] { (void)rosenbrock.try_step(all); });
    return kernels;
}

template <int Dim, class T>
Kernels time_kernels() {
    Kernels least = time_once<Dim, T>();
    for (int round = 1; round < rounds; ++round) {
        const Kernels now = time_once<Dim, T>();
        for (double Kernels::*member : {&Kernels::rate, &Kernels::jacobian, &Kernels::factorise,
                                        &Kernels::solve, &Kernels::step})
            least.*member = std::min(least.*member, now.*member);
    }
    return least;
}

/// Operations per second of fused multiply-adds in registers, two operations each: the upper
/// bound of any program on this core.
template <class T>
double peak_operations_per_second() {
    constexpr int chains = 8; // two units with a latency of four cycles
    constexpr int additions = 10'000;
    const volatile double near_one = 0.999999;
    const T factor(near_one);
    const T summand(1.0 - near_one);
    T sum(1.0);
    const auto add = [&] {
        T a = sum, b = sum, c = sum, d = sum, e = sum, f = sum, g = sum, h = sum;
        for (int k = 0; k < additions; ++k) {
            a = a * factor + summand;
            b = b * factor - summand;
            c = c * summand + factor;
            d = d * summand - factor;
            e = factor - e * summand;
            f = summand - f * factor;
            g = a * factor + g;
            h = b * factor + h;
        }
        sum = factor * (a + b + c + d + e + f) + summand * (g + h);
    };
    double least = time_repeats(repeats, add).least();
    for (int round = 1; round < 100; ++round) {
        sum = T(1.0);
        least = std::min(least, time_repeats(repeats, add).least());
    }
    if (!core::all_finite(sum))
        throw core::NumericalError(core::FailureKind::NotANumber, "the sums grew");
    return 2.0 * chains * additions * static_cast<double>(core::lanes_of<T>) / least;
}

void print_row(std::string_view name, double seconds, double calls, double step, double operations,
               double peak, double lanes) {
    const double floor = operations * lanes / peak;
    fmt::print("| {:<31} | {:.0f} | {:>7.2f} | {:>5.1f} % | {:>8.0f} | {:>6.2f} | {:.0f} % |\n",
               name, calls, 1e6 * seconds, 100.0 * calls * seconds / step, operations, 1e6 * floor,
               100.0 * floor / seconds);
}

template <int Dim, class T>
void print_table(std::string_view name, const Kernels& operations) {
    const Kernels times = time_kernels<Dim, T>();
    const double peak = peak_operations_per_second<T>();
    constexpr auto lanes = static_cast<double>(core::lanes_of<T>);
    constexpr auto stages = static_cast<double>(integrate::Rodas5::stages);
    fmt::print("### {}: {:.1f} µs a step, {:.2f} µs per stem; peak {:.1f} G operations/s\n\n"
               "| what | calls a step | µs a call | share | operations per stem | floor, µs | "
               "floor / time |\n|---|---:|---:|---:|---:|---:|---:|\n",
               name, 1e6 * times.step, 1e6 * times.step / lanes, 1e-9 * peak);
    const auto row = [&](std::string_view what, double Kernels::*member, double calls) {
        print_row(what, times.*member, calls, times.step, operations.*member, peak, lanes);
    };
    row("right-hand side", &Kernels::rate, stages);
    row("Jacobian (dual numbers)", &Kernels::jacobian, 1.0);
    row("condensation and factorisation", &Kernels::factorise, 1.0);
    row("solve", &Kernels::solve, stages);
    print_row("the rest: sums over stages", times.rest(), 1.0, times.step, operations.rest(), peak,
              lanes);
    row("step", &Kernels::step, 1.0);
    fmt::print("\n");
}

void run() {
    fmt::print("56 spheres, Y = 1 GPa, β = 25, RODAS5; least processor time of {} repeats; build "
               "{}, architecture flag '{}', {} SIMD lanes.\nFloor: the operations (additions, "
               "multiplications, divisions and roots, one each) at the measured peak of fused "
               "multiply-adds, two operations each; it counts products with zeros of dual numbers "
               "that the "
               "compiler leaves out.\n\n",
               rounds * repeats, CULM_BUILD_TYPE, CULM_ARCHITECTURE, core::lane_count);
    const Kernels planar = count_kernels<2>();
    const Kernels spatial = count_kernels<3>();
    print_table<2, double>("Planar, one stem", planar);
    print_table<2, Lanes>("Planar, lanes", planar);
    print_table<3, double>("Spatial, one stem", spatial);
    print_table<3, Lanes>("Spatial, lanes", spatial);
}

} // namespace
} // namespace culm::bench

int main() {
    return culm::bench::run_program([] { culm::bench::run(); });
}
