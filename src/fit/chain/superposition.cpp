// SPDX-License-Identifier: BSD-3-Clause
#include "fit/chain/superposition.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

namespace culm::fit {
namespace {

struct Parts {
    const physics::ActiveEffect* effect = nullptr;
    std::vector<physics::PlanarPart> parts;
};

Parts parts_of(const run::CaseSpec& spec) {
    for (const physics::ActiveEffect& active : spec.effects)
        if (auto parts = active.effect->planar_parts_of(active.values); !parts.empty())
            return {&active, std::move(parts)};
    return {};
}

/// Derivatives of weights and factors, which are smooth, by the coordinate of a free parameter of
/// the effect.
std::vector<physics::PlanarPart> derivative_of_parts(const StemModel& model,
                                                     const FreeParameter& parameter) {
    const SteppedCases cases = stepped(model.spec, parameter);
    const Parts at_below = parts_of(cases.below);
    std::vector<physics::PlanarPart> derivative = parts_of(cases.above).parts;
    for (std::size_t k = 0; k < derivative.size(); ++k) {
        derivative[k].weight = (derivative[k].weight - at_below.parts[k].weight) / cases.distance;
        derivative[k].modulus_factor =
            (derivative[k].modulus_factor - at_below.parts[k].modulus_factor) / cases.distance;
    }
    return derivative;
}

bool is_of(const FreeParameter& parameter, const physics::Effect& effect) {
    return parameter.access.id.effect == effect.name;
}

/// Adds the derivatives of one part to those of the sum. `part_derivatives`: by the effect's
/// parameters.
void add_derivatives(const StemModel& model, const physics::Effect& effect, const PlanarModel& part,
                     const ChainPrediction& prediction,
                     const std::vector<physics::PlanarPart>& part_derivatives,
                     ChainPrediction& sum) {
    const std::size_t modulus_place = part.model.place_of(physics::bond_youngs_modulus);
    for (std::size_t at = 0; at < prediction.readings.size(); ++at) {
        const double* from = prediction.jacobian.data() + at * prediction.parameters;
        double* to = sum.jacobian.data() + at * sum.parameters;
        std::size_t own = 0;
        std::size_t k = 0;
        for (std::size_t c = 0; c < sum.parameters; ++c) {
            if (c < model.parameters.size() && is_of(model.parameters[c], effect)) {
                const physics::PlanarPart& change = part_derivatives[own++];
                to[c] +=
                    change.weight * prediction.readings[at] +
                    part.weight * from[modulus_place] * change.modulus_factor / part.modulus_factor;
                continue;
            }
            to[c] += part.weight * from[k++];
        }
    }
}

} // namespace

std::vector<PlanarModel> planar_models(const StemModel& model) {
    const Parts found = parts_of(model.spec);
    std::vector<PlanarModel> models;
    if (found.effect == nullptr)
        return models;
    models.reserve(found.parts.size());
    for (const physics::PlanarPart& part : found.parts) {
        PlanarModel& planar =
            models.emplace_back(PlanarModel{part.weight, part.modulus_factor, model});
        const physics::EffectPointer effect = found.effect->effect;
        std::erase_if(planar.model.spec.effects,
                      [&](const physics::ActiveEffect& active) { return active.effect == effect; });
        std::erase_if(planar.model.parameters,
                      [&](const FreeParameter& each) { return is_of(each, *effect); });
        planar.model.spec.stem.bond_youngs_modulus *= part.modulus_factor;
    }
    return models;
}

ChainPrediction superposed(const StemModel& model, const std::vector<PlanarModel>& parts,
                           const std::vector<ChainPrediction>& predictions) {
    const Parts found = parts_of(model.spec);
    if (found.effect == nullptr)
        return predictions.front(); // a planar model is its only part
    const physics::Effect& effect = *found.effect->effect;
    const bool has_derivatives = predictions.front().parameters == parts.front().model.free_count();
    std::vector<std::vector<physics::PlanarPart>> derivatives(
        parts.size()); // (effect's parameters)
    for (const FreeParameter& parameter : model.parameters) {
        if (!is_of(parameter, effect))
            continue;
        const std::vector<physics::PlanarPart> by = derivative_of_parts(model, parameter);
        for (std::size_t k = 0; k < parts.size(); ++k)
            derivatives[k].push_back(by[k]);
    }
    ChainPrediction sum = predictions.front();
    sum.parameters = has_derivatives ? model.free_count() : 0;
    sum.batches = 0;
    sum.readings.assign(sum.readings.size(), 0.0);
    sum.jacobian.assign(sum.readings.size() * sum.parameters, 0.0);
    for (std::size_t k = 0; k < parts.size(); ++k) {
        sum.batches += predictions[k].batches;
        for (std::size_t at = 0; at < sum.readings.size(); ++at)
            sum.readings[at] += parts[k].weight * predictions[k].readings[at];
        if (has_derivatives)
            add_derivatives(model, effect, parts[k], predictions[k], derivatives[k], sum);
    }
    return sum;
}

} // namespace culm::fit
