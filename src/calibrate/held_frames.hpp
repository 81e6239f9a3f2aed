// SPDX-License-Identifier: BSD-3-Clause
// Frames before the release, on a support that vibrates.
#pragma once

#include "calibrate/stem_model.hpp"
#include "run/case_model.hpp"

#include <cstddef>
#include <vector>

namespace culm::calibrate {

/// The held stem, and what holds it, stand on the support and move with it as one body. (A finger
/// on firm ground would bend the stem in time with the support. The lower heights, where the motion
/// of the support is plainest, hardly tell the two apart.)
class HeldFrames {
  public:
    /// Throws core::InputError like run::case_model.
    explicit HeldFrames(const StemModel& model);

    [[nodiscard]] bool move() const { return case_.chain.base_motion.has_value(); }

    /// How far the camera sees the height aside of where it is at the release, m. `time` is that
    /// since the release, s.
    [[nodiscard]] double shift(double time, double height) const;

    /// Its derivative by a free parameter of the model, m per unit of that.
    [[nodiscard]] double derivative(std::size_t parameter, double time, double height) const;

    /// Its derivative by time, m/s.
    [[nodiscard]] double rate(double time, double height) const;

  private:
    struct Neighbours {
        run::CaseModel below, above;
        double distance; ///< between their values of the parameter
    };

    [[nodiscard]] double shift_of(const run::CaseModel& model, double time, double height) const;

    double free_length_;
    run::CaseModel case_;
    std::vector<Neighbours> neighbours_; ///< by parameter
};

} // namespace culm::calibrate
