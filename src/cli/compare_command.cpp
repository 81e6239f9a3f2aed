// SPDX-License-Identifier: BSD-3-Clause
// culm compare MEASUREMENT
#include "cli/chain_options.hpp"
#include "cli/commands.hpp"
#include "cli/compare_action.hpp"
#include "cli/number_range.hpp"
#include "cli/under_launcher.hpp"

#include <memory>
#include <string>

#include <CLI/CLI.hpp>

namespace culm::cli {
namespace {

void add_model_options(CLI::App& command, CompareArguments& arguments) {
    add_chain_options(command, arguments.law, arguments.spheres);
    command
        .add_option("--window", arguments.window_s,
                    "Compare only the first so many seconds after the release (default: all)")
        ->type_name("SECONDS")
        ->check(number_in({0.0, 1e6, true}));
}

} // namespace

void add_compare_command(CLI::App& app, CommandResult& result, int& argc, char**& argv) {
    CLI::App* command = app.add_subcommand(
        "compare", "Model against measurement: where, when and how it fails, and what an effect "
                   "added by hand makes of that");
    auto arguments = std::make_shared<CompareArguments>();
    command
        ->add_option("measurement", arguments->paths,
                     "A measurement folder; with --table many, or folders that hold some")
        ->required()
        ->type_name("MEASUREMENT");
    command
        ->add_option("--with", arguments->with,
                     "Add these effects (`culm effects`) to the published chain: "
                     "quadratic_drag,relaxation(hold_time_s=3); what is not fixed is fitted")
        ->type_name("EFFECT,...")
        ->allow_extra_args(false);
    command
        ->add_option("--ladder", arguments->ladder,
                     "Add these effects one after the other and judge every step")
        ->type_name("EFFECT,...");
    command->add_flag("--table", arguments->is_table,
                      "Every effect of the library alone (and each --with) against every "
                      "measurement, spread over the ranks of mpirun");
    command->add_option("--json", arguments->json, "Write all results to this file (- for stdout)")
        ->type_name("FILE");
    command
        ->add_option("-o,--output", arguments->output,
                     "Folder for comparison.json, comparison.h5 and deflections.csv")
        ->type_name("DIR");
    add_model_options(*command, *arguments);
    command->add_flag("-q,--quiet", arguments->is_quiet, "No estimate of the cost, no progress");
    command->callback([arguments, &result, &argc, &argv] {
        result.exit_code = alone_or_under_launcher(
            argc, argv, [&arguments](const farm::Communicator* communicator) {
                return compare_measurements(*arguments, communicator);
            });
    });
}

} // namespace culm::cli
