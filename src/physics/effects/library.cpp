// SPDX-License-Identifier: BSD-3-Clause
#include "physics/effects/library.hpp"

#include "core/error.hpp"
#include "core/nearest_name.hpp"

#include <algorithm>
#include <functional>
#include <map>
#include <stdexcept>

#include <fmt/format.h>

namespace culm::physics {

/// The library. An effect's file defines the function of its name; this is the one line that
/// registers it.
#define CULM_EFFECTS(EFFECT)                                                                       \
    EFFECT(taper)                                                                                  \
    EFFECT(stiffness_gradient)                                                                     \
    EFFECT(local_defect)                                                                           \
    EFFECT(precurvature)                                                                           \
    EFFECT(out_of_plane)                                                                           \
    EFFECT(bending_nonlinearity)                                                                   \
    EFFECT(hysteretic_damping)                                                                     \
    EFFECT(relaxation)                                                                             \
    EFFECT(fractional_zener)                                                                       \
    EFFECT(amplitude_damping)                                                                      \
    EFFECT(clamp_compliance)                                                                       \
    EFFECT(clamp_friction)                                                                         \
    EFFECT(clamp_slip)                                                                             \
    EFFECT(base_motion)                                                                            \
    EFFECT(gravity)                                                                                \
    EFFECT(tip_mass)                                                                               \
    EFFECT(quadratic_drag)                                                                         \
    EFFECT(viscous_drag)                                                                           \
    EFFECT(power_drag)                                                                             \
    EFFECT(plate_air)                                                                              \
    EFFECT(still_air)                                                                              \
    EFFECT(finite_release)                                                                         \
    EFFECT(rolling_shutter)                                                                        \
    EFFECT(camera_tilt)

#define CULM_DECLARED(name) EffectPointer name();
CULM_EFFECTS(CULM_DECLARED)
#undef CULM_DECLARED

std::vector<EffectPointer> all_effects() {
#define CULM_LISTED(name) name(),
    static const std::vector<EffectPointer> library{CULM_EFFECTS(CULM_LISTED)};
#undef CULM_LISTED
    return library;
}

std::vector<std::string> effect_names() {
    std::vector<std::string> names;
    for (const EffectPointer& effect : all_effects())
        names.push_back(effect->name);
    return names;
}

EffectPointer effect_named(std::string_view name) {
    for (const EffectPointer& effect : all_effects())
        if (effect->name == name)
            return effect;
    throw core::InputError(
        fmt::format("there is no effect \"{}\"{}; `culm effects` lists those there are", name,
                    core::did_you_mean(name, effect_names())));
}

BelongsTo belongs_to(std::string_view name) {
    static const auto owners = [] {
        std::map<std::string, BelongsTo, std::less<>> map;
        for (const EffectPointer& effect : all_effects())
            map.emplace(effect->name, effect->belongs_to);
        return map;
    }();
    const auto found = owners.find(name);
    return found == owners.end() ? BelongsTo::Stem : found->second;
}

void check_combination(std::span<const EffectPointer> effects) {
    std::vector<std::string> names;
    for (const EffectPointer& effect : effects) {
        if (std::ranges::find(names, effect->name) != names.end())
            throw core::InputError(
                fmt::format("effect {} is named twice; once is enough", effect->name));
        names.push_back(effect->name);
    }
    for (const EffectPointer& effect : effects)
        for (const std::string& other : effect->excludes)
            if (std::ranges::find(names, other) != names.end())
                throw core::InputError(fmt::format(
                    "effects {0} and {1} cannot be combined: {0} contains {1}; leave {1} out",
                    effect->name, other));
}

void apply_effects(std::span<const ActiveEffect> effects, EffectTarget& target) {
    std::vector<EffectPointer> pointers;
    std::vector<const ActiveEffect*> ordered;
    for (const ActiveEffect& active : effects) {
        pointers.push_back(active.effect);
        ordered.push_back(&active);
    }
    check_combination(pointers);
    const std::vector<std::string> names = effect_names();
    // In the order of the library, so that the model does not depend on the order in which the user
    // names the effects; a user's effect has its place past the end.
    std::ranges::stable_sort(ordered, {}, [&](const ActiveEffect* active) {
        return std::ranges::find(names, active->effect->name);
    });
    for (const ActiveEffect* active : ordered) {
        if (active->values.size() != active->effect->parameters.size())
            throw std::logic_error("an effect needs a value for each of its parameters");
        active->effect->apply(active->values, target);
    }
    join_attached_masses(target);
}

std::string value_fault(const Effect& effect, const EffectParameter& parameter, double value) {
    if (value >= parameter.lower && value <= parameter.upper)
        return "";
    return fmt::format("{}.{} = {}: must be a number from {} to {}{}{}", effect.name,
                       parameter.name, value, parameter.lower, parameter.upper,
                       parameter.unit.empty() ? "" : " ", parameter.unit);
}

} // namespace culm::physics
