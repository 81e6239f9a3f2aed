// SPDX-License-Identifier: BSD-3-Clause
// Whether stored results belong to the study at hand.
#pragma once

#include <string>
#include <string_view>

namespace culm::archive {

/// InputError unless the identity text (the canonical configuration) stored in the file named
/// `where` equals the one of the study at hand. The text shows the first line that differs.
void require_same_study(std::string_view stored, std::string_view current,
                        const std::string& where);

} // namespace culm::archive
