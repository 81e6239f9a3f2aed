// SPDX-License-Identifier: BSD-3-Clause
// culm effects [NAME...]
#include "cli/command_line.hpp"
#include "cli/commands.hpp"
#include "physics/effects/library.hpp"
#include "present/effects.hpp"
#include "present/files.hpp"
#include "study/config/study_effects.hpp"

#include <memory>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

namespace culm::cli {
namespace {

struct EffectsArguments {
    std::vector<std::string> names;
    std::string json;
    bool is_markdown = false;
};

std::vector<physics::EffectPointer> chosen(const EffectsArguments& arguments) {
    if (arguments.names.empty())
        return physics::all_effects();
    std::vector<physics::EffectPointer> effects;
    for (const std::string& name : arguments.names)
        effects.push_back(physics::is_effect_file(name) ? study::read_effect_file(name)
                                                        : physics::effect_named(name));
    return effects;
}

void show(const EffectsArguments& arguments) {
    const std::vector<physics::EffectPointer> effects = chosen(arguments);
    if (!arguments.json.empty())
        present::write_json(arguments.json, present::effects_json(effects));
    if (arguments.is_markdown)
        fmt::print("{}", present::effects_markdown(effects));
    if (!arguments.json.empty() || arguments.is_markdown)
        return;
    if (arguments.names.empty()) {
        fmt::print("{}\n`culm effects NAME` shows the law, the signature, the remedy, and the "
                   "parameters.\n",
                   present::effects_list(effects));
        return;
    }
    for (std::size_t i = 0; i < effects.size(); ++i)
        fmt::print("{}{}", i == 0 ? "" : "\n", present::effect_card(*effects[i]));
}

} // namespace

void add_effects_command(CLI::App& app) {
    CLI::App* command = app.add_subcommand(
        "effects", "The physical effects that can be added to the model, and their signatures");
    auto arguments = std::make_shared<EffectsArguments>();
    add_option(*command, "names", arguments->names, "NAME",
               "Effects to describe, or TOML files that define one (default: list all)");
    add_option(*command, "--json", arguments->json, "FILE",
               "Write them to this file (- for stdout)");
    command->add_flag("--markdown", arguments->is_markdown,
                      "Print them as the reference in docs/effects.md");
    command->callback([arguments] { show(*arguments); });
}

} // namespace culm::cli
