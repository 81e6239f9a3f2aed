// SPDX-License-Identifier: BSD-3-Clause
#include "beam_generator/flaw.hpp"

#include <algorithm>
#include <stdexcept>

#include <fmt/core.h>

namespace culm::beam {

const std::vector<Flaw>& flaws() {
    static const std::vector<Flaw> all{
        {"none", [](RecordingSpec&) {}},
        {"unknown_noise", [](auto& spec) { spec.errors.is_noise_stated = false; }},
        {"rounded", [](auto& spec) { spec.errors.quantum = 0.1e-3; }},
        {"outliers",
         [](auto& spec) {
             spec.errors.outlier_share = 0.005;
             spec.errors.outlier_size = 0.5e-3;
         }},
        {"gaps", [](auto& spec) { spec.errors.missing_share = 0.2; }},
        {"correlated_noise", [](auto& spec) { spec.errors.correlation = 0.5; }},
        {"wrong_length", [](auto& spec) { spec.errors.length_error = 0.01; }},
        {"late_release", [](auto& spec) { spec.errors.clock_error = 0.6e-3; }},
        {"early_release", [](auto& spec) { spec.errors.clock_error = -0.6e-3; }},
        {"short", [](auto& spec) { spec.duration = 0.08; }},
    };
    return all;
}

const Flaw& flaw_named(std::string_view name) {
    const auto found = std::ranges::find(flaws(), name, &Flaw::name);
    if (found == flaws().end())
        throw std::invalid_argument(fmt::format("{} is not a flaw of a recording", name));
    return *found;
}

} // namespace culm::beam
