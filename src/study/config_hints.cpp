// SPDX-License-Identifier: BSD-3-Clause
#include "study/config_hints.hpp"

#include "core/nearest_name.hpp"
#include "study/config_keys.hpp"
#include "study/units.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace culm::study {

namespace {

/// The hint for a key that names a valid quantity with another unit, or with none.
std::optional<std::string> unit_hint(const UnknownKey& unknown,
                                     std::span<const std::string> valid) {
    const KeyParts found = split_key(unknown.key);
    for (const std::string& key : valid) {
        const KeyParts right = split_key(key);
        if (right.quantity != found.quantity || !right.unit)
            continue;
        if (!found.unit || found.unit->dimension != right.unit->dimension || !unknown.value)
            return fmt::format("unknown key: write {}, in {}", key, right.unit->name);
        const double converted = right.unit->from_si(found.unit->to_si(*unknown.value));
        return fmt::format("unknown key: the unit is {} (write {} = {:.12g})", right.unit->name,
                           key, converted);
    }
    return std::nullopt;
}

} // namespace

std::string unknown_key_hint(const UnknownKey& unknown, std::span<const std::string> valid) {
    for (const ConfigKey& key : config_keys())
        if (key.key == unknown.key && key.section.find('<') == std::string::npos)
            return fmt::format("unknown key: it belongs into [{}]", key.section);
    if (auto hint = unit_hint(unknown, valid))
        return *hint;
    const std::string guess = did_you_mean(unknown.key, valid);
    if (!guess.empty())
        return "unknown key" + guess;
    return fmt::format("unknown key: must be one of {}", fmt::join(valid, ", "));
}

std::string did_you_mean(std::string_view name, std::span<const std::string> valid,
                         std::string_view quote) {
    const std::string nearest = core::nearest_name(name, valid);
    return nearest.empty() ? "" : fmt::format(" (did you mean {0}{1}{0}?)", quote, nearest);
}

} // namespace culm::study
