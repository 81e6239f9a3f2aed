// SPDX-License-Identifier: BSD-3-Clause
// culm keys [NAME...]
#include "cli/command_line.hpp"
#include "cli/commands.hpp"
#include "present/study/config_reference.hpp"
#include "study/config/keys.hpp"

#include <memory>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/core.h>

namespace culm::cli {
namespace {

struct KeysArguments {
    std::vector<std::string> names;
    bool is_markdown = false;
};

void show(const KeysArguments& arguments) {
    if (arguments.is_markdown)
        fmt::print("{}", study::config_key_tables());
    else if (arguments.names.empty())
        fmt::print("{}\n`culm keys NAME` describes the keys of a table, or one key.\n",
                   present::config_key_list());
    else
        fmt::print("{}", present::config_key_cards(arguments.names));
}

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
    command->callback([arguments] { show(*arguments); });
}

} // namespace culm::cli
