// SPDX-License-Identifier: BSD-3-Clause
// The files that a study names: effects, tables of measured stems.
#pragma once

#include "study/config_context.hpp"

#include <string>

namespace culm::study {

/// The text of a file that the study calls `name`: one of ConfigContext::files, or from the disk,
/// where it must lie in the study's folder or below. It is noted in StudyConfig::files, so that the
/// archive can repeat the study without the disk. Throws core::InputError.
[[nodiscard]] const std::string& text_of_named_file(ConfigContext& context,
                                                    const std::string& name);

/// All files as one text for an archive (a JSON object: name, text), and back. The latter throws
/// core::InputError if the text has another form; an empty text means no files.
[[nodiscard]] std::string to_text(const StudyFiles& files);
[[nodiscard]] StudyFiles files_from_text(const std::string& text);

} // namespace culm::study
