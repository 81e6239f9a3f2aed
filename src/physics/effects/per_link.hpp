// SPDX-License-Identifier: BSD-3-Clause
// Gives every sphere and bond of a chain numbers of its own and changes them along the stem.
#pragma once

#include "physics/chain_model.hpp"
#include "physics/effects/effect.hpp"

#include <functional>

namespace culm::physics {

/// Expands lists with a single entry that stands for a chain of equals. `sphere_count` is that of
/// the chain.
void expand_links(ChainModel<double>& model, int sphere_count);

/// Properties of the stem at `position` (m from the clamp), derived from those of the whole stem.
using LocalStem =
    std::function<StemParameters<double>(StemParameters<double> stem, double position)>;

/// Multiplies stiffness and damping of every bond, and mass and inertia of every sphere, by what
/// the bond law makes of the local stem over what it makes of the stem as a whole. Bonds see their
/// middle, spheres their centre. Several such changes may follow each other in any order. The
/// lengths and lever arms of the bonds stay.
void change_along_stem(EffectTarget& target, const LocalStem& local);

/// Adds the target's attached masses to the spheres, each shared by the two nearest so that its
/// centre is right. The bonds' damping stays that of the stem. Throws core::InputError for a
/// position below the clamp.
void join_attached_masses(EffectTarget& target);

} // namespace culm::physics
