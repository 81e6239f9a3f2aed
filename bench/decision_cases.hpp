// SPDX-License-Identifier: BSD-3-Clause
// Simulated recordings for the decision: beams with hidden effects, flawed noise, wrong inputs.
#pragma once

#include "measure/folder/measurement.hpp"
#include "tests/beam_generator/hidden_effect.hpp"

#include <cstdint>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace culm::bench {

struct DecisionCase {
    std::vector<beam::HiddenEffect> hidden;
    std::vector<measure::Measurement> recordings; ///< as a laboratory writes them
    std::vector<measure::Measurement> exact;      ///< without noise, with exact inputs
};

/// {"seed", "kind", "number"} of `count` recordings: a third without an effect, a third with one
/// of the library, and of 60 recordings 8 with two, 6 pairs of one stem bare and with a known mass
/// (with one effect), 6 with a law that the library lacks.
[[nodiscard]] std::vector<nlohmann::json> decision_keys(std::uint64_t seed, std::size_t count);

/// The recordings of a key, the same on every machine. Stems, rigs and sizes of effects are those
/// of beam::random_case(). Every recording states a noise and has errors of that size: white ones,
/// and for seven of eight numbers one of noise_families. Length, diameter, density, heights, scale
/// and the known mass have normal errors with the standard uncertainties that culm
/// assumes.
[[nodiscard]] DecisionCase decision_case(const nlohmann::json& key);

} // namespace culm::bench
