// SPDX-License-Identifier: BSD-3-Clause
// culm completion SHELL: a script by which a shell calls `culm complete WORD...`, which lists the
// possible next words from the definitions of the commands and options.
#include "cli/commands.hpp"

#include <map>
#include <memory>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/core.h>

namespace culm::cli {
namespace {

/// The values that the type of an option allows: a and b for "TEXT:{a,b}".
std::vector<std::string> choices(const CLI::Option& option) {
    const std::string type = option.get_type_name();
    const auto open = type.find('{');
    const auto close = type.find('}');
    if (open == std::string::npos || close == std::string::npos || close < open)
        return {};
    return CLI::detail::split(type.substr(open + 1, close - open - 1), ',');
}

/// The completions of `word` after the words before it, with their descriptions. File names are not
/// included, because the shells list them automatically.
std::map<std::string, std::string>
offers(const CLI::App& program, const std::vector<std::string>& before, const std::string& word) {
    const CLI::App* command = &program;
    for (const std::string& earlier : before)
        for (const CLI::App* below : command->get_subcommands({}))
            if (below->get_name() == earlier)
                command = below;
    std::map<std::string, std::string> found;
    const auto offer = [&](const std::string& name, const std::string& description) {
        if (name.starts_with(word))
            found[name] = description;
    };
    const CLI::Option* last = before.empty() || !before.back().starts_with('-')
                                  ? nullptr
                                  : command->get_option_no_throw(before.back());
    if (last != nullptr && last->get_items_expected_max() > 0) {
        for (const std::string& choice : choices(*last))
            offer(choice, "");
        return found;
    }
    for (const CLI::App* below : command->get_subcommands({}))
        if (!below->get_group().empty())
            offer(below->get_name(), below->get_description());
    for (const CLI::Option* option : command->get_options()) {
        if (option->get_positional())
            for (const std::string& choice : choices(*option))
                offer(choice, "");
        else if (word.starts_with('-'))
            for (const std::string& name : CLI::detail::split(option->get_name(false, true), ','))
                offer(name, option->get_description());
    }
    return found;
}

constexpr const char* bash_script = R"(# completion of culm; made by `culm completion`
_culm() {
    COMPREPLY=($("${COMP_WORDS[0]}" complete "${COMP_WORDS[@]:1:COMP_CWORD}" | cut -f1))
}
complete -o default -F _culm culm
)";

constexpr const char* fish_script = R"(# completion of culm; made by `culm completion`
function __culm_complete
    set -l words (commandline -opc) (commandline -ct)
    $words[1] complete $words[2..-1]
end
complete -c culm -a '(__culm_complete)'
)";

std::string script_for(const std::string& shell) {
    if (shell == "zsh")
        return std::string("autoload -U +X bashcompinit && bashcompinit\n") + bash_script;
    return shell == "fish" ? fish_script : bash_script;
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
    completion->callback([shell] { fmt::print("{}", script_for(*shell)); });

    CLI::App* complete = app.add_subcommand("complete", "List completions for a shell");
    complete->group("")->prefix_command()->set_help_flag();
    complete->callback([complete, &app] {
        std::vector<std::string> words = complete->remaining();
        if (words.empty())
            return;
        const std::string word = words.back();
        words.pop_back();
        for (const auto& [name, description] : offers(app, words, word))
            fmt::print("{}\t{}\n", name, description);
    });
}

} // namespace culm::cli
