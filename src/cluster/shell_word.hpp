// SPDX-License-Identifier: BSD-3-Clause
// User text as one word of a bash script.
#pragma once

#include <string>
#include <string_view>

namespace culm::cluster {

/// A word that bash reads as exactly `text`, whatever it holds, and that stays on one line: a line
/// of its own could be read as a directive (#SBATCH) by the batch system. Throws core::InputError
/// for a text with a zero byte, which no argument of a program can hold.
[[nodiscard]] std::string shell_word(std::string_view text);

} // namespace culm::cluster
