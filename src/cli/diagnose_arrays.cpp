// SPDX-License-Identifier: BSD-3-Clause
#include "cli/diagnose_arrays.hpp"

#include "cli/motion_arrays.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace culm::cli {

void write_diagnosis_arrays(const std::filesystem::path& file, const diagnose::Diagnosis& diagnosis,
                            std::span<const measure::Measurement> recordings) {
    std::vector<const fit::Fit*> models{&diagnosis.baseline};
    if (!diagnosis.final_fit.failed() && diagnosis.final_fit.names != diagnosis.baseline.names)
        models.push_back(&diagnosis.final_fit);
    std::vector<archive::GroupTexts> groups{
        {"", {{"format", "culm diagnosis arrays"}, {"version", "1.0"}}}};
    std::vector<archive::NamedArray> arrays;
    for (std::size_t k = 0; k < recordings.size(); ++k) {
        const std::string recording = fmt::format("recording_{}", k);
        groups.push_back({recording, {{"id", recordings[k].stem.id}}});
        for (std::size_t m = 0; m < models.size(); ++m) {
            if (k >= models[m]->parts.size())
                continue;
            const fit::RecordingFit& fit = models[m]->parts[k];
            if (m == 0)
                add_measured(arrays, recording + "/", fit, recordings[k]);
            const std::string group = fmt::format("{}/model_{}", recording, m);
            groups.push_back(
                {group, {{"model", fmt::format("{}", fmt::join(models[m]->names, " + "))}}});
            add_predicted(arrays, group, fit);
        }
    }
    archive::write_array_file(file, groups, arrays);
}

} // namespace culm::cli
