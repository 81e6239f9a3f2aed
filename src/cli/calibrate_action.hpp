// SPDX-License-Identifier: BSD-3-Clause
// culm calibrate: many stems spread over the ranks of a launcher.
#pragma once

#include "calibrate/calibration.hpp"
#include "cli/chain_options.hpp"
#include "core/error.hpp"
#include "farm/communicator.hpp"

#include <optional>
#include <string>
#include <vector>

namespace culm::cli {

struct CalibrateArguments {
    std::vector<std::string> paths;
    std::string json;
    std::string output;
    std::string via;
    std::string law = default_law;
    std::string effects;
    std::optional<int> spheres;
    std::optional<double> window_s;
    bool is_robust = false;
    bool with_profiles = false;
    bool with_check = false;
    bool is_quiet = false;
};

/// `communicator` is null without a launcher. Throws core::InputError on every rank alike.
[[nodiscard]] core::ExitCode calibrate_measurements(const CalibrateArguments& arguments,
                                                    const farm::Communicator* communicator);

} // namespace culm::cli
