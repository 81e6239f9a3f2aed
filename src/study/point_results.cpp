// SPDX-License-Identifier: BSD-3-Clause
#include "study/point_results.hpp"

#include "core/error.hpp"
#include "study/timestep_point.hpp"

#include <cmath>
#include <limits>

namespace culm::study {
namespace {

constexpr std::size_t fit_columns = 10;

void append_fit(const reduce::RingDownFit& fit, std::vector<double>& values) {
    values.insert(values.end(),
                  {fit.amplitude, fit.amplitude_uncertainty.standard_error, fit.decay_rate,
                   fit.decay_rate_uncertainty.standard_error, fit.frequency,
                   fit.frequency_uncertainty.standard_error, fit.decay_per_cycle,
                   fit.decay_per_cycle_uncertainty.standard_error, fit.rms_residual,
                   fit.r_squared});
}

archive::PointRecord failed_record(std::int64_t point, core::FailureKind kind,
                                   const std::string& reason) {
    archive::PointRecord record;
    record.point = point;
    record.failure_kind = core::to_string(kind);
    record.failure_reason = reason;
    return record;
}

} // namespace

std::vector<archive::Column> result_columns(const StudyConfig& config) {
    if (config.kind == StudyKind::Timestep)
        return timestep_columns(config.timestep);
    return {
        {"amplitude", "1", "b0 of Eq. 1 over the largest deflection"},
        {"amplitude_standard_error", "1", "standard error of b0"},
        {"decay_rate", "1/s", "b1 of Eq. 1"},
        {"decay_rate_standard_error", "1/s", "standard error of b1"},
        {"frequency", "Hz", "b2 of Eq. 1"},
        {"frequency_standard_error", "Hz", "standard error of b2"},
        {"decay_per_cycle", "1", "b1/b2, the paper's b1 in normalised time"},
        {"decay_per_cycle_standard_error", "1", "standard error of b1/b2"},
        {"rms_residual", "1", "root mean square residual of Eq. 1 over the largest deflection"},
        {"r_squared", "1", "share of the history's variance that Eq. 1 explains"},
        {"steps", "1", "steps of the integrator"},
        {"rhs_evaluations", "1", "evaluations of the right-hand side"},
    };
}

reduce::RingDownFitOptions fit_options(const ReduceOptions& options) {
    reduce::RingDownFitOptions fit;
    fit.amplitude_is_free = options.is_amplitude_free;
    fit.window = options.window;
    return fit;
}

std::vector<double> sample_times(const run::CaseSpec& spec) {
    std::vector<double> times(spec.sample_count());
    for (std::size_t k = 0; k < times.size(); ++k)
        times[k] = static_cast<double>(k) * spec.sample_interval;
    return times;
}

archive::PointRecord make_record(const run::CaseSpec& spec, run::CaseOutcome outcome,
                                 const ReduceOptions& options) {
    if (const auto* failure = std::get_if<run::CaseFailure>(&outcome))
        return failed_record(spec.point, failure->kind, failure->reason);
    run::CaseResult& result = std::get<run::CaseResult>(outcome);

    archive::PointRecord record;
    record.point = spec.point;
    record.completed = true;
    try {
        append_fit(
            reduce::fit_ring_down(sample_times(spec), result.tip_deflection, fit_options(options)),
            record.values);
    } catch (const core::NumericalError& error) {
        if (spec.store == run::StoreLevel::Fit)
            return failed_record(spec.point, error.kind(), error.what());
        record.values.assign(fit_columns, std::numeric_limits<double>::quiet_NaN());
    }
    record.values.push_back(static_cast<double>(result.work.steps));
    record.values.push_back(static_cast<double>(result.work.rhs_evaluations));
    if (spec.store >= run::StoreLevel::Tip)
        record.tip_deflection = std::move(result.tip_deflection);
    if (spec.store >= run::StoreLevel::Heights)
        record.height_deflection = std::move(result.height_deflection);
    if (spec.store == run::StoreLevel::Full)
        record.positions = std::move(result.positions);
    return record;
}

} // namespace culm::study
