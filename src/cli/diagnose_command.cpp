// SPDX-License-Identifier: BSD-3-Clause
// culm diagnose MEASUREMENT...
#include "cli/chain_options.hpp"
#include "cli/commands.hpp"
#include "cli/diagnose_action.hpp"
#include "cli/number_range.hpp"
#include "cli/under_launcher.hpp"

#include <memory>
#include <string>

#include <CLI/CLI.hpp>

namespace culm::cli {
namespace {

void add_effect_options(CLI::App& command, DiagnoseArguments& arguments) {
    command
        .add_option("--candidates", arguments.candidates,
                    "Only these effects may be missing (default: all of `culm effects` that make "
                    "sense for the recording)")
        ->type_name("EFFECT,...");
    command
        .add_option("--effect-file", arguments.effect_files,
                    "One more candidate, defined in a TOML file (docs/effects.md); may be repeated")
        ->type_name("FILE")
        ->allow_extra_args(false);
    command
        .add_option("--known", arguments.known,
                    "Effects that act for certain, part of every model: gravity, "
                    "relaxation(hold_time_s=3), ...; what is not fixed is fitted")
        ->type_name("EFFECT,...");
    command
        .add_option("--max-effects", arguments.most_effects,
                    "Name at most so many effects (default: 3)")
        ->type_name("N")
        ->check(CLI::Range(1, 6));
}

void add_model_options(CLI::App& command, DiagnoseArguments& arguments) {
    add_chain_options(command, arguments.law, arguments.spheres);
    command
        .add_option("--window", arguments.window_s,
                    "Use only the first so many seconds after the release (default: all)")
        ->type_name("SECONDS")
        ->check(number_in({0.0, 1e6, true}));
}

} // namespace

void add_diagnose_command(CLI::App& app, CommandResult& result, int& argc, char**& argv) {
    CLI::App* command = app.add_subcommand(
        "diagnose", "Which effect is missing from the published chain, how sure that is, and what "
                    "the recording cannot show");
    auto arguments = std::make_shared<DiagnoseArguments>();
    command
        ->add_option("measurements", arguments->paths,
                     "Measurement folders, or folders that hold some; several are one stem in "
                     "several recordings, explained together")
        ->required()
        ->type_name("MEASUREMENT");
    command->add_option("--json", arguments->json, "Write all results to this file (- for stdout)")
        ->type_name("FILE");
    command
        ->add_option("-o,--output", arguments->output,
                     "Folder for diagnosis.json and, where no effect of the library suffices, "
                     "missing_force.toml")
        ->type_name("DIR");
    add_effect_options(*command, *arguments);
    add_model_options(*command, *arguments);
    command->add_flag("-q,--quiet", arguments->is_quiet, "No progress");
    command->callback([arguments, &result, &argc, &argv] {
        result.exit_code = alone_or_under_launcher(
            argc, argv, [&arguments](const farm::Communicator* communicator) {
                return diagnose_measurements(*arguments, communicator);
            });
    });
}

} // namespace culm::cli
