// SPDX-License-Identifier: BSD-3-Clause
// Files that users write: reads them within limits, checks names of files inside them, and reports
// all faults of a file at once. Files for users: written completely or refused.
#pragma once

#include <cstddef>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace culm::core {

/// Descriptions that people write: studies, stems, effects, mappings.
inline constexpr std::size_t largest_description = std::size_t{64} << 20U; // bytes
/// Recordings: a million samples of a hundred columns.
inline constexpr std::size_t largest_recording = std::size_t{1} << 30U; // bytes

/// The bytes of a file of at most `largest` bytes. Throws InputError with the file and the reason:
/// a folder, missing, too large. Devices and pipes are read up to the limit.
[[nodiscard]] std::string file_text(const std::filesystem::path& file,
                                    std::size_t largest = largest_description);

/// Closes the file. Throws StorageError unless everything is written.
void require_written(std::ofstream& out, const std::filesystem::path& file);
/// Throws StorageError.
void write_text(const std::filesystem::path& file, const std::string& text);
/// Creates the folder and its parents. Throws StorageError.
void create_folder(const std::filesystem::path& folder);

/// The fault of the name of a file that is written in another file; empty if there is none. A name
/// may only lead to that file's folder and below: not absolute, no ".." that leaves it. So a study
/// or a recording from another source cannot make culm read other files of the user. Symbolic links
/// are followed, because the owner of the folder made them, not the text.
[[nodiscard]] std::string named_path_fault(std::string_view name);

/// The path of the file that `file` calls `name`. Throws InputError with named_path_fault.
[[nodiscard]] std::filesystem::path path_named_in(const std::filesystem::path& file,
                                                  const std::string& name);

/// Collects the faults of a file, to report all of them at once.
class FileFaults {
  public:
    explicit FileFaults(std::string file) : file_(std::move(file)) {}

    /// Records `file:line: text`; line 0 means the file as a whole.
    void add(std::size_t line, std::string_view text);
    /// Records `file:line: key = value: allowed`.
    void add(std::size_t line, std::string_view key, std::string_view value,
             std::string_view allowed);
    [[nodiscard]] std::size_t count() const { return faults_.size(); }
    [[nodiscard]] const std::string& file() const { return file_; }

    /// Throws core::InputError with the faults by line if there is one. More than a dozen are
    /// counted instead of listed: a wrong decimal separator causes a fault in every cell.
    void throw_if_any() const;

  private:
    struct Fault {
        std::size_t line = 0;
        std::string text;
    };
    std::string file_;
    std::vector<Fault> faults_;
};

} // namespace culm::core
