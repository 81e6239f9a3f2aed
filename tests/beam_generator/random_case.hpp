// SPDX-License-Identifier: BSD-3-Clause
// Recordings drawn at random: stem, camera, noise, and what is hidden in them.
#pragma once

#include "beam_generator/recording.hpp"

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace culm::beam {

/// What is hidden: nothing, one or two effects of the library, one that the library lacks, or one
/// of further_effects().
enum class CaseKind { Null, Single, Pair, Unknown, Further };

[[nodiscard]] std::string_view to_string(CaseKind kind);
/// The kind of this name. Throws std::invalid_argument if there is none.
[[nodiscard]] CaseKind case_kind(std::string_view name);

struct RandomCase {
    CaseKind kind = CaseKind::Null;
    std::uint64_t number = 0;
    RecordingSpec spec; ///< with the hidden effects
};

/// Case `number` of a seed: the same whatever was drawn before. Single, Unknown and Further take
/// the effects of their lists in turn (plate_air in a strip 5 to 20 times as wide as it is thick),
/// Pair takes all combinations that culm allows in turn, in a fixed shuffled order; everything else
/// is drawn:
///
/// * stem: length 0.14 … 0.18 m, diameter 2.4 … 3.4 mm, density 100 … 180 kg/m³, Y 1.2 … 3.5 GPa,
///   damping ratio of mode 1 0.01 … 0.045 (wheat straw and switchgrass);
/// * recording: tip deflection 15 … 25 mm, 0.2 … 0.5 s after the release at 1000 frames/s, up to 10
///   frames before it, 6 … 14 rows, white noise of 0.02 … 0.1 mm (log-uniform) that is stated;
/// * effects: log-uniform between a strength that such a record hardly shows and a strong one, over
///   scales of the stem (random_effect.cpp).
[[nodiscard]] RandomCase random_case(std::uint64_t seed, CaseKind kind, std::uint64_t number);

/// Combinations of two effects of the library that do not exclude each other.
[[nodiscard]] std::vector<std::vector<std::string>> effect_pairs();

} // namespace culm::beam
