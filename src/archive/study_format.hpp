// SPDX-License-Identifier: BSD-3-Clause
// Name and version of the study file's format (docs/archive-format.md).
#pragma once

#include <string_view>

namespace culm::archive {

inline constexpr std::string_view study_format_name = "culm-study";
/// A reader refuses another major version; a minor version only adds.
inline constexpr int study_format_major = 1;
inline constexpr int study_format_minor = 0;

} // namespace culm::archive
