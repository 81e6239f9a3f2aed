// SPDX-License-Identifier: BSD-3-Clause
// Collects the errors of a config file, to report all of them at once.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace culm::study {

class ConfigErrors {
  public:
    explicit ConfigErrors(std::string file) : file_(std::move(file)) {}

    /// Records `file:line: text`.
    void add(std::size_t line, std::string_view text);
    /// Records `file:line: key = value: allowed`.
    void add(std::size_t line, std::string_view key, std::string_view value,
             std::string_view allowed);
    [[nodiscard]] std::size_t count() const { return errors_.size(); }

    /// Throws core::InputError with every error recorded, ordered by line, if there is one.
    void throw_if_any() const;

  private:
    struct Error {
        std::size_t line = 0;
        std::string text;
    };
    std::string file_;
    std::vector<Error> errors_;
};

} // namespace culm::study
