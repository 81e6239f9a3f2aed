// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/laboratory/laboratory_fit.hpp"

#include "diagnose/planned_model.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include <Eigen/Cholesky>
#include <fmt/core.h>
#include <fmt/ranges.h>

namespace culm::diagnose {
namespace {

constexpr int most_newton_steps = 12;
/// Squared Newton step, in standard deviations, below which the shared numbers have converged.
constexpr double small_step = 0.01;
constexpr double far_step = 1.0; ///< likewise: the minimum is not known
/// A size ended absent within this part of its prior's deviation.
constexpr double absent_within = 1e-6;

/// The prior of a shared number that suits one stem, and the number's bounds; coordinates.
struct StemPrior {
    ParameterPrior prior;
    double lower = 0.0;
    double upper = 0.0;
};

template <class Wire>
void fields(Wire& wire, StemPrior& stem) {
    wire(stem.prior, stem.lower, stem.upper);
}

} // namespace

std::vector<SharedParameter> shared_parameters(const LaboratoryModel& model) {
    std::vector<SharedParameter> out;
    for (std::size_t e = 0; e < model.rig_effects.size(); ++e) {
        const RigEffect& each = model.rig_effects[e];
        const std::vector<physics::EffectParameter> parameters = each.effect.effect->parameters();
        for (std::size_t k = 0; k < parameters.size(); ++k)
            if (const Eigen::Index at = model.shared.find(each.shared_name(parameters[k].name));
                at >= 0)
                out.push_back({e, k, parameters[k], at});
    }
    return out;
}

EffectOwners owners_of(const LaboratoryModel& model) {
    EffectOwners owners;
    for (const RigEffect& each : model.rig_effects)
        owners.emplace(each.effect.effect->name(), each.rig);
    for (const fit::SelectedEffects& own : model.own)
        for (const physics::SelectedEffect& each : own)
            owners.emplace(each.effect->name(), "");
    return owners;
}

std::string name_of(const EffectOwners& owners) {
    std::vector<std::string> names;
    for (const auto& [effect, rig] : owners)
        names.push_back(fmt::format("{} of {}", effect, rig.empty() ? "stems" : "rig " + rig));
    return names.empty() ? "the published chain" : fmt::format("{}", fmt::join(names, " + "));
}

LaboratoryStems::LaboratoryStems(std::span<const Specimen> all, const DiagnosisOptions& chosen)
    : specimens(all), options(chosen) {
    for (const physics::SelectedEffect& each : options.known)
        (each.effect->belongs_to() == physics::BelongsTo::Rig ? known_of_rig : known_of_stem)
            .push_back(each);
}

std::set<std::string> LaboratoryStems::rigs() const {
    std::set<std::string> rigs;
    for (const Specimen& specimen : specimens)
        if (!specimen.rig.empty())
            rigs.insert(specimen.rig);
    return rigs;
}

std::size_t LaboratoryStems::fitted_stems() const {
    return static_cast<std::size_t>(std::ranges::count_if(
        stems, [](const ObservedStem& stem) { return stem.failure.empty(); }));
}

double LaboratoryStems::cost_of(std::size_t stem) const {
    double seconds = 0.0;
    for (const measure::Measurement& recording : specimens[stem].recordings)
        seconds += recording.times.back();
    return seconds;
}

StemEffects LaboratoryStems::effects_of(const LaboratoryModel& model, std::size_t stem) const {
    StemEffects effects{{}, known_of_stem, model.own[stem], shared_terms};
    for (const RigEffect& each : model.rig_effects)
        if (each.rig == specimens[stem].rig)
            effects.rig.push_back(each);
    return effects;
}

RigEffect LaboratoryStems::with_default_values(const physics::SelectedEffect& effect,
                                               const std::string& rig, bool is_known) const {
    const auto on_rig = std::ranges::find(specimens, rig, &Specimen::rig);
    const fit::StemChain chain = fit::chain_of(on_rig->recordings.front(), options.candidate.chain);
    return {effect, rig, physics::with_defaults(effect, chain.spec.stem).values, is_known};
}

void LaboratoryFit::fit(LaboratoryModel& model, const std::set<std::size_t>& with_new_own) {
    for (std::size_t s = 0; s < stems_.specimens.size(); ++s)
        if (!can_be_combined(stems_.effects_of(model, s).all())) {
            model.failure = "its effects cannot be combined in " + stems_.specimens[s].name;
            return;
        }
    std::vector<Eigen::VectorXd> changes(stems_.stems.size());
    std::optional<LaboratoryModel> best;
    double reached = 0.0;
    double part = 1.0; // of a Newton step
    for (int step = 0; step < most_newton_steps; ++step) {
        const bool is_first = step == 0;
        auto fits = stems_.map([&](std::size_t s, const fit::FitOptions& options) {
            const StemEffects effects = stems_.effects_of(model, s);
            if (is_first && with_new_own.contains(s))
                return fit_stem_from_starts(stems_.stems[s], effects, model.stems[s].fit, options);
            return fit_stem(stems_.stems[s], effects, model.stems[s].fit, changes[s], options);
        });
        for (std::size_t s = 0; s < fits.size(); ++s)
            if (!stems_.is_left_out(s) &&
                !take_fit(*std::move(fits[s]), s, is_first && with_new_own.contains(s), model))
                return;
        judge(model);
        if (model.rig_effects.empty())
            return;
        const double now = value_of(model);
        const bool is_better = !best || now >= reached;
        part = is_better ? 1.0 : 0.5 * part; // the quadratic model is not valid so far away
        if (is_better) {
            best = model;
            reached = now;
        } else
            model = *best;
        if (step_size(model) < small_step)
            return;
        changes = take_step(model, part);
    }
    model = *std::move(best);
    if (step_size(model) > far_step)
        model.failure =
            fmt::format("the shared numbers do not converge in {} steps", most_newton_steps);
}

/// Stores the fit of a stem; false if the model has failed.
bool LaboratoryFit::take_fit(StemFit found, std::size_t stem, bool has_new_own,
                             LaboratoryModel& model) const {
    StemFit& mine = model.stems[stem];
    if (has_new_own && (found.fit.failed() || !found.evidence.absent_effects.empty())) {
        model.own[stem].pop_back();
        mine.fit.effects = stems_.effects_of(model, stem).all();
        return true;
    }
    mine = std::move(found);
    mine.fit.effects = stems_.effects_of(model, stem).all();
    if (mine.fit.failed())
        model.failure = fmt::format("{}: {}", stems_.specimens[stem].name, mine.fit.reason);
    return !model.failed();
}

/// Squared Newton step of the effects' parameters, in standard deviations.
double LaboratoryFit::step_size(const LaboratoryModel& model) const {
    double largest = 0.0;
    for (const auto& [effect, k, card, at] : shared_parameters(model)) {
        const double change =
            model.shared.at(at) -
            fit::to_coordinate(card.fitted_as, model.rig_effects[effect].values[k]);
        largest = std::max(largest, change * change * model.shared.hessian(at, at));
    }
    return largest;
}

/// Moves the effects' values by a part of the way to the minimum; returns how the stems' own
/// numbers follow.
std::vector<Eigen::VectorXd> LaboratoryFit::take_step(LaboratoryModel& model, double part) const {
    std::vector<Eigen::VectorXd> changes(stems_.stems.size());
    for (std::size_t s = 0; s < changes.size(); ++s) {
        const SharedBlock& block = model.stems[s].block;
        if (block.names.empty())
            continue;
        Eigen::VectorXd move = Eigen::VectorXd::Zero(block.size());
        for (Eigen::Index k = 0; k < block.size(); ++k) {
            if (const std::string& name = block.names[static_cast<std::size_t>(k)];
                priors_.contains(name)) // not an error term
                move(k) = part * (model.shared.at(model.shared.find(name)) -
                                  block.at[static_cast<std::size_t>(k)]);
        }
        const auto rows =
            static_cast<Eigen::Index>(block.follow.size()) / std::max<Eigen::Index>(1, move.size());
        changes[s] =
            Eigen::Map<const Eigen::MatrixXd>(block.follow.data(), rows, move.size()) * move;
    }
    for (const auto& [effect, k, card, at] : shared_parameters(model)) {
        double& now = model.rig_effects[effect].values[k];
        const double from = fit::to_coordinate(card.fitted_as, now);
        const double value =
            fit::from_coordinate(card.fitted_as, from + part * (model.shared.at(at) - from));
        now = std::isfinite(value) ? value : card.upper; // a stiffness without compliance
    }
    return changes;
}

SharedMinimum LaboratoryFit::minimum_in(const LaboratoryModel& model,
                                        const std::map<std::string, SharedPrior>& priors) const {
    std::vector<SharedBlock> blocks;
    std::vector<double> variances;
    for (std::size_t s = 0; s < model.stems.size(); ++s) {
        blocks.push_back(model.stems[s].block);
        variances.push_back(noise_[s].mean_known());
    }
    return minimum_of(blocks, variances, priors);
}

/// The likelihood where the effects' parameters are, without the prediction of a better place.
double LaboratoryFit::value_of(LaboratoryModel model) const {
    std::map<std::string, SharedPrior> held = priors_;
    for (const auto& [effect, k, card, at] : shared_parameters(model)) {
        SharedPrior& prior = held.at(model.shared.names[static_cast<std::size_t>(at)]);
        prior.lower = prior.upper =
            fit::to_coordinate(card.fitted_as, model.rig_effects[effect].values[k]);
    }
    model.shared = minimum_in(model, held);
    return log_likelihood(model);
}

void LaboratoryFit::judge(LaboratoryModel& model) {
    add_priors(model);
    model.shared = minimum_in(model, priors_);
    model.log_evidence =
        has_absent_effect(model)
            ? -std::numeric_limits<double>::infinity()
            : log_likelihood(model) + log_prior_of_effects(model) + log_volume(model);
}

/// With the terms of the stems' own numbers.
double LaboratoryFit::log_likelihood(const LaboratoryModel& model) const {
    double sum = 0.0;
    for (std::size_t s = 0; s < model.stems.size(); ++s) {
        if (stems_.is_left_out(s))
            continue;
        const StemFit& stem = model.stems[s];
        sum += log_evidence(stem.evidence, noise_[s]) -
               static_cast<double>(stem.evidence.effects) * log_prior_odds() +
               model.shared.stem_changes[s];
        for (std::size_t k = 0; k < stem.block.names.size(); ++k)
            if (!priors_.contains(stem.block.names[k])) // the prior of an error term
                sum += 0.5 * stem.block.at[k] * stem.block.at[k];
    }
    for (std::size_t k = 0; k < model.shared.names.size(); ++k)
        if (const double at = model.shared.at(static_cast<Eigen::Index>(k));
            !priors_.contains(model.shared.names[k]))
            sum -= 0.5 * at * at;
    return sum;
}

/// That the effects act, and in which stems.
double LaboratoryFit::log_prior_of_effects(const LaboratoryModel& model) const {
    double sum = 0.0;
    std::map<std::string, std::size_t> present;
    for (const fit::SelectedEffects& own : model.own)
        for (const physics::SelectedEffect& each : own)
            ++present[each.effect->name()];
    for (const auto& [name, count] : present)
        sum += log_prior_odds() + log_presence(count, stems_.fitted_stems());
    for (const RigEffect& each : model.rig_effects)
        sum += each.is_known ? 0.0 : log_prior_odds();
    return sum;
}

/// Prior density of the effects' parameters and the volume of their posterior.
double LaboratoryFit::log_volume(const LaboratoryModel& model) const {
    std::vector<Eigen::Index> places;
    double sum = 0.0;
    for (const SharedParameter& each : shared_parameters(model)) {
        if (model.rig_effects[each.effect].is_known)
            continue;
        places.push_back(each.at);
        sum += parameter_priors_.at(model.shared.names[static_cast<std::size_t>(each.at)])
                   .log_density(model.shared.at(each.at));
    }
    if (places.empty())
        return sum;
    const Eigen::VectorXd scale = model.shared.hessian.diagonal().cwiseSqrt().cwiseInverse();
    const Eigen::MatrixXd all = scale.cwiseInverse().asDiagonal() * model.shared.covariance() *
                                scale.cwiseInverse().asDiagonal();
    const Eigen::MatrixXd covariance = all(places, places);
    const Eigen::LDLT<Eigen::MatrixXd> factors(covariance);
    for (Eigen::Index k = 0; k < covariance.rows(); ++k)
        sum += 0.5 * std::log(std::max(factors.vectorD()(k), 1e-12)) +
               std::log(scale(places[static_cast<std::size_t>(k)])) +
               0.5 * std::log(2.0 * std::numbers::pi);
    return sum;
}

/// Did all sizes of an effect end where the effect is absent?
bool LaboratoryFit::has_absent_effect(const LaboratoryModel& model) const {
    if (std::ranges::any_of(
            model.stems, [](const StemFit& stem) { return !stem.evidence.absent_effects.empty(); }))
        return true;
    std::map<std::size_t, bool> is_there; // (effects)
    for (const SharedParameter& each : shared_parameters(model)) {
        const ParameterPrior& prior =
            parameter_priors_.at(model.shared.names[static_cast<std::size_t>(each.at)]);
        if (!prior.is_place)
            is_there[each.effect] |= std::abs(model.shared.at(each.at) - prior.absent) >
                                     absent_within * std::abs(prior.deviation);
    }
    return std::ranges::any_of(is_there, [](const auto& entry) { return !entry.second; });
}

/// The common prior of the parameters of the model's effects: the mean of the stems' priors, whose
/// usual sizes suit each stem; the bounds are those that suit all stems.
void LaboratoryFit::add_priors(const LaboratoryModel& model) {
    for (const RigEffect& each : model.rig_effects) {
        const std::vector<physics::EffectParameter> parameters = each.effect.effect->parameters();
        for (const std::size_t k : free_parameters(each.effect))
            if (const std::string name = each.shared_name(parameters[k].name);
                !priors_.contains(name))
                add_prior(each, k, name);
    }
}

void LaboratoryFit::add_prior(const RigEffect& effect, std::size_t k, const std::string& name) {
    const auto found = stems_.map([&](std::size_t s, const fit::FitOptions& options) {
        const ObservedStem& stem = stems_.stems[s];
        const fit::StemModel model =
            candidate_model(fit::models_of(stem.chain, stem.recordings, options).front(),
                            {effect.effect}, stem.recordings.front());
        const fit::FreeParameter parameter =
            fit::effect_parameter(*effect.effect.effect, model.spec.stem, k);
        const auto [lower, upper] =
            std::minmax({fit::to_coordinate(parameter.fitted_as, parameter.lower),
                         fit::to_coordinate(parameter.fitted_as, parameter.upper)});
        return StemPrior{prior_of(parameter, model), lower, upper};
    });
    ParameterPrior mean;
    SharedPrior prior;
    double count = 0.0;
    double deviation = 0.0;
    for (std::size_t s = 0; s < found.size(); ++s) {
        if (!found[s] || stems_.specimens[s].rig != effect.rig)
            continue;
        mean = found[s]->prior;
        deviation += mean.deviation;
        count += 1.0;
        prior.lower = std::max(prior.lower, found[s]->lower);
        prior.upper = std::min(prior.upper, found[s]->upper);
    }
    mean.deviation = deviation / count;
    prior.mean = mean.is_place ? 0.5 * (prior.lower + prior.upper) : mean.absent;
    prior.precision = mean.precision();
    if (mean.is_one_sided && !mean.is_place) // absent is a bound, also of an inverse
        (mean.deviation > 0.0 ? prior.lower : prior.upper) = mean.absent;
    parameter_priors_[name] = mean;
    priors_[name] = prior;
}

double log_presence(std::size_t with_effect, std::size_t stems) {
    const auto m = static_cast<double>(with_effect);
    const auto n = static_cast<double>(stems);
    return std::lgamma(m + 1.0) + std::lgamma(n - m + 1.0) - std::lgamma(n + 2.0);
}

} // namespace culm::diagnose
