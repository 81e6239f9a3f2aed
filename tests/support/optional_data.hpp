// SPDX-License-Identifier: BSD-3-Clause
// Data outside the repository, which may be absent.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>

namespace culm::tests {

/// A folder of the optional data, below the folder named by the environment variable
/// CULM_OPTIONAL_DATA (by default ../shared/data, relative to the repository). Empty if the folder
/// does not exist; the test is then skipped.
inline std::optional<std::filesystem::path> optional_data(const std::string& name) {
    const char* place = std::getenv("CULM_OPTIONAL_DATA");
    const std::filesystem::path folder =
        (place != nullptr ? std::filesystem::path(place)
                          : std::filesystem::path(CULM_SOURCE_DIR) / ".." / "shared" / "data") /
        name;
    if (!std::filesystem::exists(folder))
        return std::nullopt;
    return folder;
}

} // namespace culm::tests
