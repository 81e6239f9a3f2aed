// SPDX-License-Identifier: BSD-3-Clause
// A fit as the few numbers that another rank needs of it, and back.
#pragma once

#include "fit/solve/fit.hpp"

#include <span>
#include <string>
#include <vector>

namespace culm::fit {

/// The fit without what its parts hold; counts its effective readings.
[[nodiscard]] Fit numbers_of(const Fit& fit);

/// Numbers as text and back; every number returns with all its bits, the effects do not. An empty
/// text is a failed fit.
[[nodiscard]] std::string to_text(const Fit& numbers);
[[nodiscard]] Fit fit_from_text(const std::string& text);

/// The models of the recordings with the numbers of the fit.
[[nodiscard]] std::vector<StemModel> models_of(const Fit& numbers,
                                               std::span<const measure::Measurement> recordings,
                                               const FitOptions& options = {});

/// The fit again, residuals and derivatives too, by one run of each recording: the same on every
/// rank, whichever found it. Throws core::NumericalError if that run fails.
[[nodiscard]] Fit restored(const Fit& numbers, std::span<const measure::Measurement> recordings,
                           const FitOptions& options = {});

} // namespace culm::fit
