// SPDX-License-Identifier: BSD-3-Clause
// culm-track: the part of culm that reads videos; culm runs it with its own command line.
#include "cli/commands.hpp"
#include "cli/text_style.hpp"

#include <exception>

#include <CLI/CLI.hpp>
#include <fmt/core.h>

namespace {

using culm::core::ExitCode;

ExitCode run(int argc, char** argv) {
    CLI::App app("Measures deflections in videos; run it as culm track.", "culm");
    app.require_subcommand(1);
    culm::cli::CommandResult result;
    culm::cli::add_track_command(app, result, argc, argv);
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        return app.exit(error) == 0 ? ExitCode::Done : ExitCode::BadInput;
    } catch (const culm::core::InputError& error) {
        culm::cli::print_error(error.what());
        return ExitCode::BadInput;
    } catch (const culm::core::StorageError& error) {
        culm::cli::print_error(error.what());
        return ExitCode::BadInput;
    }
    return result.exit_code;
}

} // namespace

int main(int argc, char** argv) {
    try {
        return static_cast<int>(run(argc, argv));
    } catch (const std::exception& error) {
        culm::cli::print_error(fmt::format("internal error: {}", error.what()));
        return 1;
    }
}
