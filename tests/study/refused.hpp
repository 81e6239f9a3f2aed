// SPDX-License-Identifier: BSD-3-Clause
// The message with which a study is refused.
#pragma once

#include "core/error.hpp"
#include "study/config/study_config.hpp"

#include <string>
#include <string_view>

namespace culm::study {

/// The message of the InputError, or "accepted".
inline std::string refusal(std::string_view text) {
    try {
        (void)parse_config(text, "s.toml");
    } catch (const core::InputError& error) {
        return error.what();
    }
    return "accepted";
}

} // namespace culm::study
