// SPDX-License-Identifier: BSD-3-Clause
#include "study/summary/summary.hpp"

#include "core/error.hpp"
#include "study/config/study_config.hpp"
#include "study/execute/point_results.hpp"

#include <cmath>
#include <limits>

#include <fmt/core.h>

namespace culm::study {

namespace {

/// Fitted values that the regressions use; NaN when there is no fit.
struct FittedPoint {
    double decay_per_cycle = std::numeric_limits<double>::quiet_NaN();
    double frequency = std::numeric_limits<double>::quiet_NaN(); ///< Hz
};

/// Failed and missing points have no number.
double sum_of_numbers(const std::vector<double>& values) {
    double sum = 0.0;
    for (const double value : values)
        sum += std::isnan(value) ? 0.0 : value;
    return sum;
}

/// Fits a stored history again; `reason` is set when there is no fit.
FittedPoint fit_again(const archive::StudyFile& file, std::int64_t point,
                      const ReduceOptions& options, std::string& reason) {
    try {
        const auto fit = reduce::fit_ring_down(file.description().times, file.tip_deflection(point),
                                               fit_options(options));
        return {fit.decay_per_cycle, fit.frequency};
    } catch (const core::NumericalError& error) {
        reason = error.what();
        return {};
    }
}

} // namespace

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
    summary.points = file.point_count();
    summary.ranks = std::atoi(provenance_text(file, "ranks").c_str());
    summary.wall_s = std::atof(provenance_text(file, "wall_s").c_str());
    summary.integrator = integrator_text(archived.study.config);
    summary.law = physics::law_name(archived.study.config.base.law);
    for (const std::string& name : work_columns(archived.study.config))
        summary.work.emplace_back(name, sum_of_numbers(file.result(name)));
    summary.reduce = refit.value_or(archived.study.config.reduce);
    summary.reduce.significance = significance.value_or(summary.reduce.significance);
    const std::vector<double> stored_decays = file.result("decay_per_cycle");
    const std::vector<double> stored_frequencies = file.result("frequency");
    for (std::int64_t point = 0; point < summary.points; ++point) {
        const run::CaseSpec spec =
            case_of_point(archived.study.config, archived.study.design, point);
        const auto k = static_cast<std::size_t>(point);
        FittedPoint fit{stored_decays[k], stored_frequencies[k]};
        if (file.status(point) == archive::PointStatus::Completed) {
            std::string reason;
            // An archived history without a fit is fitted again to obtain the reason.
            if (refit || !std::isfinite(fit.frequency))
                fit = fit_again(file, point, summary.reduce, reason);
            if (reason.empty())
                ++summary.completed;
            else
                summary.failed.push_back(
                    {point, core::to_string(core::FailureKind::FitFailed), reason});
        } else if (file.status(point) == archive::PointStatus::Missing) {
            fit = {};
            summary.missing.push_back(point);
        } else {
            fit = {};
            summary.failed.push_back({point, file.failure_kind(point), file.failure_reason(point)});
        }
        summary.youngs_modulus.push_back(spec.stem.bond_youngs_modulus);
        summary.bond_damping.push_back(spec.stem.bond_damping);
        summary.decay_per_cycle.push_back(fit.decay_per_cycle);
        summary.frequency.push_back(fit.frequency);
    }
    summary.regression = reduce::regress_study(
        {summary.youngs_modulus, summary.bond_damping, summary.decay_per_cycle, summary.frequency},
        summary.reduce.significance);
    summary.replicates =
        summarise_replicates(archived.study, summary.decay_per_cycle, summary.frequency);
    return summary;
}

} // namespace culm::study
