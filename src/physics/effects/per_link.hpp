// SPDX-License-Identifier: BSD-3-Clause
// Gives every sphere and bond of a chain its own values and changes them along the stem.
#pragma once

#include "physics/chain_model.hpp"
#include "physics/effects/effect.hpp"

#include <functional>

namespace culm::physics {

/// Expands a list whose single entry applies to the whole chain of `sphere_count` spheres.
void expand_links(ChainModel<double>& model, int sphere_count);

/// Properties of the stem at `position` (m from the clamp), derived from those of the whole stem.
using LocalStem =
    std::function<StemParameters<double>(StemParameters<double> stem, double position)>;

/// Multiplies stiffness and damping of every bond, and mass and inertia of every sphere, by the
/// ratio of the bond law's values for the local stem to those for the whole stem. The local stem is
/// that at the middle of a bond and at the centre of a sphere. Several changes may be applied in
/// any order. The lengths and lever arms of the bonds do not change.
void change_along_stem(EffectTarget& target, const LocalStem& local);

/// Adds the target's attached masses to the spheres, each shared by the two nearest so that its
/// centre is right. The bonds' damping stays that of the stem. Throws core::InputError for a
/// position below the clamp.
void join_attached_masses(EffectTarget& target);

} // namespace culm::physics
