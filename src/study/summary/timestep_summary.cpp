// SPDX-License-Identifier: BSD-3-Clause
#include "study/summary/timestep_summary.hpp"

#include "core/error.hpp"

#include <cmath>
#include <cstdlib>
#include <functional>
#include <limits>
#include <map>
#include <string>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

namespace culm::study {

namespace {

constexpr std::size_t richardson_steps = 3;

/// Gives a result of a point by the name of its column.
using Results = std::function<double(const std::string& name, std::int64_t point)>;

void read_steps(const Results& results, const std::vector<double>& fractions, TimestepStem& stem) {
    std::vector<double> steps;
    std::vector<double> decays;
    std::vector<double> frequencies;
    for (const double fraction : fractions) {
        const auto at = [&](const char* quantity) {
            return results(column_at(quantity, fraction), stem.point);
        };
        StepResult step;
        step.step = at("timestep");
        step.outcome = static_cast<StepOutcome>(std::lround(at("outcome")));
        step.decay_per_cycle = at("decay_per_cycle");
        step.frequency = at("frequency");
        step.predicted_decay_error = at("predicted_decay_error");
        step.predicted_frequency_error = at("predicted_frequency_error");
        stem.steps.push_back(step);
        steps.push_back(step.step);
        decays.push_back(step.decay_per_cycle);
        frequencies.push_back(step.frequency);
    }
    stem.converged_decay = extrapolated_to_zero(steps, decays);
    stem.converged_frequency = extrapolated_to_zero(steps, frequencies);
    for (StepResult& step : stem.steps) {
        step.decay_error = step.decay_per_cycle / stem.converged_decay - 1.0;
        step.frequency_error = step.frequency / stem.converged_frequency - 1.0;
    }
}

TimestepStem read_stem(const Results& results, const run::CaseSpec& spec,
                       const TimestepOptions& options) {
    TimestepStem stem;
    stem.point = spec.point;
    stem.youngs_modulus = spec.stem.bond_youngs_modulus;
    stem.bond_damping = spec.stem.bond_damping;
    stem.stable = results("limit_stable", spec.point);
    stem.unstable = results("limit_unstable", spec.point);
    stem.transverse = results("limit_transverse", spec.point);
    stem.axial = results("limit_axial", spec.point);
    stem.rule = results("limit_rule", spec.point);
    stem.bond_time = results("bond_time", spec.point);
    if (!options.fractions.empty()) {
        stem.reference_decay = results("reference_decay_per_cycle", spec.point);
        stem.reference_frequency = results("reference_frequency", spec.point);
        read_steps(results, options.fractions, stem);
    }
    return stem;
}

reduce::TimestepRegression regression_of(const std::vector<TimestepStem>& stems) {
    std::vector<double> moduli;
    std::vector<double> dampings;
    std::vector<double> bond_times;
    std::vector<double> limits;
    for (const TimestepStem& stem : stems) {
        moduli.push_back(stem.youngs_modulus);
        dampings.push_back(stem.bond_damping);
        bond_times.push_back(stem.bond_time);
        limits.push_back(stem.limit());
    }
    return reduce::regress_timesteps({moduli, dampings, bond_times, limits});
}

} // namespace

double extrapolated_to_zero(const std::vector<double>& steps, const std::vector<double>& values) {
    std::map<double, double> known; // by rising step
    for (std::size_t k = 0; k < steps.size(); ++k)
        if (std::isfinite(values[k]) && steps[k] > 0.0)
            known.emplace(steps[k], values[k]);
    if (known.size() < 2)
        return std::numeric_limits<double>::quiet_NaN();
    while (known.size() > richardson_steps)
        // The smallest steps: the expansion in powers of the step holds for them.
        known.erase(std::prev(known.end()));
    // Richardson's extrapolation to the step zero through all of these points.
    // Lagrange's polynomial at zero, as a correction of the value at the smallest step: the values
    // agree in many digits, which their weighted sum would lose.
    const double nearest = known.begin()->second;
    double correction = 0.0;
    for (const auto& [step, value] : known) {
        double weight = 1.0;
        for (const auto& [other, ignored] : known)
            if (other != step)
                weight *= other / (other - step);
        correction += weight * (value - nearest);
    }
    return nearest + correction;
}

TimestepSummary reduce_timestep_study(const ArchivedStudy& archived) {
    const archive::StudyFile& file = archived.file;
    const StudyConfig& config = archived.study.config;
    if (config.kind != StudyKind::Timestep)
        throw core::InputError(
            fmt::format("{}: this is not a time-step study (study.kind)", file.path().string()));
    TimestepSummary summary;
    summary.points = file.point_count();
    summary.ranks = std::atoi(provenance_text(file, "ranks").c_str());
    summary.wall_s = std::atof(provenance_text(file, "wall_s").c_str());
    summary.options = config.timestep;
    std::map<std::string, std::vector<double>> columns; // read once
    for (const archive::Column& column : file.description().results)
        columns[column.name] = file.result(column.name);
    const auto results = [&](const std::string& name, std::int64_t point) {
        return columns.at(name)[static_cast<std::size_t>(point)];
    };
    for (std::int64_t point = 0; point < summary.points; ++point) {
        if (file.status(point) == archive::PointStatus::Completed)
            summary.stems.push_back(read_stem(
                results, case_of_point(config, archived.study.design, point), config.timestep));
        else if (file.status(point) == archive::PointStatus::Missing)
            summary.missing.push_back(point);
        else
            summary.failed.push_back({point, file.failure_kind(point), file.failure_reason(point)});
    }
    summary.regression = regression_of(summary.stems);
    return summary;
}

} // namespace culm::study
