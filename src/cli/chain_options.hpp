// SPDX-License-Identifier: BSD-3-Clause
// Options of the chain that a command fits to measurements.
#pragma once

#include "physics/bond_law_options.hpp"

#include <optional>
#include <string>

#include <CLI/CLI.hpp>

namespace culm::cli {

inline constexpr const char* default_law = "consistent";

inline void add_chain_options(CLI::App& command, std::string& law, std::optional<int>& spheres) {
    command
        .add_option("--law", law,
                    "Law of the bonds' damping: \"consistent\" (physical) or \"schramm2019\" (as "
                    "in the authors' code) (default: consistent)")
        ->check(CLI::IsMember(physics::law_names()));
    command
        .add_option("--spheres", spheres,
                    "Spheres in the chain (default: as stem.toml says, else 56)")
        ->type_name("N")
        ->check(CLI::Range(5, 1000));
}

} // namespace culm::cli
