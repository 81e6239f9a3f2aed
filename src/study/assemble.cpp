// SPDX-License-Identifier: BSD-3-Clause
#include "study/assemble.hpp"

#include "archive/journal/read.hpp"
#include "archive/study/file.hpp"
#include "archive/study/writer.hpp"
#include "core/error.hpp"
#include "study/point_results.hpp"

#include <optional>
#include <system_error>

#include <fmt/core.h>

namespace culm::study {

archive::StudyDescription
description_of(const Study& study,
               const std::vector<std::pair<std::string, std::string>>& provenance) {
    const run::CaseSpec& base = study.config.base;
    archive::StudyDescription description;
    description.points = study.design.point_count();
    for (const Factor& factor : study.design.factors) {
        const std::string_view unit = factor.parameter->unit.name;
        description.factors.push_back({std::string(factor.parameter->key),
                                       unit.empty() ? "1" : std::string(unit),
                                       std::string(factor.parameter->meaning)});
    }
    description.results = result_columns(study.config);
    description.stored.tip = base.store >= run::StoreLevel::Tip;
    description.stored.heights = base.store >= run::StoreLevel::Heights && !base.heights.empty();
    description.stored.positions = base.store == run::StoreLevel::Full;
    if (description.stored.tip)
        description.times = sample_times(base);
    if (description.stored.heights)
        description.heights = base.heights;
    description.spheres = base.stem.sphere_count;
    description.identity = study.config.identity();
    description.author = "culm";
    for (const auto& [name, text] : provenance)
        if (name == "version")
            description.version = text;
    description.provenance = provenance;
    description.trajectory_compression = study.config.trajectory_compression;
    return description;
}

std::vector<double> design_in_config_units(const Design& design) {
    std::vector<double> values = design.values;
    for (std::size_t k = 0; k < values.size(); ++k)
        values[k] = design.factors[k % design.factors.size()].parameter->unit.from_si(values[k]);
    return values;
}

bool assemble_archive(const Study& study, const StudyFolder& folder,
                      const std::vector<std::pair<std::string, std::string>>& provenance) {
    const std::string identity = study.config.identity();
    archive::JournalIndex index(archive::scan_journal_folder(folder.journals(), identity));
    std::optional<archive::StudyFile> older;
    if (is_there(folder.archive()))
        older.emplace(folder.archive());
    const auto is_known = [&](std::int64_t point) {
        return index.contains(point) ||
               (older && older->status(point) != archive::PointStatus::Missing);
    };
    for (std::int64_t point = 0; point < study.design.point_count(); ++point)
        if (!is_known(point))
            return false;
    archive::write_study_file(folder.archive(), description_of(study, provenance),
                              design_in_config_units(study.design),
                              [&](std::int64_t point) -> std::optional<archive::PointRecord> {
                                  if (index.contains(point))
                                      return index.find_record(point);
                                  return older->record(point);
                              });
    std::error_code error;
    std::filesystem::remove_all(folder.journals(), error);
    if (error)
        throw core::StorageError(
            fmt::format("cannot remove {}, whose points are in the archive: {}",
                        folder.journals().string(), error.message()));
    return true;
}

} // namespace culm::study
