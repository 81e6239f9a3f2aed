// SPDX-License-Identifier: BSD-3-Clause
#include "cli/study_for_calibration.hpp"

#include "study/summary/summary.hpp"

#include <algorithm>

namespace culm::cli {
namespace {

reduce::PredictorRange range_of(const std::vector<double>& values) {
    if (values.empty())
        return {};
    const auto [lowest, highest] = std::ranges::minmax(values);
    return {lowest, highest};
}

} // namespace

calibrate::StudyForCalibration study_for_calibration(const std::string& folder) {
    const study::ArchivedStudy archived = study::open_archive(study::StudyFolder(folder));
    study::StudySummary summary = study::reduce_study(archived, std::nullopt);
    calibrate::StudyForCalibration found;
    found.name = folder;
    found.base = archived.study.config.base;
    for (const study::Factor& factor : archived.study.design.factors)
        if (const std::string key(factor.parameter->key);
            !key.starts_with("bond_youngs_modulus") && key != "bond_damping")
            found.factors.push_back(key);
    found.window = summary.reduce.window;
    found.bond_youngs_modulus = range_of(summary.youngs_modulus);
    found.bond_damping = range_of(summary.bond_damping);
    found.regression = std::move(summary.regression);
    return found;
}

} // namespace culm::cli
