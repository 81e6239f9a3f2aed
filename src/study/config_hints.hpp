// SPDX-License-Identifier: BSD-3-Clause
// What a key or a word that does not exist was probably meant to be.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace culm::study {

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
