// SPDX-License-Identifier: BSD-3-Clause
// Reads one table of a TOML file with checked ranges, units in the keys, and hints for mistakes.
#pragma once

#include "measure/file_faults.hpp"

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <toml++/toml.h>

namespace culm::measure {

/// Parses a TOML file. Throws core::InputError with file and line.
[[nodiscard]] toml::table parse_toml_file(const std::filesystem::path& file);

/// The same of a text; `file` is its name in messages.
[[nodiscard]] toml::table parse_toml_text(const std::string& text, const std::string& file);

/// Finite numbers from `low` to `high`; `low` itself is not allowed if it is open.
struct NumberRange {
    double low = 0.0;
    double high = 0.0;
    bool low_is_open = false;

    [[nodiscard]] bool contains(double value) const {
        return std::isfinite(value) && (low_is_open ? value > low : value >= low) && value <= high;
    }
};

/// The endings of a quantity's two keys: 1 small unit = 10^power_of_ten SI units.
struct KeyUnit {
    std::string_view small;
    std::string_view si;
    int power_of_ten = 0;
};
inline constexpr KeyUnit length_unit{"mm", "m", -3};
inline constexpr KeyUnit mass_unit{"g", "kg", -3};
inline constexpr KeyUnit area_unit{"mm2", "m2", -6};
inline constexpr KeyUnit second_moment_unit{"mm4", "m4", -12};

/// A getter returns nothing when the key is absent or wrong; what is wrong goes into the faults,
/// and each key asked for becomes a valid one. Copies share nothing: use one object per table.
class TomlTable {
  public:
    /// `table` may be null (absent). `name` is put before keys in messages, for example "stem".
    TomlTable(const toml::table* table, std::string name, FileFaults& faults);

    [[nodiscard]] bool exists() const { return table_ != nullptr; }
    [[nodiscard]] bool has(std::string_view key) const;
    [[nodiscard]] bool is_text(std::string_view key) const;
    /// Line of the key, of the table if the key is absent, 0 if there is neither.
    [[nodiscard]] std::size_t line(std::string_view key) const;

    [[nodiscard]] std::optional<std::string> text(const std::string& key);
    /// Index of the word among the valid ones.
    [[nodiscard]] std::optional<std::size_t> word(const std::string& key,
                                                  std::span<const std::string> valid);
    [[nodiscard]] std::optional<double> number(const std::string& key, const NumberRange& range);
    [[nodiscard]] std::optional<std::int64_t> whole_number(const std::string& key,
                                                           const NumberRange& range);
    [[nodiscard]] std::optional<bool> flag(const std::string& key);
    [[nodiscard]] std::vector<double> numbers(const std::string& key, const NumberRange& range);
    [[nodiscard]] std::vector<std::string> texts(const std::string& key);
    /// A number in SI units from the key in the small unit or from the key in the SI unit; both are
    /// given as the key's ending, for example {"mm", "m", -3}. The range is in SI units.
    [[nodiscard]] std::optional<double> quantity(const std::string& name, const KeyUnit& unit,
                                                 const NumberRange& range);
    /// The same, and a fault if neither key is there.
    [[nodiscard]] double required_quantity(const std::string& name, const KeyUnit& unit,
                                           const NumberRange& range, std::string_view meaning);
    [[nodiscard]] std::optional<double> length(const std::string& name, const NumberRange& range);
    [[nodiscard]] double required_length(const std::string& name, const NumberRange& range,
                                         std::string_view meaning);
    /// Whichever of the two keys of a quantity the table has; the small unit's if it has none.
    [[nodiscard]] std::string key_of(const std::string& name, const KeyUnit& unit) const;
    [[nodiscard]] TomlTable table(const std::string& key);
    [[nodiscard]] std::vector<TomlTable> tables(const std::string& key);

    /// Records that the key is missing, unless something is already wrong with it.
    void missing(const std::string& key, std::string_view allowed);
    /// Records a fault at the key, with its value.
    void fault(std::string_view key, std::string_view text) const;

    /// Keys that nobody asked for: one that resembles a valid key is a fault; any other becomes a
    /// remark, so that a laboratory may keep notes of its own in the file.
    void finish(std::vector<std::string>& remarks) const;

  private:
    [[nodiscard]] const toml::node* ask(const std::string& key);
    [[nodiscard]] std::string full_key(std::string_view key) const;
    [[nodiscard]] std::string unknown_key_hint(const std::string& key) const;

    const toml::table* table_;
    std::string name_;
    FileFaults* faults_;
    std::vector<std::string> asked_;
};

} // namespace culm::measure
