// SPDX-License-Identifier: BSD-3-Clause
// culm completion SHELL: commands, options and their choices in a shell, made of what --help knows.
#include "cli/commands.hpp"
#include "cluster/shell_word.hpp"

#include <memory>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/core.h>
#include <fmt/ranges.h>

namespace culm::cli {
namespace {

/// What an option may be, where its type says so: "TEXT:{a,b}" allows a and b.
std::vector<std::string> choices(const CLI::Option& option) {
    const std::string type = option.get_type_name();
    const auto open = type.find('{');
    const auto close = type.find('}');
    if (open == std::string::npos || close == std::string::npos || close < open)
        return {};
    return CLI::detail::split(type.substr(open + 1, close - open - 1), ',');
}

bool takes_value(const CLI::Option& option) {
    return option.get_items_expected_max() > 0;
}

std::vector<std::string> names(const CLI::Option& option) {
    std::vector<std::string> out;
    for (const std::string& name : option.get_snames())
        out.push_back("-" + name);
    for (const std::string& name : option.get_lnames())
        out.push_back("--" + name);
    return out;
}

/// One branch a command: its words, and one an option: its choices.
struct BashCases {
    std::string commands;
    std::string values;
};

void add_cases(const CLI::App& command, const std::string& words, BashCases& cases) {
    std::vector<std::string> next;
    for (const CLI::App* below : command.get_subcommands({})) {
        next.push_back(below->get_name());
        add_cases(*below, words + " " + below->get_name(), cases);
    }
    for (const CLI::Option* option : command.get_options()) {
        const std::vector<std::string> own = names(*option);
        const std::vector<std::string> allowed = choices(*option);
        if (option->get_positional())
            next.insert(next.end(), allowed.begin(), allowed.end());
        next.insert(next.end(), own.begin(), own.end());
        if (own.empty() || !takes_value(*option))
            continue;
        for (const std::string& name : own)
            cases.values +=
                fmt::format("        {}) choices={} ;;\n", cluster::shell_word(words + " " + name),
                            cluster::shell_word(fmt::format("{}", fmt::join(allowed, " "))));
    }
    cases.commands += fmt::format("        {}) words={} ;;\n", cluster::shell_word(words),
                                  cluster::shell_word(fmt::format("{}", fmt::join(next, " "))));
}

void add_fish(const CLI::App& command, const std::vector<std::string>& path, std::string& script) {
    std::vector<std::string> below_names;
    for (const CLI::App* below : command.get_subcommands({}))
        below_names.push_back(below->get_name());
    std::vector<std::string> conditions;
    for (const std::string& word : path)
        conditions.push_back("__fish_seen_subcommand_from " + word);
    if (!below_names.empty())
        conditions.push_back(
            fmt::format("not __fish_seen_subcommand_from {}", fmt::join(below_names, " ")));
    const std::string when =
        conditions.empty()
            ? ""
            : fmt::format(" -n {}",
                          cluster::shell_word(fmt::format("{}", fmt::join(conditions, "; and "))));
    for (const CLI::App* below : command.get_subcommands({})) {
        script += fmt::format("complete -c culm -f{} -a {} -d {}\n", when, below->get_name(),
                              cluster::shell_word(below->get_description()));
        std::vector<std::string> inner = path;
        inner.push_back(below->get_name());
        add_fish(*below, inner, script);
    }
    for (const CLI::Option* option : command.get_options()) {
        if (option->get_positional())
            continue;
        script += "complete -c culm" + when;
        for (const std::string& name : option->get_snames())
            script += " -s " + name;
        for (const std::string& name : option->get_lnames())
            script += " -l " + name;
        if (takes_value(*option))
            script += " -r";
        if (const auto allowed = choices(*option); !allowed.empty())
            script += fmt::format(" -f -a {}",
                                  cluster::shell_word(fmt::format("{}", fmt::join(allowed, " "))));
        script += fmt::format(" -d {}\n", cluster::shell_word(option->get_description()));
    }
}

std::string bash_completion(const CLI::App& program) {
    BashCases cases;
    add_cases(program, "culm", cases);
    return fmt::format(R"(# bash completion of culm; made by `culm completion bash`
_culm() {{
    local current="${{COMP_WORDS[COMP_CWORD]}}" previous="${{COMP_WORDS[COMP_CWORD-1]}}"
    local command=culm words='' choices='' word tried i
    for ((i = 1; i < COMP_CWORD; i++)); do
        word="${{COMP_WORDS[i]}}"
        tried="$command $word"
        case "$tried" in
{0}        esac
        [[ -n "$words" ]] && command="$tried"
        words=''
    done
    case "$command $previous" in
{1}        *) choices='-' ;;
    esac
    if [[ "$choices" != '-' ]]; then
        if [[ -n "$choices" ]]; then
            mapfile -t COMPREPLY < <(compgen -W "$choices" -- "$current")
        else
            mapfile -t COMPREPLY < <(compgen -f -- "$current")
        fi
        return
    fi
    case "$command" in
{0}    esac
    mapfile -t COMPREPLY < <(compgen -W "$words" -- "$current"
                             [[ "$command" == culm || "$current" == -* ]] || compgen -f -- "$current")
}}
complete -o filenames -F _culm culm
)",
                       cases.commands, cases.values);
}

std::string zsh_completion(const CLI::App& program) {
    return "autoload -U +X bashcompinit && bashcompinit\n" + bash_completion(program);
}

std::string fish_completion(const CLI::App& program) {
    std::string script = "# fish completion of culm; made by `culm completion fish`\n";
    add_fish(program, {}, script);
    return script;
}

std::string script_for(const CLI::App& app, const std::string& shell) {
    if (shell == "zsh")
        return zsh_completion(app);
    return shell == "fish" ? fish_completion(app) : bash_completion(app);
}

} // namespace

void add_completion_command(CLI::App& app) {
    CLI::App* completion = app.add_subcommand(
        "completion", "Print a script that completes culm's commands in a shell: put `source "
                      "<(culm completion bash)` into ~/.bashrc");
    auto shell = std::make_shared<std::string>();
    completion->add_option("shell", *shell, "Which shell the script is for")
        ->required()
        ->check(CLI::IsMember({"bash", "zsh", "fish"}));
    completion->callback([shell, &app] { fmt::print("{}", script_for(app, *shell)); });
}

} // namespace culm::cli
