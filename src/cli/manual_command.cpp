// SPDX-License-Identifier: BSD-3-Clause
// culm manual DIR: a page for man(1) of every command, made of what --help knows, and
// culm-config(5). help2man would have to guess from the text of --help what CLI11 knows (nested
// commands, arguments, types), and the keys of study files come from no program's help.
#include "cli/build_facts.hpp"
#include "cli/commands.hpp"
#include "core/error.hpp"
#include "present/config_reference.hpp"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/core.h>
#include <fmt/ranges.h>

namespace culm::cli {
namespace {

/// Text that roff would otherwise take for a request or an escape.
std::string roff_text(std::string_view text) {
    std::string out;
    for (const char c : text) {
        if (out.empty() && (c == '.' || c == '\''))
            out += "\\&";
        if (c == '\\')
            out += "\\e";
        else if (c == '-')
            out += "\\-";
        else
            out += c;
    }
    return out;
}

std::string roff_bold(std::string_view text) {
    return "\\fB" + roff_text(text) + "\\fR";
}

std::string roff_italic(std::string_view text) {
    return "\\fI" + roff_text(text) + "\\fR";
}

/// "-o, --output DIR", or the positional's name.
std::string heading(const CLI::Option& option) {
    std::vector<std::string> names;
    for (const std::string& name : option.get_snames())
        names.push_back(roff_bold("-" + name));
    for (const std::string& name : option.get_lnames())
        names.push_back(roff_bold("--" + name));
    std::string text = fmt::format("{}", fmt::join(names, ", "));
    if (names.empty())
        return roff_italic(option.get_name());
    if (const std::string type = option.get_type_name(); !type.empty())
        text += " " + roff_italic(type);
    return text;
}

void add_options(const CLI::App& command, bool positional, const std::string& title,
                 std::string& page) {
    std::string entries;
    for (const CLI::Option* option : command.get_options())
        if (option->get_positional() == positional && !option->get_group().empty())
            entries += fmt::format(".TP\n{}\n{}\n", heading(*option),
                                   roff_text(option->get_description()));
    if (!entries.empty())
        page += fmt::format(".SH {}\n{}", title, entries);
}

std::string synopsis(const CLI::App& command, const std::string& words) {
    std::string text = roff_bold(words) + " [" + roff_italic("options") + "]";
    for (const CLI::Option* option : command.get_options())
        if (option->get_positional()) {
            const std::string name = roff_italic(option->get_name()) +
                                     (option->get_items_expected_max() > 1 ? " ..." : "");
            text += option->get_required() ? " " + name : " [" + name + "]";
        }
    if (!command.get_subcommands({}).empty())
        text += " " + roff_italic("command");
    return text;
}

std::string file_stem(const std::string& words) {
    std::string name = words;
    std::ranges::replace(name, ' ', '-');
    return name;
}

void add_page(const CLI::App& command, const std::string& words, const std::string& version,
              std::map<std::string, std::string>& pages) {
    const std::string name = file_stem(words);
    std::string title = name;
    std::ranges::transform(title, title.begin(),
                           [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
    std::string page = fmt::format(".TH \"{}\" 1 \"\" \"culm {}\" \"culm\"\n", title, version);
    page +=
        fmt::format(".SH NAME\n{} \\- {}\n", roff_text(name), roff_text(command.get_description()));
    page += fmt::format(".SH SYNOPSIS\n{}\n", synopsis(command, words));
    add_options(command, true, "ARGUMENTS", page);
    add_options(command, false, "OPTIONS", page);
    std::string commands;
    for (const CLI::App* below : command.get_subcommands({})) {
        const std::string inner = words + " " + below->get_name();
        commands += fmt::format(".TP\n{}(1)\n{}\n", roff_bold(file_stem(inner)),
                                roff_text(below->get_description()));
        add_page(*below, inner, version, pages);
    }
    if (!commands.empty())
        page += ".SH COMMANDS\n" + commands;
    page += fmt::format(".SH EXIT STATUS\n{}\n", roff_text(command.get_footer()));
    if (const auto space = words.rfind(' '); space != std::string::npos)
        page += fmt::format(".SH SEE ALSO\n{}(1)\n", roff_bold(file_stem(words.substr(0, space))));
    pages[name + ".1"] = page;
}

/// culm-config(5).
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
    for (const std::string& section : present::config_tables()) {
        page += fmt::format(".SH [{}]\n", roff_text(section));
        for (const study::ConfigKey& key : study::config_keys_of(section))
            page += fmt::format(".TP\n{}\n{}.\n.br\n{}\n", roff_bold(key.key),
                                roff_text(present::key_value(key)),
                                roff_text(present::key_meaning(key)));
    }
    return page + ".SH SEE ALSO\n" + roff_bold("culm-run") + "(1), " + roff_bold("culm-keys") +
           "(1)\n";
}

void write_pages(const CLI::App& app, const std::filesystem::path& folder) {
    std::error_code failed;
    std::filesystem::create_directories(folder, failed);
    std::map<std::string, std::string> pages; // by file name
    add_page(app, app.get_name(), version_number, pages);
    pages["culm-config.5"] = config_manual_page(version_number);
    for (const auto& [name, text] : pages) {
        std::ofstream out(folder / name);
        out << text;
        out.flush();
        if (!out)
            throw core::StorageError(
                fmt::format("{}: cannot be written", (folder / name).string()));
    }
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
    manual->callback([folder, &app] { write_pages(app, *folder); });
}

} // namespace culm::cli
