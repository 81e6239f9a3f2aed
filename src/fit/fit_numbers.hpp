// SPDX-License-Identifier: BSD-3-Clause
// A fit as the few numbers that another rank needs of it, and back.
#pragma once

#include "fit/solve/fit.hpp"

#include <optional>
#include <span>
#include <vector>

namespace culm::fit {

/// The fit without what its parts hold; counts its effective readings.
[[nodiscard]] Fit numbers_of(const Fit& fit);

/// −2 log likelihood of the readings, less a constant. Recordings of unknown noise count by
/// n log(rms²).
[[nodiscard]] double deviance(const Fit& fit);

template <class Wire>
void fields(Wire& wire, RecordingMisfit& misfit) {
    wire(misfit.readings, misfit.chi_squared, misfit.rmse, misfit.is_noise_known);
}

/// The numbers travel between ranks. The effects do not, because every rank has them.
template <class Wire>
void fields(Wire& wire, Fit& numbers) {
    wire(numbers.names, numbers.status, numbers.reason, numbers.parameters, numbers.chi_squared,
         numbers.reduced_chi_squared, numbers.rmse, numbers.readings, numbers.runs,
         numbers.misfits);
}

/// The fit of `effects` as a map over ranks returns it: a failed one where its rank was lost.
[[nodiscard]] Fit arrived(std::optional<Fit> numbers, const SelectedEffects& effects);

/// The models of the recordings with the numbers of the fit.
[[nodiscard]] std::vector<StemModel> models_of(const Fit& numbers,
                                               std::span<const ObservedRecording> recordings,
                                               const FitOptions& options = {});

/// The fit again, residuals and derivatives too, by one run of each recording: the same on every
/// rank, whichever found it. Throws core::NumericalError if that run fails.
[[nodiscard]] Fit restored(const Fit& numbers, std::span<const ObservedRecording> recordings,
                           const FitOptions& options = {});

} // namespace culm::fit
