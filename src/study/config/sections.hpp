// SPDX-License-Identifier: BSD-3-Clause
// Shared by the parts of the config reader: the reader of one table against the catalogue of keys,
// the state, and the files that a study names.
#pragma once

#include "core/toml/table.hpp"
#include "core/toml/value.hpp"
#include "core/user_files.hpp"
#include "study/config/keys.hpp"
#include "study/config/parameters.hpp"
#include "study/config/study_config.hpp"
#include "study/design/factor.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <toml++/toml.h>

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
    /// A value of kind Number or WholeNumber, in the catalogue's range.
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

/// Where a parameter was given.
struct GivenPlace {
    std::string section; ///< "stem", "release", "factors" or "design.point"
    std::size_t line = 0;
};

struct ConfigContext {
    const toml::table& root;
    StudyConfig& config;
    core::FileFaults& errors;
    std::map<std::string, GivenPlace, std::less<>> places; ///< by key
    const StudyFiles& files;                               ///< that are available already

    /// The section's table; null if it is absent (or not a table, which is recorded elsewhere).
    [[nodiscard]] const toml::table* section(std::string_view name) const {
        const toml::node* node = root.get(name);
        return node != nullptr ? node->as_table() : nullptr;
    }
    /// The reader of a section whose keys the catalogue lists under the same name.
    [[nodiscard]] TableReader reader(const std::string& name) const {
        return {section(name), name, name, errors};
    }
    /// The same, once for each section: records its unknown keys.
    [[nodiscard]] TableReader checked_reader(const std::string& name) const {
        TableReader known = reader(name);
        known.refuse_unknown_keys();
        return known;
    }
    /// Records an error at an entry of a section, with its value.
    void fault(const std::string& in, const core::TomlEntry& entry,
               std::string_view allowed) const {
        errors.add(entry.line, in + "." + entry.key, value_text(*entry.node), allowed);
    }
    /// Notes that `key` is given there; records an error if it was given before.
    void note_given(const std::string& key, const GivenPlace& place);
};

// Parts of the reader in other files; each records what is wrong and continues.
void read_factors(ConfigContext& context);     ///< the [[design.point]] tables included
void read_correlation(ConfigContext& context); ///< after the factors

/// The text of a file that the study calls `name`: one of ConfigContext::files, or from the disk,
/// where it must lie in the study's folder or below. It is noted in StudyConfig::files, so that the
/// archive can repeat the study without the disk. Throws core::InputError.
[[nodiscard]] const std::string& text_of_named_file(ConfigContext& context,
                                                    const std::string& name);

/// The allowed values of the parameter, for messages: "must be a number in (0, 1000] mm".
[[nodiscard]] std::string parameter_allowed(const Parameter& parameter);

inline constexpr std::array<std::string_view, 5> range_keys{"from", "to", "step", "count",
                                                            "spacing"};
inline constexpr std::array<std::string_view, 10> distribution_keys{
    "mean", "sd", "min", "max", "file", "column", "unit", "rows", "level", "within_sd"};

/// One factor's inline table while it is read.
struct FactorTable {
    TableReader reader;
    const Parameter& parameter;
    ConfigContext& context;

    /// A number of the table that must be one of the parameter's values; in the parameter's unit.
    [[nodiscard]] std::optional<double> value(std::string_view key) const {
        const auto number = reader.number(key);
        if (!number || parameter.range.contains(*number))
            return number;
        reader.error(key, parameter_allowed(parameter));
        return std::nullopt;
    }
    void need(std::string_view key, const std::string& who) const {
        if (!reader.has(key))
            reader.error(key, who + " needs it");
    }
    template <class Keys>
    void refuse(const Keys& keys, const std::string& reason) const {
        for (const std::string_view key : keys)
            if (reader.has(key))
                reader.error(key, reason);
    }
};

/// A factor with the key `distribution`, or nothing with the errors recorded.
[[nodiscard]] std::optional<Factor> read_distribution(const FactorTable& table);

struct ColumnRequest {
    std::string_view file; ///< for messages
    std::string_view column;
    std::string_view unit; ///< "" takes that of the column's name, else that of the parameter
    bool keeps_rows = false;
};

/// The values in SI, row by row, of the column with that header; the text is a table with a header
/// (comma, semicolon or tab). Empty cells are left out, or refused where rows are kept. Throws
/// core::InputError with the file, the line and what is wrong: no such column (with the nearest
/// name), no number, a unit of another kind, a value that the parameter does not allow, no values.
[[nodiscard]] std::vector<double>
measured_values(std::string_view text, const ColumnRequest& request, const Parameter& parameter);

} // namespace culm::study
