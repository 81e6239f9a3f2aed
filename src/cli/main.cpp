// SPDX-License-Identifier: BSD-3-Clause
// culm: parse, call, print.
#include "cli/options.hpp"
#include "cli/provenance.hpp"
#include "core/error.hpp"
#include "core/nearest_name.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <exception>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/core.h>
#include <glog/logging.h>
#include <unistd.h>

namespace {

using culm::core::ExitCode;

constexpr const char* unsuitable_processor_message =
    "culm: this binary was built for another processor (its vector instructions are missing here). "
    "Build it on this machine, or with a lower -DCULM_ARCHITECTURE=..., for example x86-64-v3.\n";

/// Whether this processor has the widest vector instructions that the compiler was allowed to use.
bool processor_is_suitable() {
#if defined(__AVX512F__)
    return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
           __builtin_cpu_supports("avx512vl");
#elif defined(__AVX2__)
    return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
#else
    return true;
#endif
}

/// The error in the command line, after the command's name and before a reference to --help.
std::string complaint(const CLI::App& app, const CLI::ParseError& error, int argc, char** argv) {
    if (const auto parsed = app.get_subcommands(); !parsed.empty()) {
        const std::string command = "culm " + parsed.front()->get_name();
        return fmt::format("{}: {}\nTry `{} --help`.\n", command, error.what(), command);
    }
    std::string text = error.what();
    if (argc > 1 && argv[1][0] != '-') {
        std::vector<std::string> names;
        for (const CLI::App* command : app.get_subcommands({}))
            names.push_back(command->get_name());
        const std::string nearest = culm::core::nearest_name(argv[1], names);
        text =
            fmt::format("there is no command \"{}\"{}", argv[1],
                        nearest.empty() ? "" : fmt::format(" (did you mean `culm {}`?)", nearest));
    }
    return fmt::format("culm: {}\nTry `culm --help`.\n", text);
}

/// `culm help COMMAND...` means `culm COMMAND... --help`; returns the new arguments, or `argv`
/// itself.
std::vector<char*> without_help_command(int argc, char** argv) {
    std::vector<char*> words(argv, argv + argc);
    static char help[] = "--help";
    if (argc > 1 && std::string_view(argv[1]) == "help") {
        words.erase(words.begin() + 1);
        words.push_back(help);
    }
    return words;
}

/// Commands that spread their work over ranks compare their number with that of the processes.
void warn_of_copies_of_serial_command(int argc, char** argv) {
    constexpr std::array<std::string_view, 5> parallel{"run", "track", "calibrate", "compare",
                                                       "diagnose"};
    if (argc > 1 && argv[1][0] != '-' && std::ranges::find(parallel, argv[1]) == parallel.end())
        culm::cli::warn_of_copies(1);
}

int run(int argc, char** argv) {
    warn_of_copies_of_serial_command(argc, argv);
    CLI::App app("Calibrates a flexible-stem discrete-element model against measured free "
                 "vibration.",
                 "culm");
    app.set_version_flag("--version", culm::cli::version_text());
    app.require_subcommand(1);
    app.footer("Exit codes: 0 done, 2 bad input, 3 some points failed, 75 stopped early "
               "(resumable with --resume).");
    ExitCode exit_code = ExitCode::Done;
    culm::cli::add_run_command(app, exit_code, argc, argv);
    culm::cli::add_reduce_command(app, exit_code);
    culm::cli::add_archive_command(app, exit_code);
    culm::cli::add_simulate_command(app);
    culm::cli::add_import_command(app);
    culm::cli::add_fit_command(app, exit_code);
    culm::cli::add_setup_command(app);
    culm::cli::add_track_command(app, exit_code, argc, argv);
    culm::cli::add_calibrate_command(app, exit_code, argc, argv);
    culm::cli::add_compare_command(app, exit_code, argc, argv);
    culm::cli::add_diagnose_command(app, exit_code, argc, argv);
    culm::cli::add_export_command(app);
    culm::cli::add_report_command(app);
    culm::cli::add_effects_command(app);
    culm::cli::add_keys_command(app);
    culm::cli::add_schema_command(app, exit_code, argc, argv);
    try {
        std::vector<char*> words = without_help_command(argc, argv);
        return static_cast<int>(culm::cli::with_refusals(true, [&] { // `run` answers its own
            app.parse(static_cast<int>(words.size()), words.data());
            return exit_code;
        }));
    } catch (const CLI::ParseError& error) {
        if (error.get_exit_code() == 0)
            return app.exit(error);
        const std::string text = complaint(app, error, argc, argv);
        fmt::print(stderr, "{}", text);
        return static_cast<int>(ExitCode::BadInput);
    } catch (const culm::core::NumericalError& error) {
        culm::cli::print_error(error.what());
        return static_cast<int>(ExitCode::PointsFailed);
    }
}

} // namespace

namespace culm::cli {

/// Replaces this process by culm-track, with the same command line.
core::ExitCode run_track(const TrackArguments&, int&, char**& argv) {
    const std::filesystem::path program = beside_own_program("culm-track");
    ::execv(program.c_str(), argv);
    throw core::StorageError(fmt::format("{}: cannot be run; install it next to culm: {}",
                                         program.string(), std::strerror(errno)));
}

} // namespace culm::cli

int main(int argc, char** argv) {
    if (!processor_is_suitable()) {
        std::fputs(unsuitable_processor_message, stderr);
        return static_cast<int>(ExitCode::BadInput);
    }
    // Ceres would print what a fit returns as its reason.
    FLAGS_minloglevel = google::GLOG_FATAL;
    try {
        return run(argc, argv);
    } catch (const std::exception& error) {
        culm::cli::print_error(fmt::format("internal error: {}", error.what()));
        return 1;
    }
}
