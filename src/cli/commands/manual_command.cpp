// SPDX-License-Identifier: BSD-3-Clause
// culm manual DIR: a page for man(1) of every command, from the definitions for --help, and
// culm-config(5). help2man would have to guess nested commands, arguments and types from the text
// of --help, and no program's help describes the keys of study files.
#include "cli/build_facts.hpp"
#include "cli/commands.hpp"
#include "present/files.hpp"
#include "present/study/config_reference.hpp"

#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include <CLI/CLI.hpp>
#include <fmt/core.h>

namespace culm::cli {
namespace {

/// Escapes characters that roff would read as a request or an escape sequence.
std::string roff_text(std::string_view text) {
    std::string out = text.starts_with('.') || text.starts_with('\'') ? "\\&" : "";
    for (const char c : text)
        out += c == '\\' ? "\\e" : c == '-' ? "\\-" : std::string(1, c);
    return out;
}

/// An entry of a list: a bold or italic heading and its text.
std::string roff_entry(const std::string& heading, std::string_view text) {
    return fmt::format(".TP\n{}\n{}\n", heading, roff_text(text));
}

std::string roff_bold(std::string_view text) {
    return "\\fB" + roff_text(text) + "\\fR";
}

std::string roff_page(const std::string& name, int chapter, std::string_view summary) {
    return fmt::format(".TH \"{0}\" {1} \"\" \"culm {2}\" \"culm\"\n.SH NAME\n{0} \\- {3}\n",
                       roff_text(name), chapter, roff_text(version_number), roff_text(summary));
}

/// "-o, --output DIR", or the positional's name.
std::string option_heading(const CLI::Option& option) {
    if (option.get_positional())
        return "\\fI" + roff_text(option.get_name()) + "\\fR";
    return roff_bold(option.get_name(false, true)) + " \\fI" + roff_text(option.get_type_name()) +
           "\\fR";
}

/// Writes the page of a command and the pages of its subcommands.
void write_page(const CLI::App& command, const std::string& name,
                const std::filesystem::path& folder) {
    std::string page = roff_page(name, 1, command.get_description());
    std::string arguments;
    std::string options;
    for (const CLI::Option* option : command.get_options())
        (option->get_positional() ? arguments : options) +=
            roff_entry(option_heading(*option), option->get_description());
    std::string commands;
    for (const CLI::App* below : command.get_subcommands({})) {
        if (below->get_group().empty())
            continue;
        const std::string inner = name + '-' + below->get_name();
        commands += roff_entry(roff_bold(inner) + "(1)", below->get_description());
        write_page(*below, inner, folder);
    }
    for (const auto& [title, entries] :
         {std::pair{"ARGUMENTS", &arguments}, {"OPTIONS", &options}, {"COMMANDS", &commands}})
        if (!entries->empty())
            page += fmt::format(".SH {}\n{}", title, *entries);
    page += fmt::format(".SH EXIT STATUS\n{}\n", roff_text(command.get_footer()));
    if (const auto dash = name.rfind('-'); dash != std::string::npos)
        page += fmt::format(".SH SEE ALSO\n{}(1)\n", roff_bold(name.substr(0, dash)));
    present::write_text(folder / (name + ".1"), page);
}

std::string config_page() {
    std::string page =
        roff_page("culm-config", 5, "study files of culm") +
        ".SH DESCRIPTION\n"
        "A study is a TOML file. Every key is optional unless stated otherwise; an empty file "
        "is one run of the published stem. Units are part of the keys. Intervals are written as "
        "in mathematics: (0, 1000] leaves 0 out and includes 1000. A parameter of [stem] or "
        "[release] may be a factor instead: a list, a range or a distribution in [factors].\n";
    for (const std::string& section : present::config_tables()) {
        page += fmt::format(".SH [{}]\n", roff_text(section));
        for (const study::ConfigKey& key : study::config_keys_of(section))
            page += roff_entry(roff_bold(key.key), present::key_value(key) + ".") +
                    fmt::format(".br\n{}\n", roff_text(present::key_meaning(key)));
    }
    return page + ".SH SEE ALSO\n" + roff_bold("culm-run") + "(1), " + roff_bold("culm-keys") +
           "(1)\n";
}

} // namespace

void add_manual_command(CLI::App& app) {
    CLI::App* manual = app.add_subcommand(
        "manual", "Write a page for man(1) of every command, and one of the keys of "
                  "study files, into a folder");
    auto folder = std::make_shared<std::string>();
    manual->add_option("folder", *folder, "Folder for culm.1, culm-run.1, …, culm-config.5")
        ->required()
        ->type_name("DIR");
    manual->callback([folder, &app] {
        present::make_folder(*folder);
        write_page(app, app.get_name(), *folder);
        present::write_text(std::filesystem::path(*folder) / "culm-config.5", config_page());
    });
}

} // namespace culm::cli
