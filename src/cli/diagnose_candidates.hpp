// SPDX-License-Identifier: BSD-3-Clause
// Which effects a diagnosis may name, as the command line says.
#pragma once

#include "fit/model/stem_model.hpp"
#include "measure/folder/measurement.hpp"

#include <map>
#include <span>
#include <string>
#include <vector>

namespace culm::cli {

struct DiagnosisEffects {
    fit::SelectedEffects candidates;          ///< in the library's order
    fit::SelectedEffects known;               ///< likewise
    std::map<std::string, std::string> files; ///< of users' effects, by name
};

/// `candidates` and `known` have commas between effects; candidates need not go together. Empty
/// candidates: all that make sense for the recordings. The files are candidates too; what is known
/// is none. Throws core::InputError for a name or file that is none, an effect that is named twice,
/// or if no candidate is left.
[[nodiscard]] DiagnosisEffects
effects_for_diagnosis(const std::string& candidates, const std::vector<std::string>& files,
                      const std::string& known, std::span<const measure::Measurement> recordings);

/// As --with names it: users' effects by their file.
[[nodiscard]] std::string as_option(const std::string& effect, const DiagnosisEffects& effects);

} // namespace culm::cli
