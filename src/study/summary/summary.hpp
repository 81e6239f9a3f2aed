// SPDX-License-Identifier: BSD-3-Clause
// Results of a study: the regressions and the failed points, as plain data, JSON and tables.
#pragma once

#include "archive/study/file.hpp"
#include "reduce/study_regression.hpp"
#include "study/execute/plan.hpp"
#include "study/execute/study_folder.hpp"
#include "study/summary/replicate_summary.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace culm::study {

struct FailedPoint {
    std::int64_t point = 0;
    std::string kind;
    std::string reason;
};

struct StudySummary {
    std::int64_t points = 0;
    std::int64_t completed = 0;
    std::vector<FailedPoint> failed;
    std::vector<std::int64_t> missing; ///< points that were not computed (a merged archive)
    int ranks = 1;
    double wall_s = 0.0;
    std::string integrator;                           ///< method and tolerance or step
    std::string law;                                  ///< of the bonds' damping
    std::vector<std::pair<std::string, double>> work; ///< of the integrator on all points
    ReduceOptions reduce;                             ///< as used
    std::vector<double> youngs_modulus;               ///< (points), Pa
    std::vector<double> bond_damping;                 ///< (points)
    std::vector<double> decay_per_cycle;              ///< (points), NaN where there is no fit
    std::vector<double> frequency;                    ///< (points), Hz
    reduce::StudyRegression regression;
    std::optional<ReplicateSummary> replicates; ///< of a study with factors
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

/// Reduces a study of kind Vibration (core::InputError for another). With `refit` the stored tip
/// histories are fitted again under these options (core::InputError when the study stores none);
/// without, the fits in the archive are used. `significance` is that of the F-tests in either case;
/// by default the options' or the study's.
[[nodiscard]] StudySummary reduce_study(const ArchivedStudy& archived,
                                        const std::optional<ReduceOptions>& refit,
                                        std::optional<double> significance = std::nullopt);

} // namespace culm::study
