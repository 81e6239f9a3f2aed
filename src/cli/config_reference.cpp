// SPDX-License-Identifier: BSD-3-Clause
#include "cli/config_reference.hpp"

#include "cli/roff_text.hpp"
#include "cli/wrapped_text.hpp"
#include "core/error.hpp"
#include "core/nearest_name.hpp"
#include "study/config_keys.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace culm::cli {
namespace {

using study::ConfigKey;

/// The tables in the order of the catalogue.
std::vector<std::string> tables() {
    std::vector<std::string> names;
    for (const ConfigKey& key : study::config_keys())
        if (names.empty() || names.back() != key.section)
            names.push_back(key.section);
    return names;
}

/// "a number in (0, 1000] mm; default 2.83".
std::string value_of(const ConfigKey& key) {
    std::string text = key.allowed();
    if (key.unit == "as the parameter")
        text += ", in the parameter's unit";
    return key.default_text.empty() ? text : text + "; default " + key.default_text;
}

/// Key names in the meanings stand between backticks, as in Markdown.
std::string without_backticks(std::string text) {
    std::erase(text, '`');
    return text;
}

/// The part of "factors.<parameter>" that a person would type.
std::string spoken(const std::string& section) {
    return section.substr(0, section.find(".<"));
}

bool is_named(const ConfigKey& key, const std::string& name) {
    return name == key.section || name == spoken(key.section) || name == key.key ||
           name == spoken(key.section) + "." + key.key;
}

[[noreturn]] void refuse(const std::string& name) {
    std::vector<std::string> valid = tables();
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
    return fmt::format("{}\n{}{}", key.key, wrapped(margin, value_of(key), text_width - indent),
                       wrapped(margin, without_backticks(key.meaning), text_width - indent));
}

} // namespace

std::string config_key_list() {
    std::string text;
    for (const std::string& section : tables()) {
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

std::string config_manual_page(const std::string& version) {
    std::string page = fmt::format(
        ".TH \"CULM\\-CONFIG\" 5 \"\" \"culm {}\" \"culm\"\n"
        ".SH NAME\nculm\\-config \\- study files of culm\n"
        ".SH DESCRIPTION\n"
        "A study is a TOML file. Every key is optional unless it is said otherwise; an empty file "
        "is one run of the published stem. Units are part of the keys. Intervals are written as "
        "in mathematics: (0, 1000] leaves 0 out and includes 1000. A parameter of [stem] or "
        "[release] may be a factor instead: a list, a range or a distribution in [factors].\n",
        roff_text(version));
    for (const std::string& section : tables()) {
        page += fmt::format(".SH [{}]\n", roff_text(section));
        for (const ConfigKey& key : study::config_keys_of(section))
            page +=
                fmt::format(".TP\n{}\n{}.\n.br\n{}\n", roff_bold(key.key), roff_text(value_of(key)),
                            roff_text(without_backticks(key.meaning)));
    }
    return page + ".SH SEE ALSO\n" + roff_bold("culm-run") + "(1), " + roff_bold("culm-keys") +
           "(1)\n";
}

} // namespace culm::cli
