// SPDX-License-Identifier: BSD-3-Clause
#include "study/execute/folder_state.hpp"

#include "archive/file_descriptor.hpp"
#include "archive/study/file.hpp"
#include "archive/trajectory/reader.hpp"
#include "core/error.hpp"
#include "study/config/study_config.hpp"
#include "study/execute/journal_notes.hpp"

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <string_view>
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

/// An intact record of a journal whose trajectory is missing or damaged.
struct LostTrajectory {
    archive::JournalEntry entry;
    std::string reason;
};

/// Compares the checksums of the trajectories that the records of a journal name, and removes the
/// records with a wrong one from the scan.
std::vector<LostTrajectory> take_lost_trajectories(const StudyFolder& folder,
                                                   archive::JournalScan& scan) {
    std::vector<LostTrajectory> lost;
    const archive::FileDescriptor file(scan.file, archive::FileDescriptor::Access::Read);
    archive::TrajectoryFolder trajectories(folder.trajectories());
    bool stores_trajectories = true; // all records of a study do, or none
    std::erase_if(scan.entries, [&](const archive::JournalEntry& entry) {
        if (!stores_trajectories || entry.status != PointStatus::Completed)
            return false;
        try {
            const auto place = archive::read_record(file, entry).trajectory;
            stores_trajectories = place.has_value();
            if (place)
                (void)trajectories.read(*place);
        } catch (const core::StorageError& error) {
            lost.push_back({entry, fmt::format("the trajectory of point {} is lost: {}",
                                               entry.point, error.what())});
            return true;
        }
        return false;
    });
    return lost;
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
            if (depth == FolderDepth::Verify)
                for (const LostTrajectory& lost : take_lost_trajectories(folder, journal.scan))
                    state.problems.push_back(lost.reason);
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

/// Adds the outcomes in state.journals to state.points, which hold the statuses in the archive, and
/// their unfinished starts to state.deaths.
void add_journals_to_points(FolderState& state) {
    std::vector<PointStatus>& points = *state.points;
    std::vector<bool> is_journalled(points.size(), false);
    for (const JournalState& journal : state.journals)
        for (const archive::JournalEntry& entry : journal.scan.entries)
            add_outcome(entry, points, is_journalled, state);
    for (JournalState& journal : state.journals) {
        for (const auto& [point, times] : journal.scan.unfinished_starts) {
            if (point < 0 || point >= static_cast<std::int64_t>(points.size()))
                continue;
            state.deaths[point] += times;
            if (journal.is_locked &&
                points[static_cast<std::size_t>(point)] == PointStatus::Missing)
                journal.computing.push_back(point);
        }
    }
}

/// Expects the remaining points to take as long as those that this run has computed.
std::optional<double> remaining_seconds(const StudyFolder& folder, const FolderState& state) {
    if (!state.is_running() || !state.note)
        return std::nullopt;
    const auto number = [&state](const char* name) {
        return std::atof(archive::text_named(name, *state.note).c_str());
    };
    double computed = -number("journalled");
    for (const JournalState& journal : state.journals)
        computed += static_cast<double>(journal.scan.entries.size());
    if (computed <= 0.0)
        return std::nullopt;
    const double pending = std::max(0.0, number("pending") - computed);
    return pending * seconds_since_change(folder.note()) / computed;
}

void refuse_other_study(const fs::path& where, const std::string& stored,
                        const std::string& identity) {
    if (stored == identity)
        return;
    std::string differing = difference(stored, identity);
    if (differing.ends_with('\n'))
        differing.pop_back();
    throw core::InputError(fmt::format(
        "{} already holds another study; choose another folder with -o. What differs:\n{}",
        where.string(), differing));
}

void refuse_without_resume(const fs::path& where, bool resume) {
    if (!resume)
        throw core::InputError(
            fmt::format("{} already holds this study, whole or in part; add --resume to compute "
                        "only what is missing, or choose another folder with -o",
                        where.string()));
}

constexpr std::string_view advice =
    "Move this file away to compute the study again, or choose another folder with -o.";

archive::StudyFile readable_archive(const StudyFolder& folder) {
    try {
        return archive::StudyFile(folder.archive());
    } catch (const core::StorageError& error) {
        throw core::InputError(fmt::format("{}\n{}", error.what(), advice));
    }
}

/// Points are trusted only if every checksum of the archive is right.
void refuse_damaged_archive(const StudyFolder& folder) {
    const archive::Verification verification = archive::verify(folder.archive());
    if (verification.is_whole())
        return;
    const archive::DamagedDataset& first = verification.damaged.front();
    throw core::InputError(fmt::format(
        "{}: {} of {} datasets are damaged, the first is {} ({}); `culm archive verify {}` lists "
        "them\n{}",
        folder.archive().string(), verification.damaged.size(), verification.datasets, first.name,
        first.reason, folder.path().string(), advice));
}

void refuse_other_journals(const StudyFolder& folder, const std::string& identity) {
    for (const fs::path& file : archive::journal_files(folder.journals()))
        if (const auto stored = archive::read_journal_identity(file))
            refuse_other_study(folder.path(), *stored, identity);
}

/// Adds a point without a usable outcome to the pending points, or to those that are given up.
void place_point(std::int64_t point, const FolderState& state, int crash_limit,
                 FolderContent& content) {
    const auto deaths = state.deaths.find(point);
    const bool is_suspect = deaths != state.deaths.end();
    // A failed point is passed here only if it is to be tried again, whatever the limit.
    const bool has_failed = (*state.points)[static_cast<std::size_t>(point)] == PointStatus::Failed;
    if (is_suspect && crash_limit > 0 && deaths->second >= crash_limit && !has_failed) {
        content.given_up_points.push_back(point);
        return;
    }
    content.pending_points.push_back(point);
    if (is_suspect)
        content.suspect_points.push_back(point);
}

} // namespace

