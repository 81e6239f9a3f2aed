// SPDX-License-Identifier: BSD-3-Clause
// Results of a study as plain data: of vibrations the regressions, and the spread of b1 and b2 with
// the factors that cause it; of time steps the limits, their laws, and the errors of the steps
// below them; the failed points of both. And an archive as CSV tables for other programs.
#pragma once

#include "archive/study/file.hpp"
#include "reduce/population_statistics.hpp"
#include "reduce/study_regression.hpp"
#include "reduce/variance_shares.hpp"
#include "study/execute/plan.hpp"
#include "study/execute/point_results.hpp"
#include "study/execute/study_folder.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace culm::study {

struct FailedPoint {
    std::int64_t point = 0;
    std::string kind;
    std::string reason;
};

/// measure::stem_line() of a study's first point.
[[nodiscard]] std::string first_stem(const Study& study);

/// The members of the summaries of all kinds of studies.
struct SummaryOfRun {
    std::int64_t points = 0;
    std::string stem; ///< first_stem()
    std::vector<FailedPoint> failed;
    std::vector<std::int64_t> missing; ///< points that were not computed (a merged archive)
    int ranks = 1;
    double wall_s = 0.0;

    /// Sets all but `failed` and `missing`.
    void read_run(const archive::StudyFile& file, const Study& study);
    /// Adds a point without a result to `failed` or `missing`.
    void add_unanswered(const archive::StudyFile& file, std::int64_t point);
};

/// Opens a study's archive together with the study that made it.
struct ArchivedStudy {
    archive::StudyFile file;
    Study study;
};
/// Throws core::InputError when the folder holds no complete archive (and says what to do).
[[nodiscard]] ArchivedStudy open_archive(const StudyFolder& folder);

/// The study that an archive with this provenance describes.
[[nodiscard]] Study archived_study(const archive::Texts& provenance);
/// A text of the archive's provenance; empty if there is none of that name.
[[nodiscard]] inline std::string provenance_text(const archive::StudyFile& file,
                                                 std::string_view name) {
    return archive::text_named(name, file.description().provenance);
}

/// Spread of one fitted quantity.
struct ResponseSpread {
    std::string name; ///< "decay_per_cycle" or "frequency", as the archive's columns
    reduce::SampleSummary population;
    std::optional<reduce::VarianceComponents> components; ///< of stems with several tests
    std::optional<reduce::VarianceShares> variance_shares;
};

/// Factors that depend on each other have one share; others are alone.
struct FactorGroup {
    std::string name; ///< the keys, joined by ", "
    std::vector<std::string> factors;
};

struct ReplicateSummary {
    std::vector<ResponseSpread> responses;
    std::vector<FactorGroup> groups; ///< in the order of the shares
    bool has_distributions = false;  ///< does any factor describe a population?
    std::string no_shares_reason;    ///< one sentence, if there are none
};

/// Nothing for a study without factors. `decay_per_cycle` and `frequency` (Hz) have the shape
/// (points), NaN where there is no fit.
[[nodiscard]] std::optional<ReplicateSummary>
summarise_replicates(const Study& study, std::span<const double> decay_per_cycle,
                     std::span<const double> frequency);

struct StudySummary : SummaryOfRun {
    std::int64_t completed = 0;
    std::string integrator;    ///< method and tolerance or step
    std::string law;           ///< of the bonds' damping
    bool is_published = false; ///< Do Eqs. 12 and 13 belong to this stem and law?
    std::vector<std::pair<std::string, double>> work; ///< of the integrator on all points
    ReduceOptions reduce;                             ///< as used
    std::vector<double> youngs_modulus;               ///< (points), Pa
    std::vector<double> bond_damping;                 ///< (points)
    std::vector<double> decay_per_cycle;              ///< (points), NaN where there is no fit
    std::vector<double> frequency;                    ///< (points), Hz
    reduce::StudyRegression regression;
    std::optional<ReplicateSummary> replicates; ///< of a study with factors
};

/// Reduces a study of kind Vibration (core::InputError for another). With `refit` the stored tip
/// histories are fitted again under these options (core::InputError when the study stores none);
/// without, the fits in the archive are used. `significance` is that of the F-tests in either case;
/// by default the options' or the study's.
[[nodiscard]] StudySummary reduce_study(const ArchivedStudy& archived,
                                        const std::optional<ReduceOptions>& refit,
                                        std::optional<double> significance = std::nullopt);

/// b1 and b2 of one stem at one step. Errors are (at this step − converged)/converged; NaN where
/// there is no fit or no converged value.
struct StepResult {
    double step = 0.0; ///< s
    StepOutcome outcome = StepOutcome::NoFit;
    double decay_per_cycle = 0.0;
    double frequency = 0.0; ///< Hz
    double decay_error = 0.0;
    double frequency_error = 0.0;
};

/// One completed point.
struct TimestepStem {
    std::int64_t point = 0;
    double youngs_modulus = 0.0; ///< Pa
    double bond_damping = 0.0;
    double stable = 0.0;              ///< bisected, s
    double unstable = 0.0;            ///< bisected, s
    double transverse = 0.0;          ///< linearised, s
    double axial = 0.0;               ///< linearised, s
    double rule = 0.0;                ///< the authors', s
    double bond_time = 0.0;           ///< √(m/k_n), s
    double reference_decay = 0.0;     ///< b1 per cycle of the implicit run
    double reference_frequency = 0.0; ///< b2 of the implicit run, Hz
    double converged_decay = 0.0;     ///< b1 per cycle for steps towards zero
    double converged_frequency = 0.0; ///< b2 for steps towards zero, Hz
    std::vector<StepResult> steps;    ///< one per fraction

    [[nodiscard]] double limit() const { return 0.5 * (stable + unstable); }
    [[nodiscard]] double linearised() const { return transverse < axial ? transverse : axial; }
};

struct TimestepSummary : SummaryOfRun {
    std::vector<TimestepStem> stems; ///< the completed points

    /// Stems with this outcome at the fraction of that index.
    [[nodiscard]] std::ptrdiff_t count(std::size_t fraction, StepOutcome outcome) const {
        return std::ranges::count_if(stems, [&](const TimestepStem& stem) {
            return stem.steps[fraction].outcome == outcome;
        });
    }

    TimestepOptions options;
    reduce::TimestepRegression regression; ///< of the bisected limits
};

/// The value at step zero of the parabola (of the line) through the values at the three (two)
/// smallest steps: Richardson's extrapolation. NaN for fewer than two. Pairs with a value that is
/// not finite are ignored.
[[nodiscard]] double extrapolated_to_zero(const std::vector<double>& steps,
                                          const std::vector<double>& values);

/// Reduces the archive of a time-step study. Throws core::InputError for another kind of study.
[[nodiscard]] TimestepSummary reduce_timestep_study(const ArchivedStudy& archived);

} // namespace culm::study
