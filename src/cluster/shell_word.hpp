// SPDX-License-Identifier: BSD-3-Clause
// User text as one word of a bash script.
#pragma once

#include <string>
#include <string_view>

namespace culm::cluster {

/// A word that bash reads as exactly `text`, for any content, and that stays on one line: the batch
/// system could read a separate line as a directive (#SBATCH). Throws core::InputError for a text
/// with a zero byte, which no argument of a program can contain.
[[nodiscard]] std::string shell_word(std::string_view text);

} // namespace culm::cluster
