// SPDX-License-Identifier: BSD-3-Clause
// Reads values out of TOML tables, checks them and collects the errors of the whole file.
#pragma once

#include "study/config/keys.hpp"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <toml++/toml.h>

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

/// The value as it stands in the file, shortened if it is long.
[[nodiscard]] std::string value_text(const toml::node& node);

[[nodiscard]] inline std::size_t line_of(const toml::node& node) {
    return node.source().begin.line;
}

/// Keys of a table in the order of the file (toml++ sorts them by name).
struct TableEntry {
    std::string key;
    const toml::node* node = nullptr;
    std::size_t line = 0;
};
[[nodiscard]] std::vector<TableEntry> entries_in_order(const toml::table& table);

/// A getter returns nothing when the key is absent or wrong; what is wrong goes into the errors.
class TableReader {
  public:
    /// `table` may be null (the section is absent). `prefix` is put before keys in messages;
    /// `section` names the part of the catalogue.
    TableReader(const toml::table* table, std::string prefix, std::string_view section,
                ConfigErrors& errors);

    /// Records every key that the catalogue does not have.
    void refuse_unknown_keys() const;

    [[nodiscard]] bool has(std::string_view key) const;
    /// Line of the key, of the table if the key is absent, or 1.
    [[nodiscard]] std::size_t line(std::string_view key) const;

    [[nodiscard]] std::optional<std::string> text(std::string_view key) const;
    [[nodiscard]] std::optional<std::string> word(std::string_view key) const;
    /// Of the Number, NumberOrWord (a number) and WholeNumber kinds; within the catalogue's range.
    [[nodiscard]] std::optional<double> number(std::string_view key) const;
    [[nodiscard]] std::optional<std::int64_t> whole_number(std::string_view key) const;
    [[nodiscard]] std::optional<std::vector<double>> numbers(std::string_view key) const;

    /// Records an error at the key: with its value if it is present, else as missing.
    void error(std::string_view key, std::string_view allowed) const;

  private:
    [[nodiscard]] const toml::node* node(std::string_view key) const;
    [[nodiscard]] const ConfigKey& description(std::string_view key) const;

    const toml::table* table_;
    std::string prefix_;
    std::vector<ConfigKey> keys_;
    ConfigErrors* errors_;
};

} // namespace culm::study
