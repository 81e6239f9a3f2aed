// SPDX-License-Identifier: BSD-3-Clause
#include "calibrate/stem_model.hpp"

#include "calibrate/frame_period.hpp"
#include "core/error.hpp"
#include "reduce/population_statistics.hpp"
#include "reduce/ring_down_analysis.hpp"
#include "run/modes.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include <fmt/core.h>

namespace culm::calibrate {
namespace {

/// Samples in a cycle of the first mode: 19 in one of the second, whose interpolation then errs by
/// 3e-4 of its amplitude.
constexpr double samples_per_cycle = 120.0;
constexpr double largest_release_shift = 1.5; // frames

struct MeasuredMode {
    double natural_frequency = 0.0; ///< undamped, Hz
    double damping_ratio = 0.0;
};

/// Eq. 1 at the height that swings most of those where it can be fitted.
MeasuredMode measured_mode(const measure::Measurement& measurement) {
    std::optional<reduce::RingDownAnalysis> best;
    std::string reason;
    reduce::RingDownAnalysisOptions options;
    options.has_phase = true;
    options.has_offset = measurement.release == measure::ReleaseKind::HeldStraight;
    // The upper half of the heights is enough: the lower ones swing less.
    for (std::size_t j = measurement.heights.size() / 2; j < measurement.heights.size(); ++j) {
        try {
            reduce::RingDownAnalysis fit =
                reduce::analyse_ring_down(measurement.times, measurement.history(j), options);
            if (!best ||
                fit.largest_deflection * fit.r_squared > best->largest_deflection * best->r_squared)
                best = std::move(fit);
        } catch (const core::NumericalError& error) {
            reason = error.what();
        }
    }
    if (!best)
        throw core::NumericalError(
            core::FailureKind::FitFailed,
            fmt::format("{}: Eq. 1 cannot be fitted at any height, so there is nothing to start "
                        "from: {}",
                        measurement.stem.id, reason));
    const double decay = std::max(-best->decay_per_cycle.value, 0.0) / (2.0 * std::numbers::pi);
    return {best->frequency.value * std::hypot(1.0, decay), decay / std::hypot(1.0, decay)};
}

/// Median of the tip's deflection as each reading near the release tells it, through the shape of
/// a cantilever under a force at its tip: x²(3 − x)/2.
double released_deflection(const measure::Measurement& measurement) {
    std::vector<double> deflections;
    const auto first = std::ranges::lower_bound(measurement.times, 0.0);
    const auto release = static_cast<std::size_t>(first - measurement.times.begin());
    for (std::size_t i = 0; i < std::min(release + 1, measurement.times.size()); ++i)
        for (std::size_t j = 0; j < measurement.heights.size(); ++j) {
            const double x = measurement.heights[j] / measurement.stem.length;
            const double reading = measurement.deflection(i, j);
            if (x > 0.5 && !std::isnan(reading))
                deflections.push_back(reading / (0.5 * x * x * (3.0 - x)));
        }
    std::ranges::sort(deflections);
    if (!deflections.empty() && reduce::quantile(deflections, 0.5) != 0.0)
        return reduce::quantile(deflections, 0.5);
    double largest = 0.0;
    for (const double reading : measurement.deflections)
        if (std::abs(reading) > std::abs(largest)) // false for NaN
            largest = reading;
    return largest;
}

} // namespace

std::vector<std::string> StemModel::free_names() const {
    std::vector<std::string> names;
    for (const FreeParameter& parameter : parameters)
        names.push_back(parameter.access.name);
    if (release_time_bound > 0.0)
        names.emplace_back(release_time_name);
    return names;
}

StemModel baseline_model(const measure::Measurement& measurement, const ChainOptions& options) {
    StemChain chain = chain_of(measurement, options);
    StemModel model{chain.spec, baseline_free_parameters(), 0.0, 0.0, std::move(chain.remarks)};
    model.release_time_bound = largest_release_shift * frame_period(measurement);

    const MeasuredMode vibration = measured_mode(measurement);
    run::CaseSpec& spec = model.spec;
    const double ratio = vibration.natural_frequency / natural_frequency(spec);
    spec.stem.bond_youngs_modulus *= ratio * ratio;
    spec.stem.bond_damping = 1.0;
    // M = E I (κ + τ κ̇) damps a mode of angular frequency ω by ζ = ωτ/2.
    const double wanted =
        vibration.damping_ratio / (std::numbers::pi * vibration.natural_frequency);
    spec.stem.bond_damping = std::max(wanted / damping_time(spec), 1e-3);
    spec.sample_interval = 1.0 / (samples_per_cycle * vibration.natural_frequency);
    if (measurement.release == measure::ReleaseKind::HeldStraight) {
        model.parameters.pop_back(); // the tip's deflection before the release
        spec.tip_deflection = 0.0;
        return model;
    }
    spec.tip_deflection = released_deflection(measurement);
    FreeParameter& deflection = model.parameters.back();
    deflection.upper = 0.95 * measurement.stem.length;
    deflection.lower = -deflection.upper;
    return model;
}

} // namespace culm::calibrate
