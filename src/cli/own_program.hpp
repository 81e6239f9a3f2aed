// SPDX-License-Identifier: BSD-3-Clause
// Where this program lies, and so what belongs beside it.
#pragma once

#include "core/error.hpp"

#include <filesystem>
#include <string>
#include <system_error>

namespace culm::cli {

/// The file of this program; empty if the system does not say.
[[nodiscard]] inline std::filesystem::path own_program() {
    std::error_code error;
    const std::filesystem::path path = std::filesystem::read_symlink("/proc/self/exe", error);
    return error ? std::filesystem::path() : path;
}

/// What lies at `place` from this program's folder. Throws core::StorageError if the system does
/// not say where that is.
[[nodiscard]] inline std::filesystem::path beside_own_program(const std::string& place) {
    const std::filesystem::path program = own_program();
    if (program.empty())
        throw core::StorageError(place + ": the system does not say where culm lies "
                                         "(/proc/self/exe), beside which it belongs");
    return (program.parent_path() / place).lexically_normal();
}

} // namespace culm::cli
