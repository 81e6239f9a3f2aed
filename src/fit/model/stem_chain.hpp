// SPDX-License-Identifier: BSD-3-Clause
// A measured stem as a chain of spheres, whatever its length and section.
#pragma once

#include "measure/folder/measurement.hpp"
#include "run/case_spec.hpp"

#include <optional>
#include <string>
#include <vector>

namespace culm::fit {

inline constexpr int default_sphere_count = 56; ///< of the paper

struct ChainOptions {
    std::optional<int> spheres; ///< empty: what the measurement asks for, else the default
    physics::BondLawOptions law = physics::consistent_law();
};

struct StemChain {
    run::CaseSpec spec;               ///< with places to read, but without Y, β and tip deflection
    std::vector<std::string> remarks; ///< what of the stem the chain cannot express, one sentence
};

/// The chain of a measured stem: n spheres, the first one's centre in the clamp (height 0) and the
/// last one's at the tip, so the bond length is L/(n−1). Each sphere has the mass of a bond length
/// of the stem (the density follows from that) and its diameter is the bond length; the last one
/// has half of it, because the stem ends at its centre. The bonds have the stem's section: a ring
/// of its area and second moment, of which the second moment counts where no ring has both; the
/// air resists a rectangle by its width across the motion, other sections by the ring's diameter.
/// Discretisation: docs/calibration.md. Throws core::InputError if the stem cannot be such a chain.
[[nodiscard]] StemChain chain_of(const measure::Measurement& measurement,
                                 const ChainOptions& options = {});

/// Length, mass and section of the measured stem as a chain of so many spheres. Returns what of the
/// section the chain cannot express, one sentence; empty if nothing.
std::string set_geometry(const measure::MeasuredStem& measured, int spheres,
                         physics::StemParameters<double>& stem);

/// Time τ of the internal damping, s: the bending moment is E I (κ + τ κ̇). Unlike β it does not
/// depend on the number of spheres. Under law "schramm2019" the shear dashpots, which exert no
/// torque, add theirs (docs/physics.md).
[[nodiscard]] double damping_time(const run::CaseSpec& spec);

/// The same stem as a chain of so many spheres, with the same damping time.
[[nodiscard]] run::CaseSpec with_spheres(run::CaseSpec spec, int spheres);

} // namespace culm::fit
