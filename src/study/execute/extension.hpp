// SPDX-License-Identifier: BSD-3-Clause
// Whether a study extends another one, and which of its points are there already.
//
// The numbers of a point depend on the fixed settings and on the values of its factors alone, not
// on its place in the design. A study therefore extends another one if the fixed settings agree and
// its design contains every point of the other: more levels, a finer grid, a longer sequence, more
// replicates. Trap: a Latin hypercube changes all its points with their number, and in a factorial
// the drawn values belong to the number of the design point, which a new level may shift.
#pragma once

#include "study/execute/plan.hpp"

#include <cstdint>
#include <string>
#include <vector>

namespace culm::study {

struct ExtensionMap {
    /// (points of the new study) the point of the stored one with the same numbers; -1: new.
    std::vector<std::int64_t> stored_point;
    /// The new study stores more heights, or in another order: no stored history is kept.
    bool adds_heights = false;
};

/// Whether the two identities differ in nothing but factors, design, replicates and stored heights.
[[nodiscard]] bool may_extend(const std::string& stored, const std::string& now);

/// For studies whose identities may_extend. Throws core::InputError if the stored study has a point
/// or a height that the new one lacks; the message names it.
[[nodiscard]] ExtensionMap extension_of(const Study& stored, const Study& now);

} // namespace culm::study
