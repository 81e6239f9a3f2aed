// SPDX-License-Identifier: BSD-3-Clause
// culm completion SHELL, culm manual DIR: what a shell and man(1) want to know of the commands.
#include "cli/build_facts.hpp"
#include "cli/commands.hpp"
#include "cli/config_reference.hpp"
#include "cli/manual_pages.hpp"
#include "cli/shell_completion.hpp"
#include "core/error.hpp"

#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <string>

#include <CLI/CLI.hpp>
#include <fmt/core.h>

namespace culm::cli {
namespace {

void write_pages(const CLI::App& app, const std::filesystem::path& folder) {
    std::error_code failed;
    std::filesystem::create_directories(folder, failed);
    std::map<std::string, std::string> pages = manual_pages(app, version_number);
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

std::string script_for(const CLI::App& app, const std::string& shell) {
    if (shell == "zsh")
        return zsh_completion(app);
    return shell == "fish" ? fish_completion(app) : bash_completion(app);
}

} // namespace

void add_shell_commands(CLI::App& app) {
    CLI::App* completion = app.add_subcommand(
        "completion", "Print a script that completes culm's commands in a shell: put `source "
                      "<(culm completion bash)` into ~/.bashrc");
    auto shell = std::make_shared<std::string>();
    completion->add_option("shell", *shell, "Which shell the script is for")
        ->required()
        ->check(CLI::IsMember({"bash", "zsh", "fish"}));
    completion->callback([shell, &app] { fmt::print("{}", script_for(app, *shell)); });

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
