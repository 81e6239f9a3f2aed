// SPDX-License-Identifier: BSD-3-Clause
// How few spheres a search needs.
//
// The error of a chain of bonds of length a is of order a². A fit adds α (y₂ − y₁), the difference
// to the chain of bonds half as long with the same first mode, with α = 4/3 ± 1/3
// (errors/terms.hpp); what remains is about (y₂ − y₁)/3 without the part that Y, β, the
// pull and the release imitate. One pair of runs shows it.
#pragma once

#include "fit/fit_model.hpp"

#include <span>

namespace culm::fit {

/// The smallest of 14, 20 and 28 spheres whose remaining error is below a fifth of the noise (rms
/// over the readings) in every recording; the number that the options state if that is smaller, if
/// none suffices, or if a recording states no noise.
[[nodiscard]] int coarsest_chain(std::span<const measure::Measurement> recordings,
                                 const FitOptions& options);

} // namespace culm::fit
