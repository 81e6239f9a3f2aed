// SPDX-License-Identifier: BSD-3-Clause
// culm compare: one measurement against growing models, or a table of many against all effects.
#pragma once

#include "cli/chain_options.hpp"
#include "core/error.hpp"
#include "farm/communicator.hpp"

#include <optional>
#include <string>
#include <vector>

namespace culm::cli {

struct CompareArguments {
    std::vector<std::string> paths;
    std::vector<std::string> with; ///< effects of one model each, with commas between them
    std::string ladder;
    std::string json;
    std::string output;
    std::string law = default_law;
    std::optional<int> spheres;
    std::optional<double> window_s;
    bool is_table = false;
    bool is_quiet = false;
};

/// `communicator` is null without a launcher. Throws core::InputError on every rank alike.
[[nodiscard]] core::ExitCode compare_measurements(const CompareArguments& arguments,
                                                  const farm::Communicator* communicator);

} // namespace culm::cli
