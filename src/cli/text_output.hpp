// SPDX-License-Identifier: BSD-3-Clause
// Files and folders of results.
#pragma once

#include "core/error.hpp"

#include <filesystem>
#include <fstream>
#include <string>
#include <system_error>

#include <fmt/core.h>

namespace culm::cli {

/// Throws core::StorageError.
inline void write_text(const std::filesystem::path& file, const std::string& text) {
    std::ofstream out(file);
    out << text;
    out.flush();
    if (!out)
        throw core::StorageError(fmt::format("{}: cannot be written", file.string()));
}

/// With the folders above it. Throws core::StorageError.
inline void make_folder(const std::filesystem::path& folder) {
    std::error_code failed;
    std::filesystem::create_directories(folder, failed);
    if (failed)
        throw core::StorageError(
            fmt::format("{}: cannot be created: {}", folder.string(), failed.message()));
}

} // namespace culm::cli
