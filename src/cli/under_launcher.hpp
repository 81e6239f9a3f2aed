// SPDX-License-Identifier: BSD-3-Clause
// Commands that run alone or spread over the ranks of a launcher.
#pragma once

#include "cli/text_style.hpp"
#include "core/error.hpp"
#include "farm/environment.hpp"

#include <cstdio>

#include <fmt/core.h>

namespace culm::cli {

/// Calls action(const farm::Communicator*), with null if no launcher started this process. Under
/// one, InputError and StorageError are errors that every rank meets: rank 0 prints them.
template <class Action>
[[nodiscard]] core::ExitCode alone_or_under_launcher(int& argc, char**& argv,
                                                     const Action& action) {
    if (!farm::Environment::is_under_launcher())
        return action(nullptr);
    const farm::Environment environment(argc, argv);
    const farm::Communicator communicator = environment.world();
    const auto refuse = [&communicator](const char* reason) {
        if (communicator.rank() == 0)
            print_error(reason);
        return core::ExitCode::BadInput;
    };
    try {
        return action(&communicator);
    } catch (const core::InputError& error) {
        return refuse(error.what());
    } catch (const core::StorageError& error) {
        return refuse(error.what());
    }
}

} // namespace culm::cli
