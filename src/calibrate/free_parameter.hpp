// SPDX-License-Identifier: BSD-3-Clause
// A number of the model that a fit may change.
#pragma once

#include "run/sensitivities.hpp"

#include <string>
#include <vector>

namespace culm::calibrate {

struct FreeParameter {
    run::CaseParameter access; ///< name, how to read and to set it in a case; its typical size
    std::string unit;          ///< "Pa"; empty for a pure number
    double lower = 0.0;        ///< allowed range; the bounds belong to it
    double upper = 0.0;
    bool is_logarithmic = false; ///< fitted as its logarithm; lower must be positive
};

/// Y (Pa) and β, both as logarithms, and the tip's deflection before the release (m).
[[nodiscard]] std::vector<FreeParameter> baseline_free_parameters();

/// The number that the fit works on: its logarithm, or the number over its size in `spec`.
[[nodiscard]] double to_internal(const FreeParameter& parameter, const run::CaseSpec& start,
                                 double value);
[[nodiscard]] double from_internal(const FreeParameter& parameter, const run::CaseSpec& start,
                                   double internal);

} // namespace culm::calibrate
