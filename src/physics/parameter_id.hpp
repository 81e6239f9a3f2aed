// SPDX-License-Identifier: BSD-3-Clause
// Identifies a parameter of a model.
#pragma once

#include <compare>
#include <string>
#include <utility>

namespace culm::physics {

/// A parameter of the chain, of the release or of an effect. All recordings share it, or it belongs
/// to one recording.
struct ParameterId {
    std::string effect;    ///< its name; empty: a parameter of the chain or of the release
    std::string name;      ///< as EffectParameter::name, or one of those below
    std::string recording; ///< the one that it belongs to; empty: all recordings share it

    [[nodiscard]] bool is_of_effect() const { return !effect.empty(); }
    [[nodiscard]] bool is_one_recordings_own() const { return !recording.empty(); }
    /// The parameter in the model of one recording, which does not refer to other recordings.
    [[nodiscard]] ParameterId in_one_model() const { return {effect, name, {}}; }
    /// The parameter of one recording.
    [[nodiscard]] ParameterId of_recording(std::string id) const {
        return {effect, name, std::move(id)};
    }

    bool operator==(const ParameterId&) const = default;
    // clang-tidy 14 reports a 0 in the code that the compiler generates here.
    // NOLINTNEXTLINE(modernize-use-nullptr)
    auto operator<=>(const ParameterId&) const = default;
};

/// "bond_damping", "tip_mass.mass_kg", "tip_mass.mass_kg@S07".
[[nodiscard]] inline std::string to_string(const ParameterId& id) {
    return (id.effect.empty() ? "" : id.effect + ".") + id.name +
           (id.recording.empty() ? "" : "@" + id.recording);
}

// Only an allocation of twenty characters could throw before main here.
// NOLINTBEGIN(cert-err58-cpp)
inline const ParameterId bond_youngs_modulus{{}, "bond_youngs_modulus", {}};
inline const ParameterId bond_damping{{}, "bond_damping", {}};
inline const ParameterId tip_deflection{{}, "tip_deflection", {}}; ///< before the release
inline const ParameterId release_time{{}, "release_time", {}};
// NOLINTEND(cert-err58-cpp)

/// Is it a number of a higher mode in one recording, "mode_2_speed"? Those of the first mode are
/// parameters of the chain.
[[nodiscard]] inline bool is_of_higher_mode(const ParameterId& id) {
    return id.effect.empty() && id.name.starts_with("mode_");
}

/// Is it a parameter of how the stem was let go?
[[nodiscard]] inline bool is_of_release(const ParameterId& id) {
    return id == tip_deflection || id == release_time || is_of_higher_mode(id);
}

} // namespace culm::physics
