// SPDX-License-Identifier: BSD-3-Clause
// Reads one TOML file: keys with checked ranges and units, and every mistake with its line, its
// value, what is allowed, and the right place or name.
#pragma once

#include "core/interval.hpp"
#include "core/toml/value.hpp"
#include "core/user_files.hpp"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <toml++/toml.h>

namespace culm::core {

/// A getter returns an empty value if the key is absent or wrong, and records a wrong one as a
/// fault. Each key that is read becomes a valid key of this table, also if the table is absent, so
/// that the message for a misplaced key can name its table. Copies refer to the same table.
class TomlTable {
  public:
    /// `table` may be null (absent). `name` is put before keys in messages, for example "stem".
    TomlTable(const toml::table* table, std::string_view name, FileFaults& faults);

    [[nodiscard]] const std::string& file() const { return faults_->file(); }
    [[nodiscard]] bool exists() const { return table_ != nullptr; }
    [[nodiscard]] bool has(std::string_view key) const;
    [[nodiscard]] bool is_text(std::string_view key) const;
    /// Line of the key, of the table if the key is absent, 0 if there is neither.
    [[nodiscard]] std::size_t line(std::string_view key) const;
    /// The keys in the order of the file.
    [[nodiscard]] std::vector<std::string> keys() const;

    // `allowed` states in messages what a value must be, unless the type and the range do.
    [[nodiscard]] std::optional<std::string>
    text(const std::string& key, std::string_view allowed = "a text in quotes") const;
    /// Index of the word among the valid ones.
    [[nodiscard]] std::optional<std::size_t> word(const std::string& key,
                                                  std::span<const std::string> valid,
                                                  std::string_view allowed = {}) const;
    [[nodiscard]] std::optional<double> number(const std::string& key, const Interval& range,
                                               std::string_view allowed = {}) const;
    [[nodiscard]] std::optional<std::int64_t> whole_number(const std::string& key,
                                                           const Interval& range,
                                                           std::string_view allowed = {}) const;
    [[nodiscard]] std::optional<bool> flag(const std::string& key) const;
    [[nodiscard]] std::vector<double> numbers(const std::string& key, const Interval& range,
                                              std::string_view allowed = {}) const;

    // A quantity is named by its key in the small unit, for example "length_mm".

    /// A number in SI units from the key or from its other spelling, si_key(). The range is in SI
    /// units.
    [[nodiscard]] std::optional<double> quantity(const std::string& key,
                                                 const Interval& range) const;
    /// The same, and a fault if both keys are absent.
    [[nodiscard]] double required_quantity(const std::string& key, const Interval& range,
                                           std::string_view meaning) const;
    /// The unit of the last written digit of a quantity, in SI units: 1e-6 for mass_g = 0.050. 0 if
    /// the quantity is absent.
    [[nodiscard]] double last_digit_of(const std::string& key) const;
    /// The spelling that the table has; the key itself if it has none.
    [[nodiscard]] std::string spelling_of(const std::string& key) const;
    [[nodiscard]] TomlTable table(const std::string& key) const;
    [[nodiscard]] std::vector<TomlTable> tables(const std::string& key) const;

    /// An absent table of the list `key`; reading it declares the keys of such tables, also if the
    /// list is empty.
    [[nodiscard]] TomlTable absent(const std::string& key) const;

    /// Accepts a key whose content another program reads.
    void leave(const std::string& key) const;
    /// Declares `keys` of the table `name` of the file; an empty name is this table's own. Hints
    /// for misplaced keys know them from now on.
    void declare(std::string_view name, std::span<const std::string> keys) const;
    /// The entries in the order of the file, with their values, for readers of other forms.
    [[nodiscard]] std::vector<TomlEntry> entries() const;
    /// The value of a key; null if it is absent.
    [[nodiscard]] const toml::node* node(std::string_view key) const;

    /// Records that the key is missing, unless it is present but wrong or the table is absent.
    void missing(const std::string& key, std::string_view allowed) const;
    /// Records a fault at the key, with its value.
    void fault(std::string_view key, std::string_view text) const;
    /// Records that the key may not be there, or that it is missing, with the reason.
    void refuse(std::string_view key, std::string_view reason) const;
    /// What is missing from a name that no key or table has: the table that it belongs to, the
    /// right unit with the converted number, or the nearest of `valid`.
    [[nodiscard]] std::string unknown_key_hint(const TomlEntry& entry,
                                               std::span<const std::string> valid) const;

    /// Records every unread key of this table and of those reached from it, with the table that it
    /// belongs to or the nearest valid name.
    void refuse_unknown_keys() const;

  private:
    /// Every table name of the file with its valid keys, and the tables that were reached.
    struct Places;

    friend class TomlDocument;
    TomlTable(const toml::table* table, std::string_view name, bool is_list,
              const TomlTable& parent);
    const toml::node* ask(const std::string& key, bool is_other_unit = false) const;
    [[nodiscard]] std::string full_key(std::string_view key) const;

    const toml::table* table_;
    std::size_t place_; ///< index of this table's name
    std::shared_ptr<Places> places_;
    FileFaults* faults_;
};

/// A parsed file with its faults.
class TomlDocument {
  public:
    /// Throws core::InputError with file, line and column if the file cannot be read or parsed.
    explicit TomlDocument(const std::filesystem::path& file);
    /// The same for a text; `file` is its name in messages.
    TomlDocument(std::string_view text, const std::string& file);
    ~TomlDocument();
    TomlDocument(const TomlDocument&) = delete;
    TomlDocument& operator=(const TomlDocument&) = delete;

    [[nodiscard]] const TomlTable& root() const { return root_; }
    [[nodiscard]] FileFaults& faults() { return faults_; }
    /// Refuses unknown keys; throws core::InputError with all faults if there is one.
    void finish();

  private:
    std::unique_ptr<const toml::table> parsed_;
    FileFaults faults_;
    TomlTable root_;
};

} // namespace culm::core
