// SPDX-License-Identifier: BSD-3-Clause
// The commands of culm, one source file each except those that execute a Python program, and the
// functions that declare their options. Only sources that declare or parse options include CLI11.
#pragma once

#include "cli/command_line.hpp"
#include "study/config/parameters.hpp"

#include <cstdlib>
#include <memory>
#include <string>

#include <CLI/CLI.hpp>
#include <fmt/core.h>
#include <nlohmann/json_fwd.hpp>

namespace culm::cli {

/// Adds an option, or an argument if the name has no dash; `type` is what the help calls its value.
template <class Value>
CLI::Option* add_option(CLI::App& command, const std::string& name, Value& value, const char* type,
                        const std::string& description) {
    return command.add_option(name, value, description)->type_name(type);
}

/// Refuses values outside of the range, NaN and infinities; CLI11's own checks let NaN pass.
[[nodiscard]] inline CLI::Validator number_in(const study::Interval& range) {
    const auto complaint = [range](const std::string& text) {
        char* end = nullptr;
        const double value = std::strtod(text.c_str(), &end);
        return end != text.c_str() && *end == '\0' && range.contains(value)
                   ? std::string()
                   : fmt::format("{} is not a number in {}", text, range.text());
    };
    return {complaint, "in " + range.text()};
}

/// Runs `action` by alone_or_under_launcher when the command has been parsed. `argc` and `argv` are
/// main's.
template <class Arguments, class Action>
void run_on_ranks(CLI::App& command, std::shared_ptr<Arguments> arguments,
                  core::ExitCode& exit_code, int& argc, char**& argv, const Action& action) {
    command.callback([arguments, &exit_code, &argc, &argv, action] {
        exit_code =
            alone_or_under_launcher(argc, argv, [&](const farm::Communicator* communicator) {
                return action(*arguments, communicator);
            });
    });
}

/// The schema of what `culm effects --json` writes.
[[nodiscard]] nlohmann::json effects_schema();

/// Each function adds its command to `app`. The command runs when it is parsed and stores its exit
/// code in `exit_code`, which must outlive the parsing. `argc` and `argv` are main's, for MPI.
void add_run_command(CLI::App& app, core::ExitCode& exit_code, int& argc, char**& argv);
void add_reduce_command(CLI::App& app, core::ExitCode& exit_code);
void add_archive_command(CLI::App& app, core::ExitCode& exit_code);
void add_simulate_command(CLI::App& app);
void add_import_command(CLI::App& app);
void add_fit_command(CLI::App& app, core::ExitCode& exit_code);
void add_setup_command(CLI::App& app);
void add_track_command(CLI::App& app, core::ExitCode& exit_code, int& argc, char**& argv);
void add_calibrate_command(CLI::App& app, core::ExitCode& exit_code, int& argc, char**& argv);
void add_compare_command(CLI::App& app, core::ExitCode& exit_code, int& argc, char**& argv);
void add_diagnose_command(CLI::App& app, core::ExitCode& exit_code, int& argc, char**& argv);
void add_export_command(CLI::App& app);
void add_effects_command(CLI::App& app);
void add_keys_command(CLI::App& app);
void add_schema_command(CLI::App& app, core::ExitCode& exit_code, int& argc, char**& argv);
void add_report_command(CLI::App& app);

} // namespace culm::cli
