// SPDX-License-Identifier: BSD-3-Clause
// Calibration of one measured stem: the fitted chain, its adequacy, and the requested tests.
#pragma once

#include "diagnose/adequacy.hpp"
#include "fit/solve/uncertainty_budget.hpp"
#include "integrate/modes.hpp"
#include "physics/effects/selection.hpp"
#include "reduce/ring_down/stem_ring_downs.hpp"

#include <cmath>
#include <optional>
#include <string>
#include <vector>

namespace culm::calibrate {

/// Means of a quantity over the heights that the fits of both stems have, weighted by the precision
/// of the measured one.
struct PairedMean {
    double measured = 0.0;
    double simulated = 0.0;
    double standard_error = 0.0; ///< of the measured one; infinite if there is no such height

    [[nodiscard]] double relative_error() const { return simulated / measured - 1.0; }
    /// One relative standard error of the measured mean: the resolution of the test.
    [[nodiscard]] double resolution() const { return standard_error / std::abs(measured); }
};

/// The paper's closing test: Eq. 1 fitted to the calibrated stem and to the measured one.
struct CalibrationCheck {
    reduce::StemRingDowns measured;
    reduce::StemRingDowns simulated; ///< at the same times and heights, without noise
    PairedMean decay_per_cycle;
    PairedMean frequency; ///< Hz
};

/// Simulates the calibrated stem over the whole record by `method` with the tolerance of the
/// fit, and fits Eq. 1 at every height to both, in the same way. Throws
/// core::NumericalError if Eq. 1 cannot be fitted to one of them.
[[nodiscard]] CalibrationCheck check_calibration(const fit::StemModel& model,
                                                 const measure::Measurement& measurement,
                                                 const reduce::RingDownOptions& options,
                                                 run::IntegrationMethod method);

struct CalibrationOptions {
    fit::FitOptions fit;
    /// Known physics in addition to the baseline; parameters that are not fixed are fitted too.
    std::vector<physics::SelectedEffect> effects;
    bool with_check = false;
    run::IntegrationMethod check_method = run::IntegrationMethod::Implicit; ///< of its simulation
};

struct Calibration {
    std::string id;
    measure::MeasuredStem stem;
    fit::Fit fit;
    fit::UncertaintyBudget budget; ///< of the fit's parameters, in their order

    [[nodiscard]] const fit::RecordingFit& part() const { return fit.parts.front(); }
    integrate::VibrationMode mode; ///< the first of the chain without effects
    reduce::Estimate frequency;    ///< of that mode, Hz
    reduce::Estimate decay_per_cycle;
    double damping_time = 0.0; ///< τ of M = E I (κ + τ κ̇), s
    diagnose::Verdict verdict;
    std::optional<CalibrationCheck> check;
    std::string check_failure; ///< why there is no check though one was asked for
};

/// The last model of fit_nested(), as `culm compare --with` fits it. Throws core::InputError if the
/// measurement cannot be such a model, core::NumericalError if the fit fails or ends at a
/// bound, where its values are not a calibration.
[[nodiscard]] Calibration calibrate_stem(const measure::Measurement& measurement,
                                         const CalibrationOptions& options = {});

} // namespace culm::calibrate
