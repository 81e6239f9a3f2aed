// SPDX-License-Identifier: BSD-3-Clause
#include "study/execute/study_folder.hpp"

#include "archive/journal/read.hpp"
#include "archive/study/file.hpp"
#include "core/error.hpp"
#include "study/config/study_config.hpp"

#include <cerrno>
#include <filesystem>
#include <map>
#include <set>
#include <string_view>
#include <system_error>

#include <fmt/core.h>
#include <sys/stat.h>
#include <unistd.h>

namespace culm::study {

namespace {

namespace fs = std::filesystem;

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

/// The known state of each point of the design.
class KnownPoints {
  public:
    KnownPoints(std::int64_t count, const ResumeOptions& options)
        : options_(options), is_computed_(static_cast<std::size_t>(count), false) {}

    void add(std::int64_t point, archive::PointStatus status) {
        if (!is_in_design(point) || status == archive::PointStatus::Missing)
            return;
        if (status == archive::PointStatus::Failed)
            has_failed_.insert(point);
        else
            settle(point);
    }
    void add(const archive::JournalScan& scan) {
        for (const archive::JournalEntry& entry : scan.entries)
            add(entry.point, entry.status);
        for (const auto& [point, times] : scan.unfinished_starts)
            if (is_in_design(point))
                deaths_[point] += times;
    }
    void fill(FolderContent& content) {
        if (!options_.retry_failed)
            for (const std::int64_t point : has_failed_)
                settle(point);
        for (std::size_t k = 0; k < is_computed_.size(); ++k)
            if (!is_computed_[k])
                place(static_cast<std::int64_t>(k), content);
    }

  private:
    [[nodiscard]] bool is_in_design(std::int64_t point) const {
        return point >= 0 && point < static_cast<std::int64_t>(is_computed_.size());
    }
    void settle(std::int64_t point) { is_computed_[static_cast<std::size_t>(point)] = true; }
    void place(std::int64_t point, FolderContent& content) const {
        const auto deaths = deaths_.find(point);
        const bool is_suspect = deaths != deaths_.end();
        // A failed point is passed here only if it is to be tried again, whatever the limit.
        if (is_suspect && options_.crash_limit > 0 && deaths->second >= options_.crash_limit &&
            !has_failed_.contains(point)) {
            content.given_up_points.push_back(point);
            return;
        }
        content.pending_points.push_back(point);
        if (is_suspect)
            content.suspect_points.push_back(point);
    }

    ResumeOptions options_;
    std::vector<bool> is_computed_;
    std::set<std::int64_t> has_failed_;
    std::map<std::int64_t, int> deaths_;
};

archive::FileDescriptor hold(const fs::path& path, const archive::LockWait& wait) {
    while (true) {
        archive::FileDescriptor file(path, archive::FileDescriptor::Access::ReadWriteCreate);
        file.lock_exclusively(wait);
        struct stat named {};
        // The previous job may have removed the file between opening and locking; the lock would
        // then be on a file that no other process can find.
        if (::stat(path.c_str(), &named) == 0 && file.is_same_file(named.st_dev, named.st_ino))
            return file;
    }
}

} // namespace

bool is_there(const fs::path& path) {
    std::error_code error;
    const bool exists = fs::exists(path, error);
    if (error)
        throw core::InputError(
            fmt::format("cannot look for {}: {}", path.string(), error.message()));
    return exists;
}

void make_writable(const StudyFolder& folder) {
    const std::string name = folder.path().string();
    std::error_code error;
    fs::create_directories(folder.path(), error);
    if (error == std::errc::no_space_on_device)
        throw core::StorageError(
            fmt::format("cannot create the folder {}: {}", name, error.message()));
    if (error)
        throw core::InputError(fmt::format(
            "cannot create the folder {}: {}; choose another one with -o", name, error.message()));
    if (::access(name.c_str(), W_OK | X_OK) != 0)
        throw core::InputError(
            fmt::format("cannot write to the folder {}: {}; choose another one with -o", name,
                        std::generic_category().message(errno)));
}

fs::path StudyFolder::journal_of_rank(int rank) const {
    return journals() / fmt::format("rank-{:05d}.culmj", rank);
}

FolderContent prepare_folder(const StudyFolder& folder, const std::string& identity,
                             std::int64_t point_count, const ResumeOptions& options) {
    FolderContent content;
    KnownPoints known(point_count, options);
    if (is_there(folder.archive())) {
        const archive::StudyFile file = readable_archive(folder);
        refuse_other_study(folder.path(), file.description().identity, identity);
        refuse_without_resume(folder.path(), options.resume);
        refuse_damaged_archive(folder);
        content.archive_is_complete = true;
        for (std::int64_t point = 0; point < file.point_count(); ++point) {
            known.add(point, file.status(point));
            if (file.status(point) == archive::PointStatus::Missing)
                content.archive_is_complete = false;
        }
    }
    refuse_other_journals(folder, identity);
    for (const archive::JournalScan& scan :
         archive::scan_journal_folder(folder.journals(), identity)) {
        refuse_without_resume(folder.path(), options.resume);
        known.add(scan);
        content.archive_is_complete = false; // not before the journals have been merged into it
    }
    make_writable(folder);
    known.fill(content);
    content.archive_is_complete = content.archive_is_complete && content.pending_points.empty();
    return content;
}

FolderLock::FolderLock(const StudyFolder& folder, const archive::LockWait& wait)
    : file_(hold(folder.lock(), wait)) {}

FolderLock::~FolderLock() {
    std::error_code ignored; // a remaining lock file locks nothing
    std::filesystem::remove(file_.path(), ignored);
}

} // namespace culm::study
