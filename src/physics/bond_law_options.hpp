// SPDX-License-Identifier: BSD-3-Clause
// Variants of the published bond law, and the two that have names in culm.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace culm::physics {

/// The inertia under the roots of the damping coefficients (Eqs. 7-10).
enum class DampingInertia {
    Reduced,    ///< m1 m2/(m1+m2) and J1 J2/(J1+J2), as in the authors' code
    Individual, ///< twice the reduced value: the sphere's own for equal spheres, as the paper says
};

/// Choices that the paper's text leaves open; docs/physics.md describes the effect of each of them
/// on the decay.
struct BondLawOptions {
    /// Does the shear damping force exert a torque on the spheres, as the elastic one does?
    bool shear_damping_torque = false;
    /// Do the lever arms of the shear force follow the current length of the bond (true: angular
    /// momentum is conserved exactly) or stay at the radii (false: as in the authors' code)?
    bool lever_arms_follow_bond = false;
    /// The factor before β in the damping coefficients: 2 in the paper, √2 in Guo et al. (2013).
    double damping_factor = 2.0;
    DampingInertia damping_inertia = DampingInertia::Reduced;

    friend bool operator==(const BondLawOptions&, const BondLawOptions&) = default;
};

/// The law of the authors' public code: the shear damping force exerts no torque.
[[nodiscard]] inline BondLawOptions schramm2019_law() {
    return {};
}

/// The law that conserves angular momentum.
[[nodiscard]] inline BondLawOptions consistent_law() {
    return {.shear_damping_torque = true, .lever_arms_follow_bond = true};
}

/// Names that `law_by_name` accepts.
[[nodiscard]] inline std::vector<std::string> law_names() {
    return {"schramm2019", "consistent"};
}

/// The law of that name, or nothing.
[[nodiscard]] inline std::optional<BondLawOptions> law_by_name(std::string_view name) {
    if (name == "schramm2019")
        return schramm2019_law();
    if (name == "consistent")
        return consistent_law();
    return std::nullopt;
}

/// The name of the law, or "unnamed". A β is valid only together with its law.
[[nodiscard]] inline std::string law_name(const BondLawOptions& law) {
    for (const std::string& name : law_names()) {
        const BondLawOptions named = *law_by_name(name);
        if (named.shear_damping_torque == law.shear_damping_torque &&
            named.lever_arms_follow_bond == law.lever_arms_follow_bond)
            return name;
    }
    return "unnamed";
}

} // namespace culm::physics
