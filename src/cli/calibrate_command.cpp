// SPDX-License-Identifier: BSD-3-Clause
// culm calibrate MEASUREMENT...
#include "cli/calibrate_action.hpp"
#include "cli/chain_options.hpp"
#include "cli/commands.hpp"
#include "cli/number_range.hpp"
#include "cli/under_launcher.hpp"

#include <memory>
#include <string>

#include <CLI/CLI.hpp>

namespace culm::cli {
namespace {

void add_model_options(CLI::App& command, CalibrateArguments& arguments) {
    add_chain_options(command, arguments.law, arguments.spheres);
    command
        .add_option("--with", arguments.effects,
                    "Known physics beside the published chain, as `culm effects` names it: "
                    "gravity, quadratic_drag(drag_coefficient=1.2), ...; what is not fixed is "
                    "fitted")
        ->type_name("EFFECT,...");
    command
        .add_option("--window", arguments.window_s,
                    "Fit only the first so many seconds after the release (default: all)")
        ->type_name("SECONDS")
        ->check(number_in({0.0, 1e6, true}));
    command.add_flag("--robust", arguments.is_robust,
                     "Readings that are off by more than 2 sigma count less (Huber's loss)");
}

} // namespace

void add_calibrate_command(CLI::App& app, CommandResult& result, int& argc, char**& argv) {
    CLI::App* command = app.add_subcommand(
        "calibrate", "Fit the chain itself to measured stems: Y, beta and how sure they are");
    auto arguments = std::make_shared<CalibrateArguments>();
    command
        ->add_option("measurements", arguments->paths,
                     "Measurement folders, or folders that hold some; spread over the ranks of "
                     "mpirun")
        ->required()
        ->type_name("MEASUREMENT");
    command->add_option("--json", arguments->json, "Write all results to this file (- for stdout)")
        ->type_name("FILE");
    command
        ->add_option("-o,--output", arguments->output,
                     "Folder for calibration.json and the measured and predicted deflections")
        ->type_name("DIR");
    command
        ->add_option("--via", arguments->via,
                     "Also calibrate by this study's regressions (Eqs. 12-13 and F-test terms)")
        ->type_name("STUDY_DIR");
    command->add_flag("--check", arguments->with_check,
                      "Simulate the calibrated stem and compare its b1 and b2 with the measured");
    command->add_flag("--profile", arguments->with_profiles,
                      "Also intervals by profile likelihood (some 30 more runs)");
    add_model_options(*command, *arguments);
    command->add_flag("-q,--quiet", arguments->is_quiet, "No estimate of the cost, no progress");
    command->callback([arguments, &result, &argc, &argv] {
        result.exit_code = alone_or_under_launcher(
            argc, argv, [&arguments](const farm::Communicator* communicator) {
                return calibrate_measurements(*arguments, communicator);
            });
    });
}

} // namespace culm::cli
