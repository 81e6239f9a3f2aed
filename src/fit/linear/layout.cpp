// SPDX-License-Identifier: BSD-3-Clause
#include "fit/linear/layout.hpp"

#include "core/error.hpp"
#include "physics/effects/library.hpp"

#include <algorithm>
#include <map>

#include <fmt/core.h>

namespace culm::fit {

namespace {

/// The recordings' ids, made unique.
std::vector<std::string> unique_ids(std::span<const ObservedRecording> measurements) {
    std::vector<std::string> ids;
    std::map<std::string, int> seen;
    for (const ObservedRecording& measurement : measurements) {
        const int count = ++seen[measurement.stem.id];
        ids.push_back(count == 1 ? measurement.stem.id
                                 : fmt::format("{}:{}", measurement.stem.id, count));
    }
    return ids;
}

/// τ per β. Chains differ in it by a factor that depends only on geometry and mass if both have the
/// same modulus.
double damping_time_per_beta(const StemModel& model, double youngs_modulus) {
    run::CaseSpec spec = model.spec;
    spec.stem.bond_youngs_modulus = youngs_modulus;
    spec.stem.bond_damping = 1.0;
    return damping_time(spec);
}

double factor_of(const physics::ParameterId& id, const StemModel& model, const StemModel& owner) {
    if (id != physics::bond_damping)
        return 1.0;
    const double modulus = owner.spec.stem.bond_youngs_modulus;
    return damping_time_per_beta(owner, modulus) / damping_time_per_beta(model, modulus);
}

/// A parameter of a model that is shared with other models.
struct Shared {
    StemModel* model = nullptr;
    FreeParameter* parameter = nullptr;
    double factor = 1.0;
};

/// The models that share the joint parameter at `place`, the owner first; none for release times.
std::vector<Shared> shared_by(std::vector<StemModel>& models, const JointLayout& layout,
                              std::size_t place) {
    std::vector<Shared> all;
    for (std::size_t m = 0; m < models.size(); ++m)
        for (std::size_t k = 0; k < models[m].parameters.size(); ++k)
            if (const auto [shared, factor] = layout.shares[m][k]; shared == place)
                all.push_back({&models[m], &models[m].parameters[k], factor});
    return all;
}

void reconcile(const std::vector<Shared>& all) {
    if (all.size() < 2)
        return;
    const FreeParameter& owner = *all.front().parameter;
    double lower = owner.lower;
    double upper = owner.upper;
    for (const Shared& each : all) {
        lower = std::max(lower, each.parameter->lower / each.factor);
        upper = std::min(upper, each.parameter->upper / each.factor);
    }
    if (lower > upper)
        throw core::NumericalError(
            core::FailureKind::FitFailed,
            fmt::format("no value of {} suits all recordings", to_string(owner.access.id)));
    const double value = std::clamp(owner.access.get(all.front().model->spec), lower, upper);
    for (const Shared& each : all) {
        each.parameter->lower = each.factor * lower;
        each.parameter->upper = each.factor * upper;
        each.parameter->access.set(each.model->spec, each.factor * value);
    }
}

} // namespace

bool belongs_to_recording(const physics::ParameterId& parameter) {
    const physics::ParameterId id = parameter.in_one_model();
    return physics::is_of_release(id) ||
           physics::belongs_to(parameter.effect) == physics::BelongsTo::Recording;
}

JointLayout joint_layout(std::span<const StemModel> models,
                         std::span<const ObservedRecording> measurements) {
    const std::vector<std::string> names = unique_ids(measurements);
    JointLayout layout;
    for (std::size_t m = 0; m < models.size(); ++m) {
        std::vector<JointLayout::Share>& shares = layout.shares.emplace_back();
        for (const physics::ParameterId& id : models[m].free_ids()) {
            const bool has_own = models.size() > 1 && belongs_to_recording(id);
            const physics::ParameterId joint = has_own ? id.of_recording(names[m]) : id;
            const auto found = std::ranges::find(layout.ids, joint);
            const auto place = static_cast<std::size_t>(found - layout.ids.begin());
            if (found == layout.ids.end()) {
                layout.ids.push_back(joint);
                layout.owners.push_back({m, shares.size()});
            }
            const StemModel& owner = models[layout.owners[place].model];
            shares.push_back({place, factor_of(id, models[m], owner)});
        }
    }
    return layout;
}

std::vector<StemModel> reconciled(std::vector<StemModel> models, const JointLayout& layout) {
    for (std::size_t m = 0; m < models.size(); ++m)
        for (std::size_t k = models[m].first_error(); k < models[m].free_count(); ++k) {
            const auto [model, parameter] = layout.owners[layout.shares[m][k].place];
            models[m].set_value(k, models[model].value(parameter));
        }
    for (std::size_t place = 0; place < layout.owners.size(); ++place)
        reconcile(shared_by(models, layout, place));
    return models;
}

} // namespace culm::fit
