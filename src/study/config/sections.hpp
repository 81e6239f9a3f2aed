// SPDX-License-Identifier: BSD-3-Clause
// Shared by the parts of the config reader: the state while a study file is read, the files that a
// study names, and the inline table of one factor.
#pragma once

#include "core/toml/table.hpp"
#include "core/user_files.hpp"
#include "study/config/keys.hpp"
#include "study/config/parameters.hpp"
#include "study/config/study_config.hpp"
#include "study/design/factor.hpp"

#include <array>
#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace culm::study {

/// Where a parameter was given.
struct GivenPlace {
    std::string section; ///< "stem", "release", "factors" or "design.point"
    std::size_t line = 0;
};

struct ConfigContext {
    const core::TomlTable& root;
    StudyConfig& config;
    core::FileFaults& errors;
    std::map<std::string, GivenPlace, std::less<>> places; ///< by key
    const StudyFiles& files;                               ///< that are available already

    [[nodiscard]] core::TomlTable table(const std::string& name) const { return root.table(name); }
    /// Records an error at an entry of a section, with its value.
    void fault(const std::string& in, const core::TomlEntry& entry,
               std::string_view allowed) const {
        errors.add(entry.line, in + "." + entry.key, core::value_text(*entry.node), allowed);
    }
    /// Notes that `key` is given there; records an error if it was given before.
    void note_given(const std::string& key, const GivenPlace& place);
};

// Parts of the reader in other files; each records what is wrong and continues.
void read_factors(ConfigContext& context); ///< the [[design.point]] tables included

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
struct FactorReader {
    core::TomlTable table;
    FactorEntry entry;
    const Parameter& parameter;
    ConfigContext& context;

    /// A number of the entry, under its key, that must be one of the parameter's values.
    [[nodiscard]] std::optional<double> value(std::string_view key,
                                              const std::optional<double>& number) const {
        if (!number || parameter.range.contains(*number))
            return number;
        table.refuse(key, parameter_allowed(parameter));
        return std::nullopt;
    }
    void need(std::string_view key, const std::string& who) const {
        if (!table.has(key))
            table.refuse(key, who + " needs it");
    }
    template <class Keys>
    void refuse(const Keys& keys, const std::string& reason) const {
        for (const std::string_view key : keys)
            if (table.has(key))
                table.refuse(key, reason);
    }
};

/// A factor with the key `distribution`, or nothing with the errors recorded.
[[nodiscard]] std::optional<Factor> read_distribution(const FactorReader& factor);

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
