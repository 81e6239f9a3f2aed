// SPDX-License-Identifier: BSD-3-Clause
// An effect of the library as its texts, its parameters and one function that applies it.
#pragma once

#include "physics/effects/effect.hpp"

#include <span>
#include <string>
#include <vector>

namespace culm::physics {

/// What Effect's getters of the same names return.
struct EffectCard {
    std::string name;
    std::string summary;
    std::string law;
    std::string source;
    std::string signature;
    std::string remedy;
    std::string energy;
    std::vector<EffectParameter> parameters;
    std::vector<std::string> excludes = {};
    int dimensions = 2;
    BelongsTo belongs_to = BelongsTo::Stem;
    std::vector<RevealingExperiment> revealed_by = {};
    bool spans_the_stem = false;
    bool is_default_candidate = true;
};

using ApplyEffect = void (*)(std::span<const double> values, EffectTarget& target);
/// Narrows defaults, bounds and scales to what is sensible for one stem.
using SuitParameters = void (*)(const StemParameters<double>& stem,
                                std::span<EffectParameter> parameters);

[[nodiscard]] EffectPointer make_effect(EffectCard card, ApplyEffect apply,
                                        SuitParameters suit = nullptr);

} // namespace culm::physics
