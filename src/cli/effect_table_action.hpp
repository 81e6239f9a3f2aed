// SPDX-License-Identifier: BSD-3-Clause
// culm compare --table: many measurements against every effect, spread over the ranks.
#pragma once

#include "cli/compare_action.hpp"

namespace culm::cli {

/// Fits the baseline, every effect of the library alone and the models of --with to every
/// measurement.
[[nodiscard]] core::ExitCode effect_table(const CompareArguments& arguments,
                                          const farm::Communicator* communicator);

} // namespace culm::cli
