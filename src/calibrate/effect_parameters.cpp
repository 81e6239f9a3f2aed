// SPDX-License-Identifier: BSD-3-Clause
#include "calibrate/effect_parameters.hpp"

#include "core/error.hpp"
#include "physics/effects/library.hpp"

#include <algorithm>
#include <utility>

#include <fmt/core.h>

namespace culm::calibrate {
namespace {

constexpr double standard_gravity = 9.80665; // m/s²

/// The effect of that name among a case's.
template <class Spec>
auto& active_values(Spec& spec, const std::string& name) {
    const auto found = std::ranges::find_if(
        spec.effects, [&name](const auto& active) { return active.effect->name() == name; });
    if (found == spec.effects.end())
        throw core::InputError(fmt::format("the model does not contain the effect {}", name));
    return found->values;
}

bool is_gravity(physics::StatedBy stated_by) {
    return stated_by == physics::StatedBy::AxialGravity ||
           stated_by == physics::StatedBy::TransverseGravity;
}

double stated_gravity(physics::StatedBy component, const measure::Measurement& measurement) {
    const bool is_axial = component == physics::StatedBy::AxialGravity;
    switch (measurement.gravity_direction) {
    case measure::GravityDirection::Axial:
        return is_axial ? -standard_gravity : 0.0;
    case measure::GravityDirection::Transverse:
        return is_axial ? 0.0 : standard_gravity;
    case measure::GravityDirection::None:
        break;
    }
    throw core::InputError(
        fmt::format("{}: gravity has no direction; write gravity_direction = \"axial\" or "
                    "\"transverse\" in [measurement] of stem.toml",
                    measurement.stem.id));
}

/// Sets what the measurement states and the user does not fix. Who fixes one component of gravity
/// means all of it.
void set_stated_values(const physics::SelectedEffect& selected,
                       const measure::Measurement& measurement, physics::ActiveEffect& active) {
    const std::vector<physics::EffectParameter> parameters = selected.effect->parameters();
    bool is_gravity_fixed = false;
    for (std::size_t k = 0; k < parameters.size(); ++k)
        is_gravity_fixed |= is_gravity(parameters[k].stated_by) && selected.fixed[k].has_value();
    for (std::size_t k = 0; k < parameters.size(); ++k)
        if (is_gravity(parameters[k].stated_by) && !is_gravity_fixed)
            active.values[k] = stated_gravity(parameters[k].stated_by, measurement);
        else if (parameters[k].stated_by == physics::StatedBy::HoldTime && !selected.fixed[k])
            active.values[k] = measurement.hold_time.value_or(active.values[k]);
}

} // namespace

FreeParameter effect_parameter(const physics::Effect& effect,
                               const physics::StemParameters<double>& stem, std::size_t parameter) {
    const physics::EffectParameter described = effect.parameters_for(stem).at(parameter);
    const std::string name = effect.name();
    run::CaseParameter access{
        fmt::format("{}.{}", name, described.name),
        [name, parameter](const run::CaseSpec& spec) {
            return active_values(spec, name)[parameter];
        },
        [name, parameter](run::CaseSpec& spec, double value) {
            active_values(spec, name)[parameter] = value;
        },
        described.fitted_as == physics::FittedAs::Logarithm ? 0.0 : described.scale};
    return {std::move(access),   described.unit,     described.lower, described.upper,
            described.fitted_as, described.is_place, described.absent};
}

StemModel with_effect(StemModel model, const physics::SelectedEffect& selected,
                      const measure::Measurement& measurement) {
    physics::ActiveEffect active = physics::with_defaults(selected, model.spec.stem);
    set_stated_values(selected, measurement, active);
    model.spec.effects.push_back(std::move(active));
    std::vector<physics::EffectPointer> effects;
    for (const physics::ActiveEffect& each : model.spec.effects)
        effects.push_back(each.effect);
    physics::check_combination(effects);
    const std::vector<physics::EffectParameter> parameters = selected.effect->parameters();
    for (std::size_t k = 0; k < parameters.size(); ++k)
        if (parameters[k].calibrated && !selected.fixed[k])
            model.parameters.push_back(effect_parameter(*selected.effect, model.spec.stem, k));
    return model;
}

} // namespace culm::calibrate
