// SPDX-License-Identifier: BSD-3-Clause
// Completion of commands, options and their choices in a shell, made of what --help knows.
#pragma once

#include <string>

namespace CLI {
class App;
}

namespace culm::cli {

/// For bash (`source <(culm completion bash)`), and for zsh through its bashcompinit.
[[nodiscard]] std::string bash_completion(const CLI::App& program);
[[nodiscard]] std::string zsh_completion(const CLI::App& program);
[[nodiscard]] std::string fish_completion(const CLI::App& program);

} // namespace culm::cli
