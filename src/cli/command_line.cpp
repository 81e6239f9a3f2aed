// SPDX-License-Identifier: BSD-3-Clause
#include "cli/command_line.hpp"

#include "cluster/batch_system.hpp"
#include "farm/environment.hpp"

#include <cstdio>

#include <fmt/core.h>

namespace culm::cli {

void print_error(std::string_view reason) {
    fmt::print(stderr, "culm: {}\n", reason);
}

void print_note(std::string_view text) {
    fmt::print(stderr, "culm: note: {}\n", text);
}

void print_warning(std::string_view text) {
    fmt::print(stderr, "culm: warning: {}\n", text);
}

void warn_of_copies(int ranks) {
    const int processes = farm::Environment::started_processes();
    if (processes > ranks)
        print_warning(fmt::format(
            "{} processes were started, and this command sees {}: each does the whole work and "
            "writes the same files. Start parallel commands with mpirun, or with srun --mpi=pmix",
            processes, ranks == 1 ? "itself alone" : fmt::format("{} of them", ranks)));
}

std::string as_words(const std::vector<std::string>& words) {
    std::string text;
    for (const std::string& word : words)
        text += ' ' + cluster::shell_word(word);
    return text;
}

std::string next_step(const std::string& command) {
    return "\nnext: " + command + '\n';
}

core::ExitCode with_refusals(bool prints, const std::function<core::ExitCode()>& action) {
    std::string reason;
    try {
        return action();
    } catch (const core::InputError& error) {
        reason = error.what();
    } catch (const core::StorageError& error) {
        reason = error.what();
    }
    if (prints)
        print_error(reason);
    return core::ExitCode::BadInput;
}

core::ExitCode
alone_or_under_launcher(int& argc, char**& argv,
                        const std::function<core::ExitCode(const farm::Communicator*)>& action) {
    if (!farm::Environment::is_under_launcher()) {
        warn_of_copies(1);
        return action(nullptr);
    }
    const farm::Environment environment(argc, argv);
    const farm::Communicator communicator = environment.world();
    if (is_root(&communicator))
        warn_of_copies(rank_count(&communicator));
    return with_refusals(is_root(&communicator), [&] { return action(&communicator); });
}

} // namespace culm::cli
