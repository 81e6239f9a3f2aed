// SPDX-License-Identifier: BSD-3-Clause
#include "study/execute/folder_state.hpp"

#include "archive/file_descriptor.hpp"
#include "archive/study/file.hpp"
#include "core/error.hpp"
#include "study/config/study_config.hpp"

#include <algorithm>
#include <chrono>
#include <system_error>
#include <utility>

#include <fmt/core.h>

namespace culm::study {

namespace {

namespace fs = std::filesystem;
using archive::PointStatus;

double seconds_since_change(const fs::path& file) {
    std::error_code error;
    const auto changed = fs::last_write_time(file, error);
    if (error)
        return 0.0;
    return std::chrono::duration<double>(fs::file_time_type::clock::now() - changed).count();
}

/// Notes StorageError as a problem; true if there was none.
template <class Action>
bool attempt(FolderState& state, Action action) {
    try {
        action();
        return true;
    } catch (const core::StorageError& error) {
        state.problems.emplace_back(error.what());
        return false;
    }
}

void read_archive(const StudyFolder& folder, FolderDepth depth, FolderState& state) {
    if (!is_there(folder.archive()))
        return;
    std::error_code ignored; // the size is for people
    state.archive_bytes = fs::file_size(folder.archive(), ignored);
    attempt(state, [&] {
        const archive::StudyFile file(folder.archive());
        state.archive = file.description();
        state.identity = file.description().identity;
        state.points = file.statuses();
    });
    if (depth == FolderDepth::Verify)
        attempt(state, [&] { state.verification = archive::verify(folder.archive()); });
}

void require_same_identity(const StudyFolder& folder, const std::string& identity,
                           const fs::path& file, FolderState& state) {
    if (state.identity.empty())
        state.identity = identity;
    if (state.identity == identity)
        return;
    throw core::InputError(fmt::format(
        "{}: {} belongs to another study than the files before it. What differs:\n{}",
        folder.path().string(), file.filename().string(), difference(state.identity, identity)));
}

void read_journals(const StudyFolder& folder, FolderDepth depth, FolderState& state) {
    const auto scan_depth =
        depth == FolderDepth::Verify ? archive::ScanDepth::Everything : archive::ScanDepth::Headers;
    for (const fs::path& path : archive::journal_files(folder.journals())) {
        attempt(state, [&] {
            const archive::FileDescriptor file(path, archive::FileDescriptor::Access::Read);
            if (const auto identity = archive::read_journal_identity(path))
                require_same_identity(folder, *identity, path, state);
            JournalState journal{archive::scan_journal(file, state.identity, scan_depth),
                                 file.is_locked(), seconds_since_change(path)};
            state.journal_bytes += journal.scan.size;
            state.journals.push_back(std::move(journal));
        });
    }
}

/// A completed outcome takes precedence over a failed one, as in archive::JournalIndex.
void add_outcome(const archive::JournalEntry& entry, std::vector<PointStatus>& points,
                 std::vector<bool>& is_journalled, FolderState& state) {
    if (entry.point < 0 || entry.point >= static_cast<std::int64_t>(points.size())) {
        state.problems.push_back(
            fmt::format("a journal has a record of point {}, which is not in the design of {}",
                        entry.point, points.size()));
        return;
    }
    const auto k = static_cast<std::size_t>(entry.point);
    if (is_journalled[k])
        ++state.repeated_outcomes;
    is_journalled[k] = true;
    // A retried point has two outcomes; a failure does not undo a success.
    if (points[k] != PointStatus::Completed)
        points[k] = entry.status;
}

void count_points(FolderState& state) {
    if (!state.points && state.note)
        state.points.emplace(static_cast<std::size_t>(state.note->points), PointStatus::Missing);
    if (!state.points)
        return;
    std::vector<PointStatus>& points = *state.points;
    std::vector<bool> is_journalled(points.size(), false);
    for (const JournalState& journal : state.journals)
        for (const archive::JournalEntry& entry : journal.scan.entries)
            add_outcome(entry, points, is_journalled, state);
    for (JournalState& journal : state.journals) {
        journal.is_waiting = journal.is_locked;
        for (const auto& [point, times] : journal.scan.unfinished_starts)
            if (point >= 0 && point < static_cast<std::int64_t>(points.size()) &&
                points[static_cast<std::size_t>(point)] == PointStatus::Missing) {
                state.unfinished_starts[point] += times;
                journal.is_waiting = false;
            }
    }
}

} // namespace

PointCounts FolderState::counts() const {
    PointCounts counts;
    if (!points)
        return counts;
    counts.total = static_cast<std::int64_t>(points->size());
    counts.completed = std::count(points->begin(), points->end(), PointStatus::Completed);
    counts.failed = std::count(points->begin(), points->end(), PointStatus::Failed);
    counts.missing = counts.total - counts.completed - counts.failed;
    return counts;
}

bool FolderState::is_whole() const {
    const bool journals_are_whole = std::ranges::none_of(
        journals, [](const JournalState& journal) { return journal.scan.is_damaged(); });
    return problems.empty() && journals_are_whole && points && counts().missing == 0 &&
           (!verification || verification->is_whole());
}

FolderState read_folder_state(const StudyFolder& folder, FolderDepth depth) {
    FolderState state;
    read_archive(folder, depth, state);
    attempt(state, [&] { state.note = read_note(folder); });
    read_journals(folder, depth, state);
    if (state.archive_bytes == 0 && !state.archive && !state.note && state.journals.empty() &&
        state.problems.empty())
        throw core::InputError(fmt::format(
            "{}: there is no study here ({} is missing); a study that was just started creates its "
            "folder when its design is ready",
            folder.path().string(), folder.archive().filename().string()));
    count_points(state);
    return state;
}

} // namespace culm::study
