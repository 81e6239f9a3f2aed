// SPDX-License-Identifier: BSD-3-Clause
#include "study/summary/summary.hpp"

#include "archive/study/description.hpp"
#include "archive/study/file.hpp"
#include "core/error.hpp"
#include "core/user_files.hpp"
#include "study/config/study_config.hpp"
#include "study/execute/point_results.hpp"

#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include <fmt/core.h>
#include <fmt/format.h>

namespace culm::study {

namespace {

/// Failed and missing points have no number.
double sum_of_numbers(const std::vector<double>& values) {
    double sum = 0.0;
    for (const double value : values)
        sum += std::isnan(value) ? 0.0 : value;
    return sum;
}

/// Fits a stored history again. Returns the reason if there is no fit, whose numbers are then NaN.
std::string fit_again(const archive::StudyFile& file, std::int64_t point, StudySummary& summary) {
    reduce::RingDownFit fit;
    std::string reason;
    fit.decay_per_cycle.value = fit.frequency.value = std::numeric_limits<double>::quiet_NaN();
    try {
        fit = reduce::fit_ring_down(file.description().times, file.tip_deflection(point),
                                    fit_options(summary.reduce));
    } catch (const core::NumericalError& error) {
        reason = error.what();
    }
    summary.decay_per_cycle[static_cast<std::size_t>(point)] = fit.decay_per_cycle.value;
    summary.frequency[static_cast<std::size_t>(point)] = fit.frequency.value;
    return reason;
}

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
    std::vector<reduce::TimestepPoint> points;
    points.reserve(stems.size());
    for (const TimestepStem& stem : stems)
        points.push_back({stem.youngs_modulus, stem.bond_damping, stem.bond_time, stem.limit()});
    return reduce::regress_timesteps(points);
}

/// Is it the stem of Table 1 under the published law, with no other factor than Y and β?
bool is_published(const StudyConfig& config) {
    const physics::StemParameters<double>& stem = config.base.stem;
    const physics::StemParameters<double> published;
    const auto is_near = [](double value, double other) {
        return std::abs(value - other) <= 1e-3 * std::abs(other);
    };
    return physics::law_name(config.base.law) == "schramm2019" &&
           config.effects.selected().empty() && stem.sphere_count == published.sphere_count &&
           is_near(stem.sphere_diameter, published.sphere_diameter) &&
           is_near(stem.bond_length, published.bond_length) &&
           is_near(stem.bond_outer_diameter, published.bond_outer_diameter) &&
           stem.bond_inner_diameter == 0.0 && is_near(stem.density, published.density) &&
           std::ranges::all_of(config.factors, [](const Factor& each) {
               return each.parameter->key.starts_with("bond_youngs_modulus") ||
                      each.parameter->key.starts_with("bond_damping");
           });
}

} // namespace

std::string first_stem(const Study& study) {
    const run::CaseSpec spec = case_of_point(study.config, study.design, 0);
    return measure::stem_line(run::described_stem(spec), spec.stem.bond_youngs_modulus);
}

void SummaryOfRun::read_run(const archive::StudyFile& file, const Study& study) {
    points = file.point_count();
    stem = first_stem(study);
    ranks = std::atoi(provenance_text(file, "ranks").c_str());
    wall_s = std::atof(provenance_text(file, "wall_s").c_str());
}

void SummaryOfRun::add_unanswered(const archive::StudyFile& file, std::int64_t point) {
    if (file.status(point) == archive::PointStatus::Missing)
        missing.push_back(point);
    else
        failed.push_back({point, file.failure_kind(point), file.failure_reason(point)});
}

Study archived_study(const archive::Texts& provenance) {
    return parse_study(archive::text_named("config", provenance),
                       archive::text_named("config_file", provenance),
                       files_from_text(archive::text_named("config_files", provenance)));
}

ArchivedStudy open_archive(const StudyFolder& folder) {
    if (!is_there(folder.archive())) {
        const bool has_journals = is_there(folder.journals());
        throw core::InputError(
            has_journals
                ? fmt::format("{}: the study is not complete; run `culm run STUDY.toml -o {} "
                              "--resume` first",
                              folder.path().string(), folder.path().string())
                : fmt::format("{}: there is no study here (study.h5 is missing)",
                              folder.path().string()));
    }
    archive::StudyFile file(folder.archive());
    Study study = archived_study(file.description().provenance);
    return {std::move(file), std::move(study)};
}

StudySummary reduce_study(const ArchivedStudy& archived, const std::optional<ReduceOptions>& refit,
                          std::optional<double> significance) {
    const archive::StudyFile& file = archived.file;
    if (archived.study.config.kind != StudyKind::Vibration)
        throw core::InputError(fmt::format("{}: a time-step study holds no fits from which stems "
                                           "could be calibrated (study.kind = \"timestep\")",
                                           file.path().string()));
    if (refit && !file.description().stored.tip)
        throw core::InputError(fmt::format("{}: the study stores no tip histories (study.store = "
                                           "\"fit\"), so they cannot be fitted again",
                                           file.path().string()));
    StudySummary summary;
    summary.read_run(file, archived.study);
    summary.integrator = integrator_text(archived.study.config);
    summary.law = physics::law_name(archived.study.config.base.law);
    summary.is_published = is_published(archived.study.config);
    for (const std::string& name : work_columns(archived.study.config))
        summary.work.emplace_back(name, sum_of_numbers(file.result(name)));
    summary.reduce = refit.value_or(archived.study.config.reduce);
    summary.reduce.significance = significance.value_or(summary.reduce.significance);
    summary.decay_per_cycle = file.result("decay_per_cycle");
    summary.frequency = file.result("frequency");
    for (std::int64_t point = 0; point < summary.points; ++point) {
        const run::CaseSpec spec =
            case_of_point(archived.study.config, archived.study.design, point);
        if (file.status(point) == archive::PointStatus::Completed) {
            std::string reason;
            // An archived history without a fit is fitted again to obtain the reason.
            if (refit || !std::isfinite(summary.frequency[static_cast<std::size_t>(point)]))
                reason = fit_again(file, point, summary);
            if (reason.empty())
                ++summary.completed;
            else
                summary.failed.push_back(
                    {point, core::to_string(core::FailureKind::FitFailed), reason});
        } else {
            summary.add_unanswered(file, point);
        }
        summary.youngs_modulus.push_back(spec.stem.bond_youngs_modulus);
        summary.bond_damping.push_back(spec.stem.bond_damping);
    }
    summary.regression = reduce::regress_study(
        {summary.youngs_modulus, summary.bond_damping, summary.decay_per_cycle, summary.frequency},
        summary.reduce.significance);
    summary.replicates =
        summarise_replicates(archived.study, summary.decay_per_cycle, summary.frequency);
    return summary;
}

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
    summary.read_run(file, archived.study);
    summary.options = config.timestep;
    std::map<std::string, std::vector<double>> columns; // read once
    for (const archive::Column& column : file.description().results)
        columns[column.name] = file.result(column.name);
    const auto results = [&](const std::string& name, std::int64_t point) {
        return columns.at(name)[static_cast<std::size_t>(point)];
    };
    for (std::int64_t point = 0; point < summary.points; ++point)
        if (file.status(point) == archive::PointStatus::Completed)
            summary.stems.push_back(read_stem(
                results, case_of_point(config, archived.study.design, point), config.timestep));
        else
            summary.add_unanswered(file, point);
    summary.regression = regression_of(summary.stems);
    return summary;
}

} // namespace culm::study
