// SPDX-License-Identifier: BSD-3-Clause
// Files that are named inside other files.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace culm::core {

/// What is wrong with the name of a file as it stands inside another file; empty if nothing is. A
/// name may only lead to that file's folder and below: not absolute, no ".." that leaves it. So a
/// study or a recording that came from elsewhere cannot make culm read other files of its reader.
/// Symbolic links are followed: they are the folder's owner's doing, not the text's.
[[nodiscard]] std::string named_path_fault(std::string_view name);

/// The path of the file that `file` calls `name`. Throws InputError with named_path_fault.
[[nodiscard]] std::filesystem::path path_named_in(const std::filesystem::path& file,
                                                  const std::string& name);

} // namespace culm::core
