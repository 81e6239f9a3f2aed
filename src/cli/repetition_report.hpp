// SPDX-License-Identifier: BSD-3-Clause
// What a repeated study is compared with, on the screen and in repetition.json.
#pragma once

#include "study/repetition.hpp"

#include <string>

namespace culm::cli {

/// For people.
[[nodiscard]] std::string repetition_text(const study::Repetition& repetition);

/// Compares the two folders' archives, writes repetition.json into `now` and prints the text.
/// Whether they are identical. core::StorageError.
bool report_repetition(const study::StudyFolder& archived, const study::StudyFolder& now);

} // namespace culm::cli
