// SPDX-License-Identifier: BSD-3-Clause
// Reads one table of a study file against the catalogue of keys.
#pragma once

#include "core/toml/table.hpp"
#include "core/toml/value.hpp"
#include "core/user_files.hpp"
#include "study/config/keys.hpp"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace culm::study {

using core::entries_in_order;
using core::line_of;
using core::value_text;

/// A getter returns nothing when the key is absent or wrong; faults are added to the errors.
class TableReader {
  public:
    /// `table` may be null (the section is absent). `prefix` is put before keys in messages;
    /// `section` names the part of the catalogue.
    TableReader(const toml::table* table, std::string prefix, std::string_view section,
                core::FileFaults& errors);

    /// Records every key that is not in the catalogue.
    void refuse_unknown_keys() const;

    [[nodiscard]] bool has(std::string_view key) const;
    /// Line of the key, of the table if the key is absent, or 1.
    [[nodiscard]] std::size_t line(std::string_view key) const;

    [[nodiscard]] std::optional<std::string> text(std::string_view key) const;
    [[nodiscard]] std::optional<std::string> word(std::string_view key) const;
    /// A value of kind Number, NumberOrWord (a number) or WholeNumber, in the catalogue's range.
    [[nodiscard]] std::optional<double> number(std::string_view key) const;
    [[nodiscard]] std::optional<std::int64_t> whole_number(std::string_view key) const;
    [[nodiscard]] std::optional<std::vector<double>> numbers(std::string_view key) const;

    /// Records an error at the key: with its value if it is present, else as missing.
    void error(std::string_view key, std::string_view allowed) const;

  private:
    [[nodiscard]] const ConfigKey& description(std::string_view key) const;

    const toml::table* content_;
    core::TomlTable table_; ///< the same, as values are read
    std::string prefix_;
    std::vector<ConfigKey> keys_;
    core::FileFaults* errors_;
};

} // namespace culm::study
