// SPDX-License-Identifier: BSD-3-Clause
// Converts a fit to the few numbers that another rank needs, and back.
#pragma once

#include "fit/fit.hpp"

#include <span>

namespace culm::fit {

/// The fit without its parts, its system and its matrices.
[[nodiscard]] Fit to_numbers(const Fit& fit);
/// The same with the results of its runs, from which rerun() needs no run.
[[nodiscard]] Fit to_numbers_with_points(const Fit& fit);

/// −2 log likelihood of the readings, less a constant. The contribution of a recording of unknown
/// noise is n log(rms²).
[[nodiscard]] double deviance(const Fit& fit);

/// The numbers travel between ranks. The effects do not, because every rank has them. The parts,
/// the system and the covariance do not, because they are large and rerun() finds them again.
template <class Wire>
void fields(Wire& wire, Fit& numbers) {
    wire(numbers.status, numbers.reason, numbers.parameters, numbers.pulls,
         numbers.has_moved_inputs, numbers.chi_squared, numbers.reduced_chi_squared, numbers.rmse,
         numbers.readings, numbers.degrees_of_freedom, numbers.misfits, numbers.batches,
         numbers.points, numbers.weighted_rms, numbers.own_weighted_rms);
}

/// The models of the recordings with the numbers of the fit.
[[nodiscard]] StartModels models_of(const Fit& numbers,
                                    std::span<const ObservedRecording> recordings,
                                    const FitOptions& options = {});

/// The fit with residuals and derivatives: from its points if it has some for these recordings and
/// this chain, else by runs of each recording at its numbers. The result is the same on every rank,
/// whichever found the fit. Throws core::NumericalError if a run fails.
[[nodiscard]] Fit rerun(const Fit& numbers, std::span<const ObservedRecording> recordings,
                        const FitOptions& options = {});

} // namespace culm::fit
