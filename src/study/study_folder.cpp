// SPDX-License-Identifier: BSD-3-Clause
#include "study/study_folder.hpp"

#include "archive/journal_scan.hpp"
#include "archive/study_file.hpp"
#include "core/error.hpp"
#include "study/config.hpp"

#include <cerrno>
#include <system_error>

#include <fmt/core.h>
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

void make_writable(const fs::path& folder) {
    std::error_code error;
    fs::create_directories(folder, error);
    if (error == std::errc::no_space_on_device)
        throw core::StorageError(
            fmt::format("cannot create the folder {}: {}", folder.string(), error.message()));
    if (error)
        throw core::InputError(
            fmt::format("cannot create the folder {}: {}; choose another one with -o",
                        folder.string(), error.message()));
    if (::access(folder.c_str(), W_OK | X_OK) != 0)
        throw core::InputError(
            fmt::format("cannot write to the folder {}: {}; choose another one with -o",
                        folder.string(), std::generic_category().message(errno)));
}

archive::StudyFile readable_archive(const StudyFolder& folder) {
    try {
        return archive::StudyFile(folder.archive());
    } catch (const core::StorageError& error) {
        throw core::InputError(fmt::format("{}\nMove this file away to compute the study again, or "
                                           "choose another folder with -o.",
                                           error.what()));
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

fs::path StudyFolder::journal_of_rank(int rank) const {
    return journals() / fmt::format("rank-{:05d}.culmj", rank);
}

FolderContent prepare_folder(const StudyFolder& folder, const std::string& identity,
                             std::int64_t point_count, bool resume) {
    FolderContent content;
    std::vector<bool> computed(static_cast<std::size_t>(point_count), false);
    const auto mark = [&computed](std::int64_t point) {
        if (point >= 0 && point < static_cast<std::int64_t>(computed.size()))
            computed[static_cast<std::size_t>(point)] = true;
    };

    if (is_there(folder.archive())) {
        const archive::StudyFile file = readable_archive(folder);
        refuse_other_study(folder.path(), file.description().identity, identity);
        refuse_without_resume(folder.path(), resume);
        for (std::int64_t point = 0; point < file.point_count(); ++point)
            if (file.status(point) != archive::PointStatus::Missing)
                mark(point);
        content.archive_is_complete = true;
    }
    for (const archive::JournalScan& scan :
         archive::scan_journal_folder(folder.journals(), identity)) {
        refuse_without_resume(folder.path(), resume);
        for (const archive::JournalEntry& entry : scan.entries)
            mark(entry.point);
    }
    make_writable(folder.path());
    for (std::int64_t point = 0; point < point_count; ++point)
        if (!computed[static_cast<std::size_t>(point)])
            content.pending_points.push_back(point);
    content.archive_is_complete = content.archive_is_complete && content.pending_points.empty();
    return content;
}

} // namespace culm::study
