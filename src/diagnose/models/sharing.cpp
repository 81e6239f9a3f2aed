// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/models/sharing.hpp"

#include "fit/linear/layout.hpp"
#include "fit/linear/scaled_solve.hpp"

#include <algorithm>
#include <cstddef>

namespace culm::diagnose {

std::vector<std::string> Sharing::held() const {
    std::vector<std::string> effects;
    for (const auto& [effect, rig] : rig_of)
        effects.push_back(effect);
    return effects;
}

std::string shared_name(const std::string& effect, const std::string& parameter,
                        const std::string& rig) {
    return to_string(physics::ParameterId{effect, parameter, {}}) + " of rig " + rig;
}

SharedColumns shared_columns(const fit::Fit& fit,
                             std::span<const fit::ObservedRecording> recordings,
                             const Sharing& sharing) {
    SharedColumns out;
    out.system = fit.system;
    fit::WeightedSystem& system = out.system;
    const fit::JointLayout layout = fit::joint_layout(fit::start_from(fit), recordings);
    Eigen::Index constraint = system.readings();
    for (std::size_t k = 0; k < system.ids.size(); ++k) {
        const auto column = static_cast<Eigen::Index>(k);
        const physics::ParameterId& id = system.ids[k];
        const Eigen::Index row = system.errors[k] ? constraint++ : 0;
        const auto rig = id.is_of_effect() ? sharing.rig_of.find(id.effect) : sharing.rig_of.end();
        if (rig != sharing.rig_of.end()) {
            const auto [m, parameter] = layout.owners[k];
            const fit::StemModel& model = fit.parts[m].model;
            out.at.push_back(
                fit::to_coordinate(model.fitted_as(parameter), model.value(parameter)));
            out.names.push_back(shared_name(id.effect, id.name, rig->second));
            // A known value belongs to the shared number.
            for (Eigen::Index known = system.readings(); known < system.residual.size(); ++known)
                if (system.jacobian(known, column) != 0.0) {
                    system.jacobian(known, column) = 0.0;
                    system.residual(known) = 0.0;
                }
        } else if (system.errors[k] &&
                   std::ranges::find(sharing.terms, id.name) != sharing.terms.end()) {
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
        out.columns.push_back(column);
    }
    return out;
}

SharedBlock block_of(const SharedColumns& stem) {
    if (stem.names.empty())
        return {};
    SharedBlock block;
    block.names = stem.names;
    block.at = Eigen::VectorXd::Map(stem.at.data(), block.size());
    const Eigen::MatrixXd columns = stem.system.jacobian(Eigen::all, stem.columns);
    const fit::Projector own(stem.system.jacobian(Eigen::all, stem.own));
    const Eigen::MatrixXd coefficients = own.coefficients(columns);
    const Eigen::MatrixXd remainder = own.remainder(columns, coefficients);
    block.gradient = remainder.transpose() * stem.system.residual;
    block.information = remainder.transpose() * remainder;
    block.follow = Eigen::MatrixXd::Zero(stem.system.fitted, block.size());
    for (std::size_t k = 0; k < stem.own.size(); ++k)
        if (stem.own[k] < stem.system.fitted)
            block.follow.row(stem.own[k]) = -coefficients.row(static_cast<Eigen::Index>(k));
    for (Eigen::Index k = 0; k < block.size(); ++k)
        if (const Eigen::Index column = stem.columns[static_cast<std::size_t>(k)];
            column < stem.system.fitted)
            block.follow(column, k) = 1.0;
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
    out.stem_changes.assign(blocks.size(), 0.0);
    const auto count = static_cast<Eigen::Index>(out.names.size());
    if (count == 0)
        return out;
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
        out.hessian(place, place) += block.information / variances[s];
        right(place) +=
            (block.gradient + block.information * (block.at - mean(place))) / variances[s];
    }
    const Eigen::VectorXd change = fit::bounded_minimum(out.hessian, right, lower, upper);
    out.at = mean + change;
    for (std::size_t s = 0; s < blocks.size(); ++s) {
        const SharedBlock& block = blocks[s];
        const Eigen::VectorXd move = out.at(places[s]) - block.at;
        out.stem_changes[s] =
            (block.gradient.dot(move) - 0.5 * move.dot(block.information * move)) / variances[s];
    }
    return out;
}

} // namespace culm::diagnose
