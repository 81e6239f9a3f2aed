// SPDX-License-Identifier: BSD-3-Clause
// The command that a user will want next, as the last line of what a command prints.
#pragma once

#include "cli/chain_options.hpp"
#include "cluster/shell_word.hpp"

#include <optional>
#include <string>
#include <vector>

#include <fmt/core.h>

namespace culm::cli {

/// The words as a shell reads them back, each behind a space.
[[nodiscard]] inline std::string as_words(const std::vector<std::string>& words) {
    std::string text;
    for (const std::string& word : words)
        text += ' ' + cluster::shell_word(word);
    return text;
}

/// The options of the chain that differ from their defaults, each behind a space.
[[nodiscard]] inline std::string model_words(const std::string& law,
                                             const std::optional<int>& spheres,
                                             const std::optional<double>& window_s) {
    std::string text;
    if (law != default_law)
        text += " --law " + law;
    if (spheres)
        text += fmt::format(" --spheres {}", *spheres);
    if (window_s)
        text += fmt::format(" --window {}", *window_s);
    return text;
}

/// "next: culm fit DIR" after an empty line.
[[nodiscard]] inline std::string next_step(const std::string& command) {
    return "\nnext: " + command + '\n';
}

} // namespace culm::cli
