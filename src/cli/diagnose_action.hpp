// SPDX-License-Identifier: BSD-3-Clause
// culm diagnose: which effect recordings call for, found by all ranks together.
#pragma once

#include "cli/chain_options.hpp"
#include "core/error.hpp"
#include "farm/communicator.hpp"

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace culm::cli {

struct DiagnoseArguments {
    std::vector<std::string> paths;
    std::string candidates; ///< with commas between them; empty: all that make sense
    std::vector<std::string> effect_files;
    std::string known;
    std::string json;
    std::string output;
    std::string law = default_law;
    std::optional<int> spheres;
    std::optional<double> window_s;
    std::size_t most_effects = 3;
    bool is_quiet = false;
};

/// `communicator` is null without a launcher. Throws core::InputError on every rank alike.
[[nodiscard]] core::ExitCode diagnose_measurements(const DiagnoseArguments& arguments,
                                                   const farm::Communicator* communicator);

} // namespace culm::cli
