// SPDX-License-Identifier: BSD-3-Clause
// Fits to one recording.
#pragma once

#include "diagnose/models/stem_fit.hpp"
#include "fit/fit_model.hpp"

#include <span>

namespace culm::tests {

/// Fits a single model with exact inputs; its values are the first guess.
inline fit::Fit fit_exactly(const fit::StemModel& model, const measure::Measurement& measurement,
                            const fit::FitOptions& options = {}) {
    const fit::ObservedRecording recording(measurement);
    fit::JointOptions exact{options};
    exact.with_inputs = false;
    return fit::fit_jointly({&model, 1}, {&recording, 1}, exact);
}
inline fit::RecordingFit fit_chain(const fit::StemModel& model,
                                   const measure::Measurement& measurement,
                                   const fit::FitOptions& options = {}) {
    return fit_exactly(model, measurement, options).parts.front();
}

/// The published chain.
inline fit::Fit fit_baseline(const measure::Measurement& measurement,
                             const fit::FitOptions& options = {}) {
    const fit::ObservedRecording recording(measurement);
    return fit::fit_model({}, {}, {&recording, 1}, options);
}

/// The chain with these effects, starting from `smaller`, a fit with some or none of them.
inline fit::Fit fit_candidate(const fit::SelectedEffects& effects, const fit::Fit& smaller,
                              const measure::Measurement& measurement,
                              const fit::FitOptions& options = {}) {
    const fit::ObservedRecording recording(measurement);
    return diagnose::fit_larger(effects, smaller, {&recording, 1}, options);
}

} // namespace culm::tests
