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

/// Gravity as the measurement states its direction.
void set_direction(const physics::SelectedEffect& selected, const measure::Measurement& measurement,
                   physics::ActiveEffect& active) {
    if (selected.fixed[0] || selected.fixed[1])
        return;
    switch (measurement.gravity_direction) {
    case measure::GravityDirection::Axial:
        active.values = {-standard_gravity, 0.0};
        return;
    case measure::GravityDirection::Transverse:
        active.values = {0.0, standard_gravity};
        return;
    case measure::GravityDirection::None:
        throw core::InputError(
            fmt::format("{}: gravity has no direction; write gravity_direction = \"axial\" or "
                        "\"transverse\" in [measurement] of stem.toml",
                        measurement.stem.id));
    }
}

/// For how long the stem was held, as the measurement states it.
void set_hold_time(const physics::SelectedEffect& selected, const measure::Measurement& measurement,
                   physics::ActiveEffect& active) {
    const std::vector<physics::EffectParameter> parameters = selected.effect->parameters();
    for (std::size_t k = 0; k < parameters.size(); ++k)
        if (parameters[k].name == "hold_time_s" && !selected.fixed[k] && measurement.hold_time)
            active.values[k] = *measurement.hold_time;
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
    if (selected.effect->name() == "gravity")
        set_direction(selected, measurement, active);
    else if (selected.effect->name() == "relaxation")
        set_hold_time(selected, measurement, active);
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
