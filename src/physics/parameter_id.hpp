// SPDX-License-Identifier: BSD-3-Clause
// Which number of a model is meant.
#pragma once

#include <compare>
#include <string>
#include <utility>

namespace culm::physics {

/// A number of the chain, of the release or of an effect. It is one number for all recordings, or
/// one recording's own.
struct ParameterId {
    std::string effect;    ///< its name; empty: a number of the chain or of the release
    std::string name;      ///< as EffectParameter::name, or one of those below
    std::string recording; ///< whose own number it is; empty: all recordings share it

    [[nodiscard]] bool is_of_effect() const { return !effect.empty(); }
    [[nodiscard]] bool is_one_recordings_own() const { return !recording.empty(); }
    /// The number in one recording's model, which does not know of other recordings.
    [[nodiscard]] ParameterId in_one_model() const { return {effect, name, {}}; }
    /// As one recording's own.
    [[nodiscard]] ParameterId of_recording(std::string id) const {
        return {effect, name, std::move(id)};
    }

    bool operator==(const ParameterId&) const = default;
    // clang-tidy 14 sees a 0 in what the compiler writes here.
    // NOLINTNEXTLINE(modernize-use-nullptr)
    auto operator<=>(const ParameterId&) const = default;
};

template <class Wire>
void fields(Wire& wire, ParameterId& id) {
    wire(id.effect, id.name, id.recording);
}

/// "bond_damping", "tip_mass.mass_kg", "tip_mass.mass_kg@S07".
[[nodiscard]] inline std::string to_string(const ParameterId& id) {
    return (id.effect.empty() ? "" : id.effect + ".") + id.name +
           (id.recording.empty() ? "" : "@" + id.recording);
}

// What could throw before main here is an allocation of twenty characters.
// NOLINTBEGIN(cert-err58-cpp)
inline const ParameterId bond_youngs_modulus{{}, "bond_youngs_modulus", {}};
inline const ParameterId bond_damping{{}, "bond_damping", {}};
inline const ParameterId tip_deflection{{}, "tip_deflection", {}}; ///< before the release
inline const ParameterId release_time{{}, "release_time", {}};
// NOLINTEND(cert-err58-cpp)

} // namespace culm::physics
