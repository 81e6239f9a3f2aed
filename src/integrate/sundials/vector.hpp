// SPDX-License-Identifier: BSD-3-Clause
// SUNDIALS' vectors over plain arrays, compiled with culm's own flags.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <type_traits>

#include <sundials/sundials_nvector.h>

namespace culm::integrate::sundials {

struct VectorDeleter {
    void operator()(N_Vector vector) const { N_VDestroy(vector); }
};
using Vector = std::unique_ptr<std::remove_pointer_t<N_Vector>, VectorDeleter>;

/// A vector of `size` zeros. Debian compiles SUNDIALS without optimisation: with its own serial
/// vectors, four fifths of a run pass in sums of arrays.
[[nodiscard]] Vector make_vector(std::size_t size, SUNContext context);

/// The numbers of a vector that make_vector() made, or of a clone of one.
[[nodiscard]] std::span<double> values(N_Vector vector);

} // namespace culm::integrate::sundials
