// SPDX-License-Identifier: BSD-3-Clause
#include "calibrate/calibration.hpp"

#include "core/error.hpp"
#include "fit/model/stem_model.hpp"
#include "run/modes.hpp"

#include <algorithm>

#include <fmt/core.h>

namespace culm::calibrate {
namespace {

void refuse_motionless(const measure::Measurement& measurement,
                       const std::vector<physics::SelectedEffect>& effects) {
    if (measurement.release == measure::ReleaseKind::HeldStraight && effects.empty())
        throw core::InputError(
            fmt::format("{}: [release] kind = \"held_straight\": nothing moves such a stem in a "
                        "model without gravity; add --with gravity",
                        measurement.stem.id));
}

/// A stem that is let go gets its rest position from what moves it, so Eq. 1 needs an offset.
reduce::RingDownAnalysisOptions check_options(const measure::Measurement& measurement,
                                              const CalibrationOptions& options) {
    reduce::RingDownAnalysisOptions check;
    check.window = options.fit.window;
    check.has_offset = measurement.release == measure::ReleaseKind::HeldStraight;
    check.has_phase = measurement.release == measure::ReleaseKind::Moving;
    return check;
}

} // namespace

fit::StemModel model_with_effects(const measure::Measurement& measurement,
                                  const CalibrationOptions& options) {
    refuse_motionless(measurement, options.effects);
    fit::StemModel model = baseline_model(measurement, options.chain);
    for (const physics::SelectedEffect& effect : options.effects)
        model = with_effect(std::move(model), effect, measurement);
    return model;
}

Calibration calibrate_stem(const measure::Measurement& measurement,
                           const CalibrationOptions& options) {
    Calibration result;
    result.id = measurement.stem.id;
    result.fit = fit::fit_chain_beside_errors(model_with_effects(measurement, options), measurement,
                                              options.fit);
    if (!result.fit.reason.empty())
        throw core::NumericalError(core::FailureKind::FitFailed,
                                   fmt::format("{}: {}", result.id, result.fit.reason));
    result.budget = fit::uncertainty_budget(result.fit, measurement);
    const run::CaseSpec chain = fit::case_beside_errors(result.fit.model);
    result.mode = run::first_mode(chain);
    result.damping_time = fit::damping_time(chain);
    result.verdict = diagnose::verdict_on(result.fit, residuals::swing_of(result.fit, measurement));
    if (options.with_profiles)
        result.profiles = profile_intervals(result.fit, measurement, options.fit);
    if (options.with_check) {
        try {
            result.check =
                check_calibration(result.fit, measurement, check_options(measurement, options),
                                  options.check_integrator);
        } catch (const core::NumericalError& error) {
            result.check_failure = error.what();
        }
    }
    return result;
}

} // namespace culm::calibrate
