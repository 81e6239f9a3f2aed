// SPDX-License-Identifier: BSD-3-Clause
// Counts the operations of an implicit step. It is a separate source, because in one source with
// these instantiations the timed ones become three times slower.
#include "bench/counted.hpp"
#include "bench/implicit_kernels.hpp"

#include <cstdint>

namespace culm::bench {

template <int Dim>
Kernels count_kernels() {
    const physics::Chain<Dim, Counted> chain(kernel_stem<Counted>(), physics::schramm2019_law());
    const std::vector<Counted> state = kernel_state<Dim, Counted>();
    const auto operations_of_call = [](auto&& kernel) {
        const std::int64_t before = counted_operations;
        kernel();
        return static_cast<double>(counted_operations - before);
    };
    Kernels kernels = each_kernel<Dim, Counted>(chain, state, operations_of_call);
    // Sums over the previous stages: U_j times a_ij and c_ij, and the operations once per stage.
    constexpr auto stages = static_cast<double>(integrate::Rodas5::stages);
    const auto size = static_cast<double>(state.size());
    const double vectors = size * (2.0 * stages * (stages - 1.0) + 3.0 * stages + 4.0);
    kernels.step = kernels.stages() + kernels.jacobian + kernels.factorise + vectors;
    return kernels;
}

template Kernels count_kernels<2>();
template Kernels count_kernels<3>();

} // namespace culm::bench
