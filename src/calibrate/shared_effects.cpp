// SPDX-License-Identifier: BSD-3-Clause
#include "calibrate/shared_effects.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include <fmt/core.h>

namespace culm::calibrate {
namespace {

bool is_shared(const physics::SelectedEffect& effect) {
    return effect.effect->belongs_to == physics::BelongsTo::Rig &&
           !diagnose::free_parameters(effect).empty();
}

bool any_rig_has_several(std::span<const measure::Measurement> measurements) {
    std::map<std::string, int> recordings;
    for (const measure::Measurement& each : measurements)
        if (!each.rig.empty() && ++recordings[each.rig] > 1)
            return true;
    return false;
}

} // namespace

SharedEffects fit_shared_effects(std::span<const measure::Measurement> measurements,
                                 const CalibrationOptions& options, const core::ItemMap& map,
                                 const std::function<void(const std::string&)>& progress) {
    if (!any_rig_has_several(measurements) || std::ranges::none_of(options.effects, is_shared))
        return {};
    diagnose::DiagnosisOptions model;
    model.candidate = options.fit;
    model.known = options.effects;
    model.map = map;
    model.progress = progress;
    const std::vector<diagnose::Specimen> specimens = diagnose::specimens_of(measurements);
    diagnose::Diagnosis found = diagnose::decide(diagnose::search_models(specimens, model));
    std::erase_if(found.answers, [](const auto& each) { return each.values.empty(); });
    return {std::move(found.answers), std::move(found.stems)};
}

CalibrationOptions with_shared_values(const CalibrationOptions& options,
                                      const SharedEffects& shared,
                                      const measure::Measurement& measurement) {
    CalibrationOptions fixed = options;
    for (const diagnose::EffectAnswer& fitted : shared.effects)
        for (physics::SelectedEffect& effect : fixed.effects) {
            if (effect.effect->name != fitted.effect || measurement.rig != fitted.rig)
                continue;
            const std::vector<physics::EffectParameter>& parameters = effect.effect->parameters;
            for (const diagnose::SharedValue& value : fitted.values) {
                const auto place =
                    std::ranges::find(parameters, value.name, &physics::EffectParameter::name);
                effect.fixed[static_cast<std::size_t>(place - parameters.begin())] = value.value;
            }
        }
    return fixed;
}

void add_shared_uncertainty(const SharedEffects& shared, const measure::Measurement& measurement,
                            Calibration& calibration) {
    const auto stem =
        std::ranges::find(shared.stems, measurement.specimen_name(), &diagnose::StemAnswer::name);
    if (stem == shared.stems.end() || measurement.rig.empty())
        return;
    fit::BudgetInput line;
    line.input.name = fmt::format("effects shared by rig {}", measurement.rig);
    line.input.unit = std::string("1");
    line.input.standard_uncertainty = line.uncertainty_with_readings = 1.0;
    for (std::size_t p = 0; p < calibration.fit.parameters.size(); ++p) {
        fit::FittedParameter& parameter = calibration.fit.parameters[p];
        const double added = parameter.id == physics::bond_youngs_modulus
                                 ? stem->after.youngs_modulus_error_by_shared
                             : parameter.id == physics::bond_damping
                                 ? stem->after.damping_error_by_shared
                                 : 0.0;
        line.sensitivities.push_back(added);
        parameter.standard_error = std::hypot(parameter.standard_error, added);
        calibration.budget.combined[p] = parameter.standard_error;
    }
    calibration.budget.inputs.push_back(std::move(line));
}

} // namespace culm::calibrate
