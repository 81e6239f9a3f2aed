// SPDX-License-Identifier: BSD-3-Clause
// The JSON of culm archive info, status and verify.
#include "cli/archive_text.hpp"

#include <nlohmann/json.hpp>

namespace culm::cli {
namespace {

using nlohmann::ordered_json;
using study::FolderState;

ordered_json columns_json(const std::vector<archive::Column>& columns) {
    ordered_json list = ordered_json::array();
    for (const archive::Column& column : columns)
        list.push_back({{"name", column.name}, {"unit", column.unit}});
    return list;
}

ordered_json pairs_json(const std::vector<std::pair<std::string, std::string>>& entries) {
    ordered_json object = ordered_json::object();
    for (const auto& [name, text] : entries)
        object[name] = text;
    return object;
}

ordered_json archive_json(const FolderState& state) {
    ordered_json json = {{"bytes", state.archive_bytes}};
    if (state.archive) {
        const archive::StudyDescription& description = *state.archive;
        json["culm"] = description.version;
        json["factors"] = columns_json(description.factors);
        json["results"] = columns_json(description.results);
        json["stored"] = {{"tip", description.stored.tip},
                          {"heights", description.stored.heights},
                          {"positions", description.stored.positions}};
        json["samples"] = description.times.size();
        json["heights_m"] = description.heights;
        json["spheres"] = description.spheres;
        json["provenance"] = pairs_json(description.provenance);
    }
    if (state.verification) {
        json["datasets"] = state.verification->datasets;
        json["chunks"] = state.verification->chunks;
        json["damaged"] = ordered_json::array();
        for (const archive::DamagedDataset& dataset : state.verification->damaged)
            json["damaged"].push_back({{"dataset", dataset.name},
                                       {"damaged_chunks", dataset.damaged_chunks},
                                       {"chunks", dataset.chunks},
                                       {"reason", dataset.reason}});
    }
    return json;
}

ordered_json journal_json(const study::JournalState& journal) {
    const archive::JournalScan& scan = journal.scan;
    return {{"file", scan.file},
            {"bytes", scan.size},
            {"outcomes", scan.entries.size()},
            {"is_written_now", journal.is_locked},
            {"age_s", journal.age_s},
            {"torn_tail_bytes", scan.torn_tail_bytes},
            {"skipped_bytes", scan.skipped_bytes},
            {"damaged_regions", scan.damaged_regions},
            {"corrupt_records", scan.corrupt_records}};
}

} // namespace

ordered_json to_json(const FolderState& state) {
    ordered_json json;
    if (state.points) {
        const study::PointCounts counts = state.counts();
        json["points"] = {{"total", counts.total},
                          {"completed", counts.completed},
                          {"failed", counts.failed},
                          {"missing", counts.missing}};
        json["missing_points"] = points_with(state, archive::PointStatus::Missing);
        json["failed_points"] = points_with(state, archive::PointStatus::Failed);
    } else {
        json["points"] = nullptr;
    }
    json["is_running"] = state.is_running();
    json["archive"] = state.archive_bytes > 0 || state.archive ? archive_json(state) : nullptr;
    json["journals"] = ordered_json::array();
    for (const study::JournalState& journal : state.journals)
        json["journals"].push_back(journal_json(journal));
    json["repeated_outcomes"] = state.repeated_outcomes;
    json["unfinished_starts"] = ordered_json::array();
    for (const auto& [point, times] : state.unfinished_starts)
        json["unfinished_starts"].push_back({{"point", point}, {"times", times}});
    if (state.note)
        json["run"] = {{"name", state.note->name},
                       {"start", state.note->start},
                       {"ranks", state.note->ranks},
                       {"config_file", state.note->config_file},
                       {"provenance", pairs_json(state.note->provenance)}};
    json["problems"] = state.problems;
    if (state.verification || !state.archive)
        json["is_whole"] = state.is_whole();
    return json;
}

} // namespace culm::cli
