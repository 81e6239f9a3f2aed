// SPDX-License-Identifier: BSD-3-Clause
#include "present/study/config_reference.hpp"

#include "core/error.hpp"
#include "core/nearest_name.hpp"
#include "present/text.hpp"
#include "study/config/keys.hpp"

#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace culm::present {
using study::ConfigKey;

namespace {

/// The tables in the order of the catalogue.
std::vector<std::string> config_tables() {
    std::vector<std::string> names;
    for (const ConfigKey& key : study::config_keys())
        if (names.empty() || names.back() != key.section)
            names.push_back(key.section);
    return names;
}

/// "a number in (0, 1000] mm; default 2.83".
std::string key_value(const ConfigKey& key) {
    std::string text = key.allowed();
    if (key.unit == "as the parameter")
        text += ", in the parameter's unit";
    return key.default_text.empty() ? text : text + "; default " + key.default_text;
}

/// The key's description, without the Markdown backticks around names of other keys.
std::string key_meaning(const ConfigKey& key) {
    std::string text = key.meaning;
    std::erase(text, '`');
    return text;
}

/// The fixed part of a section's name: "factors" of "factors.<parameter>".
std::string spoken(const std::string& section) {
    return section.substr(0, section.find(".<"));
}

bool is_named(const ConfigKey& key, const std::string& name) {
    return name == key.section || name == spoken(key.section) || name == key.key ||
           name == spoken(key.section) + "." + key.key;
}

[[noreturn]] void refuse(const std::string& name) {
    std::vector<std::string> valid = config_tables();
    for (const ConfigKey& key : study::config_keys())
        valid.push_back(key.key);
    const std::string nearest = core::nearest_name(name, valid);
    throw core::InputError(fmt::format(
        "there is no table or key \"{}\" in a study file{}; `culm keys` lists those there are",
        name, nearest.empty() ? "" : fmt::format(" (did you mean \"{}\"?)", nearest)));
}

std::string card(const ConfigKey& key) {
    constexpr std::size_t indent = 4;
    const std::string margin(indent, ' ');
    return fmt::format("{}\n{}{}", key.key, wrapped(margin, key_value(key), text_width - indent),
                       wrapped(margin, key_meaning(key), text_width - indent));
}

} // namespace

std::string config_key_list() {
    std::string text;
    for (const std::string& section : config_tables()) {
        std::vector<std::string> names;
        for (const ConfigKey& key : study::config_keys_of(section))
            names.push_back(key.key);
        text += fmt::format("[{}]\n{}", section,
                            wrapped("    ", fmt::format("{}", fmt::join(names, ", ")), text_width));
    }
    return text;
}

std::string config_key_cards(const std::vector<std::string>& names) {
    std::string text;
    for (const std::string& name : names) {
        std::string section;
        for (const ConfigKey& key : study::config_keys()) {
            if (!is_named(key, name))
                continue;
            if (key.section != section) {
                section = key.section;
                text += fmt::format("{}[{}]\n", text.empty() ? "" : "\n", section);
            }
            text += card(key);
        }
        if (section.empty())
            refuse(name);
    }
    return text;
}

} // namespace culm::present
