// SPDX-License-Identifier: BSD-3-Clause
#include "study/execute/point_results.hpp"

#include "core/error.hpp"
#include "physics/effects/stem_scales.hpp"
#include "run/explicit_steps.hpp"
#include "run/modes.hpp"

#include <cmath>
#include <limits>
#include <span>

#include <fmt/core.h>

namespace culm::study {

namespace {

constexpr std::size_t fit_columns = 10;

void append_fit(const reduce::RingDownFit& fit, std::vector<double>& values) {
    const double scale = fit.largest_deflection;
    for (const auto& [number, unit] :
         {std::pair(fit.amplitude, scale), std::pair(fit.decay_rate, 1.0),
          std::pair(fit.frequency, 1.0), std::pair(fit.decay_per_cycle, 1.0)})
        values.insert(values.end(), {number.value / unit, number.standard_error / unit});
    values.insert(values.end(), {fit.rms_residual / scale, fit.r_squared});
}

/// A result column that counts work of the integrator.
struct WorkColumn {
    const char* name;
    const char* description;
    std::int64_t integrate::SolveSummary::*count;
};

/// For culm's own methods the counts after the first two follow from these.
std::span<const WorkColumn> work_of(run::IntegrationMethod method) {
    using Work = integrate::SolveSummary;
    static constexpr WorkColumn columns[] = {
        {"steps", "steps of the integrator", &Work::steps},
        {"rhs_evaluations", "evaluations of the right-hand side", &Work::rhs_evaluations},
        {"jacobian_evaluations", "evaluations of the Jacobian", &Work::jacobian_evaluations},
        {"factorisations", "factorisations of the Newton matrix", &Work::factorisations},
        {"newton_iterations", "iterations of Newton's method", &Work::linear_solves},
        {"error_test_failures", "steps that the error test rejected", &Work::rejected_steps},
        {"convergence_failures", "steps that Newton's method gave up", &Work::convergence_failures},
    };
    return method == run::IntegrationMethod::Sundials ? std::span(columns)
                                                      : std::span(columns).first(2);
}

/// b1 per cycle and b2 of a history, or why there are none.
struct StepFit {
    StepOutcome outcome = StepOutcome::NoFit;
    double decay_per_cycle = std::numeric_limits<double>::quiet_NaN();
    double frequency = std::numeric_limits<double>::quiet_NaN(); ///< Hz
};

StepFit fit_of(const run::CaseSpec& spec, const run::CaseOutcome& outcome,
               const ReduceOptions& options) {
    const auto* result = std::get_if<run::CaseResult>(&outcome);
    if (result == nullptr)
        return {.outcome = StepOutcome::Unstable};
    try {
        const auto fit =
            reduce::fit_ring_down(sample_times(spec), result->tip_deflection, fit_options(options));
        return {StepOutcome::Fitted, fit.decay_per_cycle.value, fit.frequency.value};
    } catch (const core::NumericalError&) {
        return {};
    }
}

/// The case over the record that the study compares.
run::CaseSpec recorded(const TimestepOptions& options, run::CaseSpec spec) {
    const auto per_cycle = static_cast<double>(options.samples_per_cycle);
    // In units of the stem's own period, so that stems of any stiffness are compared alike.
    spec.sample_interval = run::undamped_period(spec) / per_cycle;
    spec.duration = std::round(options.record_cycles * per_cycle) * spec.sample_interval;
    spec.integrator.relative_tolerance = options.reference_tolerance;
    spec.store = run::StoreLevel::Tip;
    spec.heights.clear();
    return spec;
}

/// The fewest steps per sample that keep each step at or below its share of the limit.
std::vector<std::int64_t> steps_per_sample(const TimestepOptions& options,
                                           const run::CaseSpec& spec, double limit) {
    std::vector<std::int64_t> counts;
    for (const double fraction : options.fractions)
        counts.push_back(
            static_cast<std::int64_t>(std::ceil(spec.sample_interval / (fraction * limit))));
    return counts;
}

/// Appends the reference and every step's columns.
void append_comparison(const StudyConfig& config, const run::CaseSpec& point, double limit,
                       const run::Heartbeat& heartbeat, run::Simulator& simulator,
                       std::vector<double>& values) {
    const run::CaseSpec spec = recorded(config.timestep, point);
    const StepFit reference = fit_of(spec, simulator.simulate(spec, heartbeat), config.reduce);
    values.insert(values.end(), {reference.decay_per_cycle, reference.frequency});

    const std::vector<std::int64_t> counts = steps_per_sample(config.timestep, spec, limit);
    const std::vector<run::CaseOutcome> outcomes =
        run::simulate_with_steps(spec, counts, heartbeat);
    for (std::size_t k = 0; k < counts.size(); ++k) {
        const StepFit fit = fit_of(spec, outcomes[k], config.reduce);
        const double step = spec.sample_interval / static_cast<double>(counts[k]);
        values.insert(values.end(),
                      {step, static_cast<double>(fit.outcome), fit.decay_per_cycle, fit.frequency});
    }
}

/// The result columns of a time-step study; a group of them for each fraction.
std::vector<archive::Column> timestep_columns(const TimestepOptions& options) {
    std::vector<archive::Column> columns{
        {"limit_stable", "s", "largest step that was run without gaining energy"},
        {"limit_unstable", "s", "smallest step that was run and gained energy"},
        {"limit_trials", "1", "runs of the bisection"},
        {"limit_transverse", "s", "largest stable step of the linearised transverse motion"},
        {"limit_axial", "s", "largest stable step of the linearised axial motion"},
        {"limit_rule", "s", "the authors' rule 0.95/((1.1 + 2.9 beta) sqrt(k_n/m))"},
        {"bond_time", "s", "sqrt(m/k_n) of a sphere and a bond"},
    };
    if (options.fractions.empty())
        return columns;
    columns.push_back({"reference_decay_per_cycle", "1", "b1/b2 of the implicit run"});
    columns.push_back({"reference_frequency", "Hz", "b2 of the implicit run"});
    for (const double fraction : options.fractions) {
        const auto add = [&](const char* quantity, const char* unit, const char* description) {
            columns.push_back(
                {column_at(quantity, fraction), unit,
                 fmt::format("{} at {} of the linearised limit", description, fraction)});
        };
        add("timestep", "s", "step taken");
        add("outcome", "1", "0 fitted, 1 unstable, 2 no fit of Eq. 1");
        add("decay_per_cycle", "1", "b1/b2");
        add("frequency", "Hz", "b2");
    }
    return columns;
}

} // namespace

archive::PointRecord failed_record(std::int64_t point, std::string_view kind,
                                   const std::string& reason) {
    archive::PointRecord record;
    record.point = point;
    record.failure_kind = kind;
    record.failure_reason = reason;
    return record;
}

std::vector<archive::Column> result_columns(const StudyConfig& config) {
    if (config.kind == StudyKind::Timestep)
        return timestep_columns(config.timestep);
    std::vector<archive::Column> columns{
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
    };
    for (const WorkColumn& work : work_of(config.base.integrator.method))
        columns.push_back({work.name, "1", work.description});
    return columns;
}

std::vector<std::string> work_columns(const StudyConfig& config) {
    std::vector<std::string> names;
    if (config.kind == StudyKind::Vibration)
        for (const WorkColumn& work : work_of(config.base.integrator.method))
            names.emplace_back(work.name);
    return names;
}

reduce::RingDownOptions fit_options(const ReduceOptions& options) {
    reduce::RingDownOptions fit;
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

std::string column_at(std::string_view quantity, double fraction) {
    return fmt::format("{}_at_{}", quantity, fraction);
}

archive::PointRecord make_record(const run::CaseSpec& spec, run::CaseOutcome outcome,
                                 const ReduceOptions& options) {
    if (const auto* failure = std::get_if<run::CaseFailure>(&outcome))
        return failed_record(spec.point, core::to_string(failure->kind), failure->reason);
    run::CaseResult& result = std::get<run::CaseResult>(outcome);

    archive::PointRecord record;
    record.point = spec.point;
    record.completed = true;
    try {
        append_fit(
            reduce::fit_ring_down(sample_times(spec), result.tip_deflection, fit_options(options)),
            record.values);
    } catch (const core::NumericalError& error) {
        // A point without a fit and without a history has no result, which is a failure. A stored
        // history is a result, and can be fitted again with other options.
        if (spec.store == run::StoreLevel::Fit)
            return failed_record(spec.point, core::to_string(error.kind()), error.what());
        record.values.assign(fit_columns, std::numeric_limits<double>::quiet_NaN());
    }
    for (const WorkColumn& work : work_of(spec.integrator.method))
        record.values.push_back(static_cast<double>(result.work.*work.count));
    if (spec.store >= run::StoreLevel::Tip)
        record.tip_deflection = std::move(result.tip_deflection);
    if (spec.store >= run::StoreLevel::Heights)
        record.height_deflection = std::move(result.height_deflection);
    if (spec.store == run::StoreLevel::Full)
        record.positions = std::move(result.positions);
    return record;
}

archive::PointRecord compute_timestep_point(const StudyConfig& config, const run::CaseSpec& spec,
                                            const run::Heartbeat& heartbeat,
                                            run::Simulator& simulator) {
    archive::PointRecord record;
    record.point = spec.point;
    try {
        const run::TimestepLimits limits = run::timestep_limits(spec);
        const run::StabilityBracket bracket = run::search_stable_step(
            spec, limits.published_rule,
            {config.timestep.limit_tolerance, config.timestep.trial_steps}, heartbeat);
        record.values = {
            bracket.stable,           bracket.unstable, static_cast<double>(bracket.trials),
            limits.transverse,        limits.axial,     limits.published_rule,
            run::bond_time(spec.stem)};
        if (!config.timestep.fractions.empty())
            append_comparison(config, spec, limits.linearised(), heartbeat, simulator,
                              record.values);
        record.completed = true;
        return record;
    } catch (const core::NumericalError& error) {
        return failed_record(spec.point, core::to_string(error.kind()), error.what());
    }
}

double explicit_steps_of_point(const StudyConfig& config, const run::CaseSpec& spec) {
    // Four rounds of eight trials find the limit within a per cent.
    constexpr double trials = 32.0;
    const auto lanes = static_cast<double>(run::lanes_per_batch());
    const TimestepOptions& options = config.timestep;
    double steps = trials / lanes * static_cast<double>(options.trial_steps);
    const auto& stem = spec.stem;
    const double steps_of_longest = options.fractions.empty()
                                        ? 0.0
                                        : options.record_cycles / physics::first_frequency(stem) /
                                              run::published_timestep_rule(stem);
    // The rule is near the limit. Lanes run until the one with the smallest step is finished.
    for (std::size_t k = 0; k < options.fractions.size(); k += run::lanes_per_batch())
        steps += steps_of_longest / options.fractions[k];
    return steps;
}

} // namespace culm::study
