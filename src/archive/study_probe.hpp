// SPDX-License-Identifier: BSD-3-Clause
// Whether HDF5 survives a damaged file.
#pragma once

#include <filesystem>
#include <string>

namespace culm::archive {

/// HDF5 1.10 keeps short texts in a heap without checksums and believes the sizes in it: a flipped
/// bit there may end the process that reads it, or keep it for ever. So a child process reads all
/// but the numbers first, for a limited time.
/// Empty if it survived (whatever it thinks of the file), else what happened to it. Not for
/// processes with several threads.
[[nodiscard]] std::string death_while_opening(const std::filesystem::path& path);

} // namespace culm::archive
