// SPDX-License-Identifier: BSD-3-Clause
// Simulated recordings for the decision: beams with hidden effects whose laws are not quite those
// of the library, flawed noise, wrong inputs.
#pragma once

#include "measure/folder/measurement.hpp"
#include "tests/beam_generator/hidden_effect.hpp"

#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

namespace culm::bench {

/// The recordings of a stem: one, or two of which the second has a known mass at the tip.
struct DecisionCase {
    std::vector<beam::HiddenEffect> hidden;
    std::vector<measure::Measurement> recordings; ///< as a laboratory writes them
    /// Without noise, with exact inputs and the second mode of the beam.
    std::vector<measure::Measurement> exact;
    /// Of a beam without effects whose second mode has the loss of the recordings', likewise.
    std::vector<measure::Measurement> lossy;
};

/// {"half", "kind", "number"} of the 175 cases of a half, "tuning" or "judging": 50 without an
/// effect ("null"), 60 with one of the library ("single"), 25 with two ("pair"), 15 with a law that
/// the library lacks ("unknown"), 5 with one effect and a second recording with a known mass at
/// the tip, 0.5 to 1.5 times that of the stem ("known_mass"), 20 with noise that is correlated by
/// 0.9 from frame to frame, every other one with an effect ("correlated"). The kinds alternate, so
/// that each part of the list is like the whole. Throws std::invalid_argument for another half.
[[nodiscard]] std::vector<nlohmann::json> decision_keys(std::string_view half);

/// The case of a key, the same on every machine. Stems, cameras and sizes of effects are those
/// of beam::random_case(). The laws differ from the library's (beam::LawErrors): drag exponents of
/// 1.6 to 2.1; soft clamps with a loss factor of 0 to 0.1; two or three relaxation times that span
/// a factor of 10; in every beam, another frequency (±2 %) and loss (a factor of 1.5) of the second
/// mode. The stated noise is the size of the errors, which are correlated from frame to frame (0 to
/// 0.9) and partly common to the rows, or, in three of eight numbers, one of the other families of
/// reading_noise.hpp. Length, diameter, density, heights and scale have normal errors with the
/// standard uncertainties that culm assumes.
[[nodiscard]] DecisionCase decision_case(const nlohmann::json& key);

} // namespace culm::bench
