// SPDX-License-Identifier: BSD-3-Clause
// Converts a fit to the few numbers that another rank needs, and back.
#pragma once

#include "fit/solve/fit.hpp"

#include <span>
#include <vector>

namespace culm::fit {

/// The fit without its parts; counts its effective readings.
[[nodiscard]] Fit numbers_of(const Fit& fit);

/// −2 log likelihood of the readings, less a constant. The contribution of a recording of unknown
/// noise is n log(rms²).
[[nodiscard]] double deviance(const Fit& fit);

template <class Wire>
void fields(Wire& wire, RecordingMisfit& misfit) {
    wire(misfit.readings, misfit.chi_squared, misfit.rmse, misfit.is_noise_known);
}

/// The numbers travel between ranks. The effects do not, because every rank has them.
template <class Wire>
void fields(Wire& wire, Fit& numbers) {
    wire(numbers.names, numbers.status, numbers.reason, numbers.parameters, numbers.chi_squared,
         numbers.reduced_chi_squared, numbers.rmse, numbers.readings, numbers.runs, numbers.misfits,
         numbers.model_terms);
}

/// The models of the recordings with the numbers of the fit.
[[nodiscard]] std::vector<StemModel> models_of(const Fit& numbers,
                                               std::span<const ObservedRecording> recordings,
                                               const FitOptions& options = {});

/// Restores the residuals and derivatives of a fit by one run of each recording. The result is the
/// same on every rank, whichever found the fit. Throws core::NumericalError if a run fails.
[[nodiscard]] Fit restored(const Fit& numbers, std::span<const ObservedRecording> recordings,
                           const FitOptions& options = {});

} // namespace culm::fit
