// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/laboratory/shared_block.hpp"

#include "fit/linear/layout.hpp"
#include "fit/linear/scaled_solve.hpp"
#include "fit/solve/error_solution.hpp"

#include <algorithm>

namespace culm::diagnose {
namespace {

/// The models of the fit with the parameters of the rig's effects free.
fit::StartModels with_free_effects(const fit::Fit& fit, std::span<const RigEffect> effects) {
    fit::StartModels models = fit::start_from(fit);
    for (fit::StemModel& model : models)
        for (const RigEffect& each : effects)
            for (const std::size_t k : free_parameters(each.effect))
                model.parameters.push_back(
                    fit::effect_parameter(*each.effect.effect, model.spec.stem, k));
    return models;
}

const RigEffect* effect_of(const physics::ParameterId& id, std::span<const RigEffect> effects) {
    const auto found = std::ranges::find_if(effects, [&](const RigEffect& each) {
        return id.is_of_effect() && each.effect.effect->name() == id.effect;
    });
    return found == effects.end() ? nullptr : &*found;
}

} // namespace

std::vector<std::size_t> free_parameters(const physics::SelectedEffect& effect) {
    const std::vector<physics::EffectParameter> parameters = effect.effect->parameters();
    std::vector<std::size_t> free;
    for (std::size_t k = 0; k < parameters.size(); ++k)
        if (parameters[k].calibrated && !effect.fixed[k])
            free.push_back(k);
    return free;
}

std::string RigEffect::shared_name(const std::string& parameter) const {
    return to_string(physics::ParameterId{effect.effect->name(), parameter, {}}) + " of rig " + rig;
}

SharedReadings shared_readings(const fit::Fit& fit,
                               std::span<const fit::ObservedRecording> recordings,
                               std::span<const RigEffect> effects,
                               const std::vector<std::string>& shared_terms,
                               const run::Heartbeat& heartbeat) {
    const fit::StartModels models = with_free_effects(fit, effects);
    SharedReadings out;
    out.system = effects.empty() ? fit.system : fit::system_at(models, fit, recordings, heartbeat);
    const fit::JointLayout layout = fit::joint_layout(models, recordings);
    fit::WeightedSystem& system = out.system;
    Eigen::Index constraint = system.readings();
    for (std::size_t k = 0; k < system.ids.size(); ++k) {
        const auto column = static_cast<Eigen::Index>(k);
        const physics::ParameterId& id = system.ids[k];
        const Eigen::Index row = system.errors[k] ? constraint++ : 0;
        if (const RigEffect* const effect = effect_of(id, effects)) {
            const auto [m, parameter] = layout.owners[k];
            out.at.push_back(fit::to_coordinate(models[m].parameters[parameter].fitted_as,
                                                models[m].value(parameter)));
            out.names.push_back(effect->shared_name(id.name));
        } else if (system.errors[k] &&
                   std::ranges::find(shared_terms, id.name) != shared_terms.end()) {
            // About its value in the stem's solution, without its prior.
            out.at.push_back(std::ranges::find(fit.pulls, id.name, &fit::Pull::id)->value);
            system.residual -= out.at.back() * system.jacobian.col(column);
            system.jacobian(row, column) = 0.0;
            system.residual(row) = 0.0;
            out.names.push_back(id.name);
        } else {
            out.own.push_back(column);
            continue;
        }
        out.shared.push_back(column);
    }
    out.columns = system.jacobian(Eigen::all, out.shared);
    return out;
}

SharedBlock block_of(const SharedReadings& readings) {
    SharedBlock block{readings.names, readings.at, {}, {}, {}};
    const fit::Projector own(readings.system.jacobian(Eigen::all, readings.own));
    const Eigen::MatrixXd remainder = own.remainder(readings.columns);
    const Eigen::VectorXd gradient = remainder.transpose() * readings.system.residual;
    const Eigen::MatrixXd information = remainder.transpose() * remainder;
    const Eigen::MatrixXd coefficients = own.coefficients(readings.columns);
    // The fixed model has all columns but those of the rig's effects, in the same order.
    std::vector<Eigen::Index> places;
    Eigen::Index count = 0;
    for (Eigen::Index k = 0; k < readings.system.jacobian.cols(); ++k) {
        const auto shared = std::ranges::find(readings.shared, k);
        const bool is_own = shared == readings.shared.end();
        if (is_own)
            places.push_back(count);
        const bool is_effect =
            !is_own && readings.system.ids[static_cast<std::size_t>(k)].is_of_effect();
        count += is_effect ? 0 : 1;
    }
    Eigen::MatrixXd follow = Eigen::MatrixXd::Zero(count, block.size());
    for (std::size_t k = 0; k < places.size(); ++k)
        follow.row(places[k]) = -coefficients.row(static_cast<Eigen::Index>(k));
    block.gradient.assign(gradient.data(), gradient.data() + gradient.size());
    block.information.assign(information.data(), information.data() + information.size());
    block.follow.assign(follow.data(), follow.data() + follow.size());
    return block;
}

Eigen::Index SharedMinimum::find(const std::string& name) const {
    const auto found = std::ranges::find(names, name);
    return found == names.end() ? -1 : found - names.begin();
}

Eigen::MatrixXd SharedMinimum::covariance() const {
    return fit::ScaledSpectrum(hessian).inverse();
}

SharedMinimum minimum_of(std::span<const SharedBlock> blocks, std::span<const double> variances,
                         const std::map<std::string, SharedPrior>& priors) {
    SharedMinimum out;
    for (const SharedBlock& block : blocks)
        for (const std::string& name : block.names)
            if (out.find(name) < 0)
                out.names.push_back(name);
    std::ranges::sort(out.names);
    const auto count = static_cast<Eigen::Index>(out.names.size());
    out.hessian = Eigen::MatrixXd::Zero(count, count);
    Eigen::VectorXd right = Eigen::VectorXd::Zero(count); // about the priors' means
    Eigen::VectorXd mean(count);
    Eigen::VectorXd lower(count);
    Eigen::VectorXd upper(count);
    for (Eigen::Index k = 0; k < count; ++k) {
        const auto found = priors.find(out.names[static_cast<std::size_t>(k)]);
        const SharedPrior prior = found == priors.end() ? SharedPrior{} : found->second;
        mean(k) = prior.mean;
        out.hessian(k, k) = prior.precision;
        lower(k) = prior.lower - prior.mean;
        upper(k) = prior.upper - prior.mean;
    }
    std::vector<std::vector<Eigen::Index>> places;
    for (std::size_t s = 0; s < blocks.size(); ++s) {
        const SharedBlock& block = blocks[s];
        std::vector<Eigen::Index>& place = places.emplace_back();
        for (const std::string& name : block.names)
            place.push_back(out.find(name));
        const Eigen::Map<const Eigen::MatrixXd> information(block.information.data(), block.size(),
                                                            block.size());
        const Eigen::Map<const Eigen::VectorXd> at(block.at.data(), block.size());
        const Eigen::Map<const Eigen::VectorXd> gradient(block.gradient.data(), block.size());
        out.hessian(place, place) += information / variances[s];
        right(place) += (gradient + information * (at - mean(place))) / variances[s];
    }
    const Eigen::VectorXd change = fit::bounded_minimum(out.hessian, right, lower, upper);
    out.at = mean + change;
    for (std::size_t s = 0; s < blocks.size(); ++s) {
        const SharedBlock& block = blocks[s];
        const Eigen::Map<const Eigen::MatrixXd> information(block.information.data(), block.size(),
                                                            block.size());
        const Eigen::Map<const Eigen::VectorXd> gradient(block.gradient.data(), block.size());
        const Eigen::VectorXd move =
            out.at(places[s]) - Eigen::Map<const Eigen::VectorXd>(block.at.data(), block.size());
        out.stem_changes.push_back((gradient.dot(move) - 0.5 * move.dot(information * move)) /
                                   variances[s]);
    }
    return out;
}

} // namespace culm::diagnose
