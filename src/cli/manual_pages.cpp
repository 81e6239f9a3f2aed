// SPDX-License-Identifier: BSD-3-Clause
#include "cli/manual_pages.hpp"

#include "cli/roff_text.hpp"

#include <algorithm>
#include <cctype>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/core.h>
#include <fmt/ranges.h>

namespace culm::cli {
namespace {

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

} // namespace

std::map<std::string, std::string> manual_pages(const CLI::App& program,
                                                const std::string& version) {
    std::map<std::string, std::string> pages;
    add_page(program, program.get_name(), version, pages);
    return pages;
}

} // namespace culm::cli
