// SPDX-License-Identifier: BSD-3-Clause
// The catalogue of every key that a study file may have: what is read, refused and documented.
#pragma once

#include "study/interval.hpp"

#include <string>
#include <string_view>
#include <vector>

namespace culm::study {

enum class ValueKind {
    Text,
    Word,
    Number,
    NumberOrWord,
    WholeNumber,
    NumberList,
    WordList,
    Matrix,
    Tables
};

struct ConfigKey {
    std::string section; ///< the TOML table, for example "study", or "factors.<parameter>"
    std::string key;
    ValueKind kind = ValueKind::Number;
    std::string unit;               ///< as it is printed; empty for none
    std::string default_text;       ///< empty: see `meaning`
    Interval range;                 ///< of numbers
    std::vector<std::string> words; ///< of Word and NumberOrWord
    std::string meaning;

    /// What a value must be, for messages: "a number in (0, 1000] mm".
    [[nodiscard]] std::string allowed() const;
};

/// Sections of a study file, in the order of the documentation.
[[nodiscard]] const std::vector<std::string>& config_sections();

/// Every key, section by section; the parameters of parameter_table.hpp are those of [stem] and
/// [release]. [factors] and [[design.point]] take any parameter; their keys are not repeated here.
[[nodiscard]] std::vector<ConfigKey> config_keys();

/// The keys of one section.
[[nodiscard]] std::vector<ConfigKey> config_keys_of(std::string_view section);

/// The catalogue as the Markdown tables that docs/config.md contains.
[[nodiscard]] std::string config_key_tables();

} // namespace culm::study
