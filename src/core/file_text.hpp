// SPDX-License-Identifier: BSD-3-Clause
// A whole file in memory, up to a limit of its size.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

namespace culm::core {

/// Descriptions that people write: studies, stems, effects, mappings.
inline constexpr std::size_t largest_description = std::size_t{64} << 20U; // bytes
/// Recordings: a million samples of a hundred columns.
inline constexpr std::size_t largest_recording = std::size_t{1} << 30U; // bytes

/// The bytes of a file of at most `largest` bytes. Throws InputError with the file and the reason:
/// a folder, missing, too large. Devices and pipes are read up to the limit.
[[nodiscard]] std::string file_text(const std::filesystem::path& file,
                                    std::size_t largest = largest_description);

} // namespace culm::core
