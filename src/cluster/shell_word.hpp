// SPDX-License-Identifier: BSD-3-Clause
// User text as one word of a shell.
#pragma once

#include <string>
#include <string_view>

namespace culm::cluster {

/// A word that a POSIX shell reads as exactly `text`, which has no zero byte.
[[nodiscard]] std::string shell_word(std::string_view text);

} // namespace culm::cluster
