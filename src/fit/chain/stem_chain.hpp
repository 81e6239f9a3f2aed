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
    std::optional<int> spheres; ///< empty: that of the measurement, else the default
    physics::BondLawOptions law = physics::consistent_law();
    double relative_tolerance = run::Integrator().relative_tolerance;
};

struct StemChain {
    run::CaseSpec spec;               ///< with the heights, but without Y, β and tip deflection
    std::vector<std::string> remarks; ///< sentences on what the chain cannot represent
};

/// The chain of a measured stem: n spheres, with the centre of the first in the clamp (height 0)
/// and that of the last at the tip, so the bond length is L/(n−1). Each sphere has the mass of a
/// bond length of the stem, which determines its density, and its diameter is the bond length. The
/// last sphere has half that mass, because the stem ends at its centre. The bonds are rings of the
/// section's area and second moment, or of the second moment alone if no ring has both. The air
/// resists a rectangle by its width across the motion, other sections by the ring's diameter.
/// Discretisation: docs/calibration.md. Throws core::InputError if the stem cannot be such a chain.
[[nodiscard]] StemChain chain_of(const measure::Measurement& measurement,
                                 const ChainOptions& options = {});

/// Sets length, mass and section of the measured stem for a chain of `spheres` spheres. Returns a
/// sentence on the properties of the section that the chain cannot represent; empty if none.
std::string set_geometry(const measure::MeasuredStem& measured, int spheres,
                         physics::StemParameters<double>& stem);

/// Time τ of the internal damping, s: the bending moment is E I (κ + τ κ̇). Unlike β it does not
/// depend on the number of spheres. Under law "schramm2019" the shear dashpots, which exert no
/// torque, add to it (docs/physics.md).
[[nodiscard]] double damping_time(const run::CaseSpec& spec);

/// The same stem as a chain of `spheres` spheres, with the same damping time.
[[nodiscard]] run::CaseSpec with_spheres(run::CaseSpec spec, int spheres);

} // namespace culm::fit