std::map<std::int64_t, int> FolderState::unfinished_starts() const {
    std::map<std::int64_t, int> starts = deaths;
    std::erase_if(starts, [&](const auto& start) {
        return (*points)[static_cast<std::size_t>(start.first)] != PointStatus::Missing;
    });
    return starts;
}

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
    if (!state.points && state.note)
        state.points.emplace(static_cast<std::size_t>(points_of(*state.note)),
                             PointStatus::Missing);
    if (state.points)
        add_journals_to_points(state);
    state.remaining_s = remaining_seconds(folder, state);
    return state;
}

FolderContent prepare_folder(const StudyFolder& folder, const std::string& identity,
                             std::int64_t point_count, const ResumeOptions& options) {
    FolderContent content;
    FolderState state;
    std::vector<PointStatus>& points = state.points.emplace();
    if (is_there(folder.archive())) {
        const archive::StudyFile file = readable_archive(folder);
        refuse_other_study(folder.path(), file.description().identity, identity);
        refuse_without_resume(folder.path(), options.resume);
        refuse_damaged_archive(folder);
        points = file.statuses();
        content.archive_is_complete = true;
    }
    points.resize(static_cast<std::size_t>(point_count), PointStatus::Missing);
    refuse_other_journals(folder, identity);
    for (archive::JournalScan& scan : archive::scan_journal_folder(folder.journals(), identity)) {
        refuse_without_resume(folder.path(), options.resume);
        make_writable(folder);
        for (const LostTrajectory& lost : take_lost_trajectories(folder, scan)) {
            archive::discard_record(scan.file, lost.entry);
            content.lost_trajectories.push_back(lost.reason);
        }
        content.journalled += static_cast<std::int64_t>(scan.entries.size());
        state.journals.push_back({std::move(scan)});
    }
    make_writable(folder);
    add_journals_to_points(state);
    for (std::int64_t point = 0; point < point_count; ++point) {
        const PointStatus status = points[static_cast<std::size_t>(point)];
        if (status == PointStatus::Missing ||
            (status == PointStatus::Failed && options.retry_failed))
            place_point(point, state, options.crash_limit, content);
    }
    // The archive is not complete before the journals have been merged into it.
    content.archive_is_complete =
        content.archive_is_complete && state.journals.empty() && content.pending_points.empty();
    return content;
}

} // namespace culm::study
