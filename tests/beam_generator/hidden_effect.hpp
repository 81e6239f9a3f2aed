// SPDX-License-Identifier: BSD-3-Clause
// The truth behind a made-up recording: effects by culm's names, with values of their parameters.
#pragma once

#include "beam_generator/beam_stem.hpp"
#include "beam_generator/beam_terms.hpp"
#include "beam_generator/law_errors.hpp"

#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace culm::beam {

/// An effect of culm's library with the names and units of its parameters there, or one that the
/// library does not have (outside_effects()).
struct HiddenEffect {
    std::string name;
    std::vector<std::pair<std::string, double>> parameters;

    /// Throws core::InputError if there is no such parameter.
    [[nodiscard]] double value(std::string_view parameter) const;
};

/// Errors of the camera: a row at height h is read T h/L later and e h/L larger.
struct CameraFaults {
    double readout_time = 0.0; ///< T, s
    double scale_change = 0.0; ///< e
};

struct HiddenPhysics {
    BeamTerms terms;
    CameraFaults camera;
};

/// 18 effects of culm's library, in an order that numbers the cases of the bench.
[[nodiscard]] std::vector<std::string> library_effects();

/// The other effects of the library: what depends on the amplitude, and the air.
[[nodiscard]] std::vector<std::string> further_effects();

/// Effects that no entry of the library describes: tip_magnet, lossy_cable, impact_stop,
/// cubic_drag, curvature_damping; see beam_terms.hpp.
[[nodiscard]] std::vector<std::string> outside_effects();

/// Beam and camera with these effects. Throws core::InputError for a name that is not one of the
/// two lists.
[[nodiscard]] HiddenPhysics hidden_physics(const BeamStem& stem,
                                           const std::vector<HiddenEffect>& effects,
                                           const LawErrors& errors = {});

} // namespace culm::beam
