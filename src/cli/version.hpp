// SPDX-License-Identifier: BSD-3-Clause
// Which culm this is, what it was built with, and which libraries it runs on.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace culm::cli {

/// Version number and commit.
[[nodiscard]] std::string version_text();

/// Facts for an archive's provenance: version, compiler, architecture, libraries.
[[nodiscard]] std::vector<std::pair<std::string, std::string>> build_provenance();

} // namespace culm::cli
