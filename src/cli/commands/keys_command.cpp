// SPDX-License-Identifier: BSD-3-Clause
// culm keys [NAME...]
#include "cli/options.hpp"
#include "core/error.hpp"
#include "core/nearest_name.hpp"
#include "present/text.hpp"
#include "study/config/keys.hpp"

#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace culm::cli {
namespace {

using study::KeyDescription;

/// "a number in (0, 1000] mm; default 2.83".
std::string key_value(const KeyDescription& key) {
    std::string text = key.allowed();
    if (key.unit == "as the parameter")
        text += ", in the parameter's unit";
    return key.default_text.empty() ? text : text + "; default " + key.default_text;
}

/// The fixed part of a section's name: "factors" of "factors.<parameter>".
std::string spoken(const std::string& section) {
    return section.substr(0, section.find(".<"));
}

bool is_named(const KeyDescription& key, const std::string& name) {
    return name == key.table || name == spoken(key.table) || name == key.name ||
           name == spoken(key.table) + "." + key.name;
}

[[noreturn]] void refuse(const std::string& name) {
    std::vector<std::string> valid;
    for (const KeyDescription& key : study::config_keys()) {
        valid.push_back(key.table);
        valid.push_back(key.name);
    }
    throw core::InputError(fmt::format(
        "there is no table or key \"{}\" in a study file{}; `culm keys` lists those there are",
        name, core::did_you_mean(name, valid)));
}

std::string card(const KeyDescription& key) {
    constexpr std::size_t indent = 4;
    const std::string margin(indent, ' ');
    std::string meaning = key.meaning;
    std::erase(meaning, '`'); // of Markdown, around names of other keys
    return fmt::format("{}\n{}{}", key.name,
                       present::wrapped(margin, key_value(key), present::text_width - indent),
                       present::wrapped(margin, meaning, present::text_width - indent));
}

/// Every table with the names of its keys.
std::string config_key_list() {
    std::string text;
    std::string table;
    std::string names;
    const auto end_table = [&] {
        if (!table.empty())
            text += fmt::format("[{}]\n{}", table,
                                present::wrapped("    ", names, present::text_width));
    };
    for (const KeyDescription& key : study::config_keys()) {
        if (key.table != table) {
            end_table();
            table = key.table;
            names.clear();
        }
        names += (names.empty() ? "" : ", ") + key.name;
    }
    end_table();
    return text;
}

/// The allowed values and the default of each of the keys. A name is that of a table ("stem"), of a
/// key ("bond_damping") or of both ("law.name"). Throws core::InputError for unknown names.
std::string config_key_cards(const std::vector<std::string>& names) {
    std::string text;
    for (const std::string& name : names) {
        std::string section;
        for (const KeyDescription& key : study::config_keys()) {
            if (!is_named(key, name))
                continue;
            if (key.table != section) {
                section = key.table;
                text += fmt::format("{}[{}]\n", text.empty() ? "" : "\n", section);
            }
            text += card(key);
        }
        if (section.empty())
            refuse(name);
    }
    return text;
}

struct KeysArguments {
    std::vector<std::string> names;
    bool is_markdown = false;
};

} // namespace

void add_keys_command(CLI::App& app) {
    CLI::App* command = app.add_subcommand(
        "keys", "The keys of study files: what is allowed, units, defaults, meaning");
    auto arguments = std::make_shared<KeysArguments>();
    CLI::Option* names =
        add_option(*command, "names", arguments->names, "NAME",
                   "Tables (stem) or keys (bond_damping, law.name); default: list all");
    command
        ->add_flag("--markdown", arguments->is_markdown,
                   "Print all of them as the reference in docs/config.md")
        ->excludes(names);
    command->callback([arguments] {
        if (arguments->is_markdown)
            fmt::print("{}", core::markdown_tables(study::config_keys()));
        else if (arguments->names.empty())
            fmt::print("{}\n`culm keys NAME` describes the keys of a table, or one key.\n",
                       config_key_list());
        else
            fmt::print("{}", config_key_cards(arguments->names));
    });
}

} // namespace culm::cli
