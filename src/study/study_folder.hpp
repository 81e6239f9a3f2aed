// SPDX-License-Identifier: BSD-3-Clause
// The folder of a study: its journals while it runs, its archive afterwards.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace culm::study {

/// Paths inside a study's folder.
class StudyFolder {
  public:
    explicit StudyFolder(std::filesystem::path folder) : folder_(std::move(folder)) {}

    [[nodiscard]] const std::filesystem::path& path() const { return folder_; }
    [[nodiscard]] std::filesystem::path archive() const { return folder_ / "study.h5"; }
    [[nodiscard]] std::filesystem::path journals() const { return folder_ / "journal"; }
    [[nodiscard]] std::filesystem::path journal_of_rank(int rank) const;
    [[nodiscard]] std::filesystem::path summary() const { return folder_ / "summary.json"; }

  private:
    std::filesystem::path folder_;
};

/// Whether there is such a file or folder. Throws core::InputError when that cannot be told, for
/// example because the folder above may not be searched.
[[nodiscard]] bool is_there(const std::filesystem::path& path);

/// What a folder already holds of a study.
struct FolderContent {
    bool archive_is_complete = false;         ///< study.h5 is there, every point computed
    std::vector<std::int64_t> pending_points; ///< of the design, not yet computed
};

/// Makes the folder ready for a study with this identity and number of points.
/// Throws core::InputError when it holds another study (with the differing settings), this one
/// while `resume` is false, or an archive that cannot be read, and when it may not be written;
/// core::StorageError when the disk has no room for it.
[[nodiscard]] FolderContent prepare_folder(const StudyFolder& folder, const std::string& identity,
                                           std::int64_t point_count, bool resume);

} // namespace culm::study
