// SPDX-License-Identifier: BSD-3-Clause
#include "calibrate/calibration.hpp"

#include "core/error.hpp"
#include "diagnose/ladder.hpp"
#include "fit/chain/baseline_model.hpp"
#include "residuals/swing.hpp"
#include "run/modes.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include <fmt/core.h>

namespace culm::calibrate {
namespace {

/// A fit may end in a valley whose first mode is not the swing: all later numbers are then wrong.
void require_swing(const measure::Measurement& measurement, const fit::RecordingFit& fit,
                   const CalibrationOptions& options) {
    constexpr double largest_ratio = 1.25; // Eq. 1 of a swing with an effect is right within that
    const fit::StemModel started = fit::baseline_model(measurement, options.fit.chain);
    const double swing = run::lightly_damped_mode(started.spec).frequency;
    const double mode = run::lightly_damped_mode(fit::computed_case(fit.model)).frequency;
    // A stem that is not stable when straight has no such mode.
    if (std::isnan(mode) || (mode < largest_ratio * swing && swing < largest_ratio * mode))
        return;
    throw core::NumericalError(
        core::FailureKind::FitFailed,
        fmt::format("{}: the first mode of the fitted chain has {:.4g} Hz, but the stem swings at "
                    "{:.4g} Hz (Eq. 1): time 0 is not the release, or the deflections do not count "
                    "from the rest position (culm import finds both)",
                    measurement.stem.id, mode, swing));
}

/// The last model of fit_nested().
fit::Fit fitted(const measure::Measurement& measurement, const CalibrationOptions& options) {
    if (measurement.release == measure::ReleaseKind::HeldStraight && options.effects.empty())
        throw core::InputError(
            fmt::format("{}: [release] kind = \"held_straight\": nothing moves such a stem in a "
                        "model without gravity; add --with gravity",
                        measurement.stem.id));
    std::vector<fit::SelectedEffects> sets;
    if (!options.effects.empty())
        sets.push_back(options.effects);
    fit::Fit model =
        std::move(diagnose::fit_nested({&measurement, 1}, sets, options.fit).models.back());
    if (!model.reason.empty()) // also a parameter at its bound is not calibrated
        throw core::NumericalError(core::FailureKind::FitFailed,
                                   fmt::format("{}: {}", measurement.stem.id, model.reason));
    require_swing(measurement, model.parts.front(), options);
    return model;
}

/// Y goes with f², so that a chain in vacuum of the frequency of one in air is too soft.
double still_air_bias(const run::CaseSpec& chain) {
    if (std::ranges::any_of(chain.effects,
                            [](const auto& active) { return active.effect->name == "still_air"; }))
        return 0.0;
    run::CaseSpec in_air = chain;
    in_air.effects.push_back(
        physics::with_defaults(physics::parse_effect("still_air", {}), chain.stem));
    return std::pow(run::lightly_damped_mode(in_air).frequency /
                        run::lightly_damped_mode(chain).frequency,
                    2) -
           1.0;
}

} // namespace

Calibration calibrate_stem(const measure::Measurement& measurement,
                           const CalibrationOptions& options) {
    Calibration result;
    result.id = measurement.stem.id;
    result.stem = measurement.stem;
    result.fit = fitted(measurement, options);
    result.budget = fit::uncertainty_budget(result.fit, measurement);
    const run::CaseSpec chain = fit::computed_case(result.part().model);
    result.mode = run::first_mode(chain);
    const Eigen::VectorXd errors =
        fit::uncertainties_of(result.fit, result.budget, [](const run::CaseSpec& spec) {
            const integrate::VibrationMode mode = run::first_mode(spec);
            return Eigen::VectorXd{{mode.frequency, mode.decay_per_cycle}};
        });
    result.frequency = reduce::normal_estimate(result.mode.frequency, errors(0));
    result.decay_per_cycle = reduce::normal_estimate(result.mode.decay_per_cycle, errors(1));
    result.damping_time = fit::damping_time(chain);
    result.still_air_bias = still_air_bias(chain);
    result.verdict =
        diagnose::verdict_on(result.part(), residuals::swing_of(result.part(), measurement));
    return result;
}

} // namespace culm::calibrate
