// SPDX-License-Identifier: BSD-3-Clause
// What ruler, balance and camera stated of a stem, and how well it is known.
#pragma once

#include "measure/folder/measurement.hpp"
#include "run/sensitivities.hpp"

#include <string>
#include <vector>

namespace culm::fit {

/// A quantity that enters the model as a number, although it was measured. SI units.
struct StatedInput {
    /// The number in the fitted case. Scale and clamp height move the heights of the case; 0 is what
    /// was stated.
    run::CaseParameter access;
    std::string name; ///< "length", "mass at 156 mm"
    std::string unit; ///< "m"; empty: a share
    double value = 0.0;
    double standard_uncertainty = 0.0; ///< one standard deviation (JCGM 100)
    bool is_default = false;           ///< the file states none
    bool scales_readings = false;      ///< true: deflections grow with it, as the heights do
    bool scales_times = false;         ///< true: it acts on the clock alone; `access` is empty
};

/// Length, section, density, added masses, scale and clamp height of the picture, frame rate. Where
/// the file states no uncertainty that of a careful laboratory counts: length 0.3 mm, clamp height
/// 0.2 mm, scale 0.5 %, every other quantity 1 % (docs/uncertainty.md); a frame rate is exact.
/// Inputs of uncertainty 0 are left out.
[[nodiscard]] std::vector<StatedInput> stated_inputs(const measure::Measurement& measurement);

} // namespace culm::fit
