// SPDX-License-Identifier: BSD-3-Clause
#include "fit/chain/stem_model.hpp"

#include "core/error.hpp"
#include "physics/effects/library.hpp"
#include "run/case_model.hpp"
#include "run/modes.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include <fmt/core.h>

namespace culm::fit {

namespace {

/// Share of the bonds' damping that remains at least if an effect adds damping.
constexpr double smallest_damping_share = 0.05;
constexpr double standard_gravity = 9.80665; // m/s²

/// The active effect of this name in a case.
template <class Spec>
auto& active_values(Spec& spec, const std::string& name) {
    const auto found = std::ranges::find_if(
        spec.effects, [&name](const auto& active) { return active.effect->name == name; });
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

/// Sets the values that the measurement states and the user does not fix. A user who fixes one
/// component of gravity fixes all of it.
void set_stated_values(const physics::SelectedEffect& selected,
                       const measure::Measurement& measurement, physics::ActiveEffect& active) {
    const std::vector<physics::EffectParameter>& parameters = selected.effect->parameters;
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

std::vector<physics::ParameterId> StemModel::free_ids() const {
    std::vector<physics::ParameterId> ids;
    for (const FreeParameter& parameter : parameters)
        ids.push_back(parameter.access.id);
    if (release_time_bound > 0.0)
        ids.push_back(physics::release_time);
    for (std::size_t k = 0; k < error_values.size(); ++k)
        ids.push_back({{}, errors->terms[k].id, {}});
    return ids;
}

std::size_t StemModel::place_of(const physics::ParameterId& id) const {
    const auto found = std::ranges::find_if(
        parameters, [&](const auto& parameter) { return parameter.access.id == id; });
    return static_cast<std::size_t>(found - parameters.begin());
}

double StemModel::value(std::size_t k) const {
    if (k < parameters.size())
        return parameters[k].access.get(spec);
    return is_error(k) ? error_values[k - first_error()] : release_time;
}

void StemModel::set_value(std::size_t k, double value) {
    if (k < parameters.size())
        parameters[k].access.set(spec, value);
    else if (is_error(k))
        error_values[k - first_error()] = value;
    else
        release_time = value;
}

std::pair<double, double> StemModel::bounds(std::size_t k) const {
    constexpr double none = std::numeric_limits<double>::infinity();
    if (k < parameters.size())
        return {parameters[k].lower, parameters[k].upper};
    if (is_error(k))
        return {-none, none};
    return {expected_release - release_time_bound, expected_release + release_time_bound};
}

run::CaseSpec computed_case(const StemModel& model) {
    run::CaseSpec spec = model.spec;
    for (std::size_t k = 0; k < model.error_values.size(); ++k) {
        const ErrorTerm& term = model.errors->terms[k];
        spec.stem.bond_youngs_modulus *= std::exp(model.error_values[k] * term.log_modulus);
        spec.stem.bond_damping *= std::exp(model.error_values[k] * term.log_damping);
    }
    return spec;
}

StemModel fixed_model(StemModel model) {
    model.spec = computed_case(model);
    model.errors.reset();
    model.error_values.clear();
    model.parameters.clear();
    model.release_time_bound = 0.0;
    return model;
}

StemModel with_error_terms(StemModel model, const ObservedRecording& recording) {
    const StemModel before = model;
    model.errors = recording.errors;
    model.error_values.assign(model.errors ? model.errors->terms.size() : 0, 0.0);
    for (std::size_t k = 0; k < before.error_values.size(); ++k)
        for (std::size_t now = 0; now < model.error_values.size(); ++now)
            if (model.errors->terms[now].id == before.errors->terms[k].id)
                model.error_values[now] = before.error_values[k];
    return model;
}

void set_first_mode(double frequency, double decay_rate, StemModel& model) {
    constexpr int passes = 3; // an effect's share of the stiffness depends on Y
    physics::StemParameters<double>& stem = model.spec.stem;
    for (int pass = 0; pass < passes; ++pass) {
        const double ratio = frequency / run::lightly_damped_mode(model.spec).frequency;
        if (!std::isfinite(ratio))
            return;
        stem.bond_youngs_modulus *= ratio * ratio;
    }
    run::CaseSpec half = model.spec;
    half.stem.bond_damping *= 0.5;
    const double now = run::lightly_damped_mode(model.spec).decay_rate;
    // The decay is linear in β.
    const double from_bonds = 2.0 * (now - run::lightly_damped_mode(half).decay_rate);
    if (from_bonds < 0.0)
        stem.bond_damping *=
            std::max(1.0 - (now - decay_rate) / from_bonds, smallest_damping_share);
}

void keep_first_mode(const run::CaseSpec& wanted, StemModel& model) {
    const integrate::VibrationMode mode = run::lightly_damped_mode(wanted);
    set_first_mode(mode.frequency, mode.decay_rate, model);
}

StemModel with_spheres(StemModel model, int spheres) {
    const run::CaseSpec before = model.spec;
    model.spec = with_spheres(std::move(model.spec), spheres);
    keep_first_mode(before, model);
    return model;
}

FreeParameter effect_parameter(const physics::Effect& effect,
                               const physics::StemParameters<double>& stem, std::size_t parameter) {
    FreeParameter out{effect.parameters_for(stem).at(parameter), {}};
    const std::string name = effect.name;
    out.access = {{name, out.name, {}},
                  [name, parameter](const run::CaseSpec& spec) {
                      return active_values(spec, name)[parameter];
                  },
                  [name, parameter](run::CaseSpec& spec, double value) {
                      active_values(spec, name)[parameter] = value;
                  },
                  out.fitted_as == physics::FittedAs::Logarithm ? 0.0 : out.scale};
    return out;
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
    const std::vector<physics::EffectParameter>& parameters = selected.effect->parameters;
    for (std::size_t k = 0; k < parameters.size(); ++k)
        if (parameters[k].calibrated && !selected.fixed[k])
            model.parameters.push_back(effect_parameter(*selected.effect, model.spec.stem, k));
    return model;
}

SelectedEffects in_library_order(SelectedEffects effects) {
    const std::vector<std::string> names = physics::effect_names();
    std::ranges::stable_sort(effects, {}, [&names](const physics::SelectedEffect& selected) {
        const std::string name = selected.effect->name; // a user's effect is not among the names
        return std::pair(std::ranges::find(names, name), name);
    });
    return effects;
}

bool contains(const SelectedEffects& effects, const physics::SelectedEffect& wanted) {
    return std::ranges::any_of(
        effects, [&](const auto& each) { return each.effect->name == wanted.effect->name; });
}

std::vector<std::string> model_names(const SelectedEffects& effects) {
    std::vector<std::string> names{"baseline"};
    for (const physics::SelectedEffect& selected : effects)
        names.push_back(selected.effect->name);
    return names;
}

StemModel candidate_model(const StemModel& baseline, const SelectedEffects& effects,
                          const measure::Measurement& measurement) {
    StemModel model = baseline;
    for (const physics::SelectedEffect& selected : in_library_order(effects))
        if (std::ranges::find(selected.absent_from, measurement.stem.id) ==
            selected.absent_from.end())
            model = with_effect(std::move(model), selected, measurement);
    return model;
}

bool is_nested(const StemModel& model) {
    return std::ranges::all_of(model.spec.effects, [&model](const auto& active) {
        return std::ranges::any_of(model.parameters, [&](const auto& parameter) {
            return parameter.access.id.effect == active.effect->name && !parameter.is_place;
        });
    });
}

bool can_move(const StemModel& model, const measure::Measurement& recording) {
    if (recording.release != measure::ReleaseKind::HeldStraight)
        return true;
    const physics::ChainModel<double> chain = run::case_model(model.spec).chain;
    return chain.gravity[1] != 0.0 || !chain.straight_moments.empty() || chain.base_motion ||
           !chain.user_laws.empty();
}

SelectedEffects candidate_effects(std::span<const measure::Measurement> recordings) {
    const auto is_moving = [](const measure::Measurement& recording) {
        return recording.release == measure::ReleaseKind::Moving;
    };
    const auto has_camera = [](const measure::Measurement& recording) {
        return recording.sensors.empty() ||
               std::ranges::any_of(recording.sensors, &measure::Sensor::is_camera);
    };
    const auto has_no_edges = [](const measure::Measurement& recording) {
        return !std::holds_alternative<measure::RectangularSection>(recording.stem.section);
    };
    const auto has_no_direction = [](const measure::Measurement& recording) {
        return recording.gravity_direction == measure::GravityDirection::None;
    };
    SelectedEffects candidates;
    for (const physics::EffectPointer& effect : physics::all_effects()) {
        if (effect->is_of_the_release && std::ranges::any_of(recordings, is_moving))
            continue;
        if (effect->needs_edges && std::ranges::any_of(recordings, has_no_edges))
            continue;
        if (effect->is_of_the_camera && std::ranges::none_of(recordings, has_camera))
            continue;
        const bool needs_direction = std::ranges::any_of(
            effect->parameters, [](const auto& of) { return is_gravity(of.stated_by); });
        if (needs_direction && std::ranges::any_of(recordings, has_no_direction))
            continue;
        candidates.push_back(
            {effect, std::vector<std::optional<double>>(effect->parameters.size())});
    }
    return candidates;
}

} // namespace culm::fit
