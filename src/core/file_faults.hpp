// SPDX-License-Identifier: BSD-3-Clause
// Collects what is wrong in a file, to report all of it at once.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace culm::core {

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
    /// counted instead of listed: a wrong decimal separator makes a fault of every cell.
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
