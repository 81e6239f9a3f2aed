// SPDX-License-Identifier: BSD-3-Clause
// Every key of study files: the allowed values, and suggestions for unknown keys.
#pragma once

#include "study/config/parameters.hpp"

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace culm::study {

enum class ValueKind { Text, Word, Number, WholeNumber, NumberList, WordList, Matrix, Tables };

struct ConfigKey {
    std::string section; ///< the TOML table, for example "study", or "factors.<parameter>"
    std::string key;
    ValueKind kind = ValueKind::Number;
    std::string unit;               ///< as it is printed; empty for none
    std::string default_text;       ///< empty: see `meaning`
    Interval range;                 ///< of numbers
    std::vector<std::string> words; ///< of Word
    std::string meaning;

    /// The allowed values, for messages: "a number in (0, 1000] mm".
    [[nodiscard]] std::string allowed() const;
};

/// Sections of a study file, in the order of the documentation.
[[nodiscard]] const std::vector<std::string>& config_sections();

/// Every key, section by section; the parameters of parameters.hpp are those of [stem] and
/// [release]. [factors] and [[design.point]] take any parameter; their keys are not repeated here.
[[nodiscard]] std::vector<ConfigKey> config_keys();

/// The keys of one section.
[[nodiscard]] std::vector<ConfigKey> config_keys_of(std::string_view section);

/// The catalogue as the Markdown tables that docs/config.md contains.
[[nodiscard]] std::string config_key_tables();

/// An unknown key as it was found.
struct UnknownKey {
    std::string section;
    std::string key;
    std::optional<double> value; ///< if it is a number
};

/// "unknown key", followed by the best of: the section that the key belongs to, the key with the
/// right unit and the value converted to it, the nearest of the valid keys, or all of them.
[[nodiscard]] std::string unknown_key_hint(const UnknownKey& unknown,
                                           std::span<const std::string> valid);

/// " (did you mean X?)" with the nearest name between the quotes given, or an empty string.
[[nodiscard]] std::string did_you_mean(std::string_view name, std::span<const std::string> valid,
                                       std::string_view quote = "");

} // namespace culm::study
