// SPDX-License-Identifier: BSD-3-Clause
#include "core/describe.hpp"
#include "present/study/study.hpp"
#include "present/text.hpp"
#include "study/execute/folder_state.hpp"

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <map>
#include <ranges>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

namespace culm::present {
namespace {

using archive::PointStatus;
using study::FolderState;

/// Points of this status, ascending; empty if the points are unknown.
std::vector<std::int64_t> points_with(const FolderState& state, PointStatus status) {
    std::vector<std::int64_t> found;
    if (state.points)
        for (std::size_t k = 0; k < state.points->size(); ++k)
            if ((*state.points)[k] == status)
                found.push_back(static_cast<std::int64_t>(k));
    return found;
}

std::string counts_text(const FolderState& state) {
    if (!state.points)
        return "points    their number is unknown: no study.h5 and no journal/study.json can be "
               "read\n";
    const study::PointCounts counts = state.counts();
    return fmt::format("points    {}: {} completed, {} failed, {} missing\n", counts.total,
                       counts.completed, counts.failed, counts.missing);
}

std::string columns_text(const std::vector<archive::Column>& columns) {
    const auto text = [](const archive::Column& column) {
        return column.unit == "1" ? column.name : fmt::format("{} ({})", column.name, column.unit);
    };
    return columns.empty()
               ? "none"
               : fmt::format("{}", fmt::join(columns | std::views::transform(text), ", "));
}

std::string histories_text(const archive::StudyDescription& description) {
    std::vector<std::string> kinds;
    if (description.stored.tip)
        kinds.emplace_back("tip");
    if (description.stored.heights)
        kinds.push_back(fmt::format("{} heights", description.heights.size()));
    if (description.stored.positions)
        kinds.push_back(fmt::format("trajectories of {} spheres", description.spheres));
    if (kinds.empty())
        return "none";
    return fmt::format("{}; {} samples up to {:g} s", fmt::join(kinds, ", "),
                       description.times.size(),
                       description.times.empty() ? 0.0 : description.times.back());
}

/// For long texts, for example the configuration, only the size is shown.
std::string provenance_text(const archive::Texts& entries) {
    constexpr std::size_t longest = 200;
    std::string text;
    for (const auto& [name, content] : entries) {
        const bool is_short = content.size() <= longest && content.find('\n') == std::string::npos;
        text += fmt::format("    {:<12} {}\n", name,
                            is_short ? content : fmt::format("({} bytes)", content.size()));
    }
    return text;
}

std::string journals_text(const FolderState& state) {
    std::size_t records = 0;
    for (const study::JournalState& journal : state.journals)
        records += journal.scan.entries.size();
    return fmt::format(
        "journals  {} with {} outcomes, {}{}\n", state.journals.size(), records,
        bytes_text(static_cast<double>(state.journal_bytes)),
        state.repeated_outcomes == 0
            ? std::string()
            : fmt::format("; {} of a point that has another one", state.repeated_outcomes));
}

std::string unfinished_text(const FolderState& state) {
    const std::map<std::int64_t, int> starts = state.unfinished_starts();
    if (starts.empty())
        return {};
    const int most = std::ranges::max(starts | std::views::values);
    const auto points = starts | std::views::keys;
    std::string text = fmt::format("started   {} without an outcome: {}\n", starts.size(),
                                   ranges_text({points.begin(), points.end()}));
    if (most > 1)
        text += fmt::format("          up to {} times: processes died while they computed them\n",
                            most);
    return text;
}

std::int64_t rank_of(const study::JournalState& journal) {
    return std::atoll(&journal.scan.file[journal.scan.file.rfind('-') + 1]);
}

/// What the ranks of a running study do, for how long, and why they wait: first those whose
/// journals have not changed for the longest time. The journals have the numbers of the ranks.
std::string ranks_text(const FolderState& state) {
    constexpr std::size_t most = 16;
    std::vector<const study::JournalState*> ranks; // their scans may hold millions of entries
    for (const study::JournalState& journal : state.journals)
        if (journal.is_locked)
            ranks.push_back(&journal);
    std::ranges::stable_sort(ranks, std::ranges::greater{}, &study::JournalState::age_s);
    const std::int64_t remaining =
        state.counts().missing - static_cast<std::int64_t>(state.unfinished_starts().size());
    const std::string reason =
        remaining <= 0 ? "the other ranks compute all remaining points"
                       : counted(remaining, "point") +
                             " not begun, which another rank holds or which would end too late";
    std::string text;
    for (const study::JournalState* rank : ranks | std::views::take(most)) {
        const double age = std::max(0.0, rank->age_s);
        text += fmt::format("rank {:<4} {}\n", rank_of(*rank),
                            rank->is_waiting() ? fmt::format("waits for {:.0f} s: {}", age, reason)
                                               : fmt::format("computes {} for {:.0f} s",
                                                             ranges_text(rank->computing), age));
    }
    if (ranks.size() > most)
        text += fmt::format("          … and {} more ranks\n", ranks.size() - most);
    return text;
}

std::string damage_text(const study::JournalState& journal) {
    const archive::JournalScan& scan = journal.scan;
    return fmt::format("damaged   {}: {} bytes skipped in {} places, {} bytes of a torn tail, {} "
                       "records with a wrong checksum\n",
                       scan.file, scan.skipped_bytes, scan.damaged_regions, scan.torn_tail_bytes,
                       scan.corrupt_records);
}

std::string note_text(const FolderState& state, std::string_view name) {
    return archive::text_named(name, *state.note);
}

std::string start_text(const FolderState& state) {
    return fmt::format("started   {}, ranks {}", note_text(state, "start"),
                       note_text(state, "ranks"));
}

std::map<std::string, std::string> by_name(const archive::Texts& entries) {
    return {entries.begin(), entries.end()};
}

/// study.h5; without a description it cannot be opened.
template <class To>
void describe_archive(To& to, const FolderState& state) {
    const auto columns = [&](const char* key, const std::vector<archive::Column>& all) {
        to.list(key, all, [&](const archive::Column& column) {
            to("name", column.name);
            to("unit", column.unit);
        });
    };
    to("bytes", state.archive_bytes);
    to.when(state.archive, [&](const archive::StudyDescription& study) {
        to("culm", study.version, "the program that wrote it");
        columns("factors", study.factors);
        columns("results", study.results);
        to.object("stored", [&] {
            to("tip", study.stored.tip);
            to("heights", study.stored.heights);
            to("positions", study.stored.positions);
        });
        to("samples", [&] { return study.times.size(); });
        to("heights_m", study.heights);
        to("spheres", study.spheres);
        to("provenance", [&] { return by_name(study.provenance); });
    });
    to.when(state.verification, [&](const archive::Verification& found) {
        to("datasets", found.datasets);
        to("chunks", found.chunks);
        to.list("damaged", found.damaged, [&](const archive::DamagedDataset& dataset) {
            to("dataset", dataset.name);
            to("damaged_chunks", dataset.damaged_chunks);
            to("chunks", dataset.chunks);
            to("reason", dataset.reason);
        });
    });
}

template <class To>
void describe_journal(To& to, const study::JournalState& journal) {
    const archive::JournalScan& scan = journal.scan;
    to("file", scan.file);
    to("bytes", scan.size);
    to("outcomes", [&] { return scan.entries.size(); });
    to("is_written_now", journal.is_locked);
    to("rank", [&] { return rank_of(journal); });
    to("computing", journal.computing, "missing points that its rank has begun");
    to("is_waiting", [&] { return journal.is_waiting(); });
    to("age_s", journal.age_s);
    to("torn_tail_bytes", scan.torn_tail_bytes);
    to("skipped_bytes", scan.skipped_bytes);
    to("damaged_regions", scan.damaged_regions);
    to("corrupt_records", scan.corrupt_records);
}

template <class To>
void describe_points(To& to, const FolderState& state) {
    const bool has_points = state.points.has_value();
    to.maybe(
        "points", has_points,
        [&] {
            const study::PointCounts counts = has_points ? state.counts() : study::PointCounts();
            to("total", counts.total);
            to("completed", counts.completed);
            to("failed", counts.failed);
            to("missing", counts.missing);
        },
        "null: their number is unknown");
    to.when(has_points, [&] {
        to("missing_points", [&] { return points_with(state, PointStatus::Missing); });
        to("failed_points", [&] { return points_with(state, PointStatus::Failed); });
    });
}

/// What `culm archive` writes with --json.
struct FolderFile {
    core::Viewed<FolderState> state;
};
template <class To>
void describe(To& to, const FolderFile& of) {
    const FolderState& state = *of.state;
    describe_points(to, state);
    to("is_running", [&] { return state.is_running(); });
    to.maybe("archive", state.archive_bytes > 0 || state.archive,
             [&] { describe_archive(to, state); });
    to.list("journals", state.journals,
            [&](const study::JournalState& journal) { describe_journal(to, journal); });
    to("remaining_s", state.remaining_s, "null: not known");
    to("repeated_outcomes", state.repeated_outcomes);
    to.list(
        "unfinished_starts", [&] { return state.unfinished_starts(); },
        [&](const auto& start) {
            to("point", std::get<0>(start));
            to("times", std::get<1>(start));
        });
    to.when(state.note,
            [&](const archive::Texts& note) { to("run", [&] { return by_name(note); }); });
    to("problems", state.problems);
    to.when(state.verification || !state.archive,
            [&] { to("is_whole", [&] { return state.is_whole(); }); });
}

} // namespace

std::string ranges_text(const std::vector<std::int64_t>& points, std::size_t most) {
    std::vector<std::string> ranges;
    std::size_t next = 0;
    while (next < points.size() && ranges.size() < most) {
        const std::size_t first = next;
        while (next + 1 < points.size() && points[next + 1] == points[next] + 1)
            ++next;
        ranges.push_back(first == next ? fmt::format("{}", points[first])
                                       : fmt::format("{}-{}", points[first], points[next]));
        ++next;
    }
    std::string text = fmt::format("{}", fmt::join(ranges, ", "));
    if (next < points.size())
        text += fmt::format(" … and {} more", points.size() - next);
    return text;
}

std::string info_text(const study::StudyFolder& folder, const FolderState& state) {
    std::string text = fmt::format("folder    {}\n", folder.path().string());
    if (state.archive)
        text += fmt::format("archive   study.h5, {}, written by {}\n",
                            bytes_text(static_cast<double>(state.archive_bytes)),
                            state.archive->version);
    if (!state.journals.empty())
        text += journals_text(state);
    if (!state.archive && state.note)
        text += fmt::format("study     {} ({})\n{}\n", note_text(state, "study_name"),
                            note_text(state, "config_file"), start_text(state));
    text += counts_text(state);
    if (state.archive)
        text +=
            fmt::format("factors   {}\nresults   {}\nhistories {}\nprovenance\n{}",
                        columns_text(state.archive->factors), columns_text(state.archive->results),
                        histories_text(*state.archive), provenance_text(state.archive->provenance));
    else if (state.note)
        text += "provenance\n" + provenance_text(*state.note);
    for (const std::string& problem : state.problems)
        text += fmt::format("problem   {}\n", problem);
    return text;
}

std::string status_text(const FolderState& state) {
    std::string text = fmt::format(
        "state     {}\n", state.is_running()           ? "running"
                          : state.journals.empty()     ? "not running; archived"
                          : state.counts().missing > 0 ? "not running; --resume continues"
                                                       : "not running; --resume writes study.h5");
    text += counts_text(state);
    if (state.note)
        text += start_text(state) + '\n';
    if (!state.journals.empty()) {
        const auto youngest =
            std::ranges::min_element(state.journals, {}, &study::JournalState::age_s);
        text += journals_text(state) +
                fmt::format("last      written {:.0f} s ago\n", std::max(0.0, youngest->age_s));
    }
    text += state.is_running() ? ranks_text(state) : unfinished_text(state);
    if (state.remaining_s)
        text += fmt::format("end       in about {:.0f} s\n", *state.remaining_s);
    for (const std::string& problem : state.problems)
        text += fmt::format("problem   {}\n", problem);
    return text;
}

std::string verify_text(const FolderState& state) {
    std::string text;
    if (state.verification) {
        const archive::Verification& found = *state.verification;
        text +=
            fmt::format("archive   {} datasets in {} chunks, {}\n", found.datasets, found.chunks,
                        found.is_whole() ? "every checksum is right"
                                         : fmt::format("{} damaged", found.damaged.size()));
        for (const archive::DamagedDataset& dataset : found.damaged)
            text += fmt::format("damaged   {}: {} of {} chunks: {}\n", dataset.name,
                                dataset.damaged_chunks, dataset.chunks, dataset.reason);
    }
    if (!state.journals.empty())
        text += journals_text(state);
    for (const study::JournalState& journal : state.journals)
        if (journal.scan.is_damaged())
            text += damage_text(journal);
    for (const std::string& problem : state.problems)
        text += fmt::format("damaged   {}\n", problem);
    text += counts_text(state);
    for (const PointStatus status : {PointStatus::Missing, PointStatus::Failed})
        if (const auto points = points_with(state, status); !points.empty())
            text += fmt::format("{:<9} {}\n", to_string(status), ranges_text(points));
    return text + unfinished_text(state) +
           fmt::format("{}\n", state.is_whole() ? "whole" : "INCOMPLETE");
}

nlohmann::json folder_json(const FolderState& state) {
    return core::json_of(FolderFile{state});
}

nlohmann::json folder_schema() {
    return core::schema_of<FolderFile>();
}

} // namespace culm::present
