// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/models/model_fits.hpp"

#include "fit/linear/scaled_solve.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include <fmt/core.h>

namespace culm::diagnose {
namespace {

constexpr int most_newton_steps = 12;
/// Squared Newton step, in standard deviations, below which the shared numbers have converged; the
/// fits of the stems end at the same share of a standard error.
constexpr double small_step = 0.1;
constexpr double far_step = 1.0; ///< likewise: the minimum is not known
/// A size ended absent within this part of its prior's deviation.
constexpr double absent_within = 1e-6;

/// Squared Newton step of the effects' parameters, in standard deviations.
double step_size(const Model& model) {
    double largest = 0.0;
    for (const auto& [effect, k, card, at] : shared_parameters(model)) {
        const double change = model.shared.at(at) -
                              fit::to_coordinate(card.fitted_as, model.effects[effect].values[k]);
        largest = std::max(largest, change * change * model.shared.hessian(at, at));
    }
    return largest;
}

} // namespace

std::vector<SharedParameter> shared_parameters(const Model& model) {
    std::vector<SharedParameter> out;
    for (std::size_t e = 0; e < model.effects.size(); ++e) {
        const ActingEffect& each = model.effects[e];
        const std::vector<physics::EffectParameter>& cards = each.effect.effect->parameters;
        for (std::size_t k = 0; k < cards.size() && each.is_shared(); ++k)
            if (const Eigen::Index at =
                    model.shared.find(shared_name(each.name(), cards[k].name, each.rig));
                at >= 0)
                out.push_back({e, k, cards[k], at});
    }
    return out;
}

// --- Fits

/// The way of one model to its fit.
class ModelFits::Descent {
  public:
    Descent(PlannedModel& planned, ModelFits& fits)
        : plan_(planned), fits_(fits), changes_(fits.stems_->size()) {
        Model& model = plan_.model;
        if (!can_be_combined(model.effects, *fits_.stems_))
            model.failure = "its effects cannot be combined in a stem";
        has_shared_ = std::ranges::any_of(model.effects, &ActingEffect::is_shared);
        is_done_ = model.failed();
        if (!is_done_ && next_stems().empty())
            take_step();
    }

    [[nodiscard]] bool is_done() const { return is_done_; }

    /// Stems to be fitted now.
    [[nodiscard]] std::vector<std::size_t> next_stems() const {
        if (!again_.empty())
            return again_;
        std::vector<std::size_t> stems;
        for (const std::size_t s : fits_.stems_->fitted())
            if ((is_first_ && plan_.starts.contains(s)) ||
                (has_shared_ && !plan_.model.effects_of(s, *fits_.stems_).sharing.rig_of.empty()))
                stems.push_back(s);
        return stems;
    }

    /// On any rank.
    [[nodiscard]] StemFit fit_of(std::size_t s, const fit::FitOptions& options) const {
        const auto start = plan_.starts.find(s);
        if (!is_first_ || start == plan_.starts.end())
            return fit_at_shared(*fits_.stems_, s, plan_.model, changes_[s], {}, options);
        if (start->second.smaller == nullptr)
            return fit_at_shared(*fits_.stems_, s, plan_.model, {}, start->second, options);
        return fit_stem(*fits_.stems_, s, plan_.model.effects_of(s, *fits_.stems_), start->second,
                        options);
    }

    void take_fit(std::size_t s, StemFit found) {
        Model& model = plan_.model;
        found.fit.effects = model.effects_of(s, *fits_.stems_).all;
        const auto start = plan_.starts.find(s);
        if (is_first_ && start != plan_.starts.end() && !fits_.stems_->is_one() &&
            start->second.smaller != nullptr &&
            (found.fit.failed() || !found.evidence.absent_effects.empty()) &&
            remove_absent(s, found, start->second.smaller))
            return; // the fit without the effect stays
        if (found.fit.failed() && model.failure.empty())
            model.failure =
                fits_.stems_->is_one()
                    ? found.fit.reason
                    : fmt::format("{}: {}", fits_.stems_->specimen(s).name, found.fit.reason);
        model.stems[s] = std::move(found);
    }

    /// After all stems of a step were fitted.
    void take_step() {
        Model& model = plan_.model;
        const bool was_first = std::exchange(is_first_, false);
        again_.clear();
        is_done_ = model.failed();
        for (const ActingEffect& each : model.effects)
            if (each.stems.empty() && !each.is_known && !is_done_) {
                model.failure = each.name() + " is absent from every stem";
                is_done_ = true;
            }
        if (is_done_ || (was_first && leaves_absent()))
            return;
        fits_.judge(model);
        is_done_ = !has_shared_;
        if (has_shared_)
            move_shared();
        is_done_ = is_done_ && (model.failed() || !leaves_absent());
    }

  private:
    /// Beside new effects, others may end absent from a stem: it is fitted again without them.
    bool leaves_absent() {
        for (const std::size_t s : fits_.stems_->fitted())
            if (!fits_.stems_->is_one() && remove_absent(s, plan_.model.stems[s], nullptr)) {
                again_.push_back(s);
                changes_[s] = {};
            }
        best_.reset();
        steps_ = 0;
        return !again_.empty();
    }

    /// Removes from a stem those own effects that its fit does not need, unless `smaller` has them;
    /// false if there are none.
    bool remove_absent(std::size_t s, const StemFit& found, const fit::Fit* smaller) {
        const std::vector<std::string>& absent = found.evidence.absent_effects;
        bool is_removed = false;
        for (ActingEffect& each : plan_.model.effects)
            if (!each.is_shared() &&
                (smaller == nullptr || !fit::contains(smaller->effects, each.effect)) &&
                (found.fit.failed() || std::ranges::find(absent, each.name()) != absent.end()))
                is_removed = std::erase(each.stems, s) > 0 || is_removed;
        return is_removed;
    }

    void move_shared() {
        Model& model = plan_.model;
        const double now = fits_.value_of(model);
        const bool is_better = !best_ || now >= reached_;
        part_ = is_better ? 1.0 : 0.5 * part_; // the quadratic form is not valid so far away
        if (is_better) {
            best_ = model;
            reached_ = now;
        } else
            model = *best_;
        if (step_size(model) < small_step) {
            is_done_ = true;
        } else if (++steps_ == most_newton_steps) {
            is_done_ = true;
            model = *std::move(best_);
            if (step_size(model) > far_step)
                model.failure = fmt::format("the shared numbers do not converge in {} steps",
                                            most_newton_steps);
        } else
            move_by(part_);
    }

    /// Moves the effects' values by a part of the way to the minimum; the stems' own numbers
    /// follow.
    void move_by(double part) {
        Model& model = plan_.model;
        for (std::size_t s = 0; s < changes_.size(); ++s) {
            const SharedBlock& block = model.stems[s].block;
            Eigen::VectorXd move = Eigen::VectorXd::Zero(block.size());
            for (Eigen::Index k = 0; k < block.size(); ++k) {
                const auto place = static_cast<std::size_t>(k);
                if (fits_.priors_.contains(block.names[place])) // not an error term
                    move(k) = part * (model.shared.at(model.shared.find(block.names[place])) -
                                      block.at(k));
            }
            changes_[s] = block.follow * move;
        }
        for (const auto& [effect, k, card, at] : shared_parameters(model)) {
            double& now = model.effects[effect].values[k];
            const double from = fit::to_coordinate(card.fitted_as, now);
            const double value =
                fit::from_coordinate(card.fitted_as, from + part * (model.shared.at(at) - from));
            now = std::isfinite(value) ? value : card.upper; // a stiffness without compliance
        }
    }

    PlannedModel& plan_;
    ModelFits& fits_;
    std::vector<Eigen::VectorXd> changes_; ///< (stems) of their numbers
    std::vector<std::size_t> again_;       ///< stems that have lost an effect
    std::optional<Model> best_;
    double reached_ = 0.0;
    double part_ = 1.0; ///< of a Newton step
    int steps_ = 0;
    bool has_shared_ = false;
    bool is_first_ = true;
    bool is_done_ = false;
};

void ModelFits::fit(std::vector<PlannedModel>& planned) {
    std::vector<Descent> descents;
    descents.reserve(planned.size());
    for (PlannedModel& each : planned)
        descents.emplace_back(each, *this);
    for (;;) {
        std::vector<std::pair<std::size_t, std::size_t>> items; // model, stem
        std::vector<std::size_t> of;
        std::vector<double> efforts;
        for (std::size_t m = 0; m < descents.size(); ++m)
            if (!descents[m].is_done())
                for (const std::size_t s : descents[m].next_stems()) {
                    items.emplace_back(m, s);
                    of.push_back(s);
                    efforts.push_back(
                        fit::relative_cost(planned[m].model.effects_of(s, *stems_).all));
                }
        if (items.empty())
            return;
        std::vector<StemFit> found = stems_->map(
            of,
            [&](std::size_t item, const fit::FitOptions& options) {
                return descents[items[item].first].fit_of(items[item].second, options);
            },
            efforts);
        for (std::size_t k = 0; k < items.size(); ++k)
            descents[items[k].first].take_fit(items[k].second, std::move(found[k]));
        for (Descent& each : descents)
            if (!each.is_done())
                each.take_step();
    }
}

// --- Log evidence

SharedMinimum ModelFits::minimum_in(const Model& model,
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
double ModelFits::value_of(const Model& model) const {
    std::map<std::string, SharedPrior> held = priors_;
    for (const auto& [effect, k, card, at] : shared_parameters(model)) {
        SharedPrior& prior = held.at(model.shared.names[static_cast<std::size_t>(at)]);
        prior.lower = prior.upper =
            fit::to_coordinate(card.fitted_as, model.effects[effect].values[k]);
    }
    return log_likelihood(model, minimum_in(model, held));
}

void ModelFits::judge(Model& model) {
    add_priors(model);
    model.shared = minimum_in(model, priors_);
    model.log_evidence = model.failed() || has_absent_effect(model)
                             ? -std::numeric_limits<double>::infinity()
                             : log_likelihood(model, model.shared) + log_prior_of_effects(model) +
                                   log_volume(model) + model.offset;
}

/// With the terms of the stems' own numbers.
double ModelFits::log_likelihood(const Model& model, const SharedMinimum& shared) const {
    double sum = 0.0;
    for (const std::size_t s : stems_->fitted()) {
        const StemFit& stem = model.stems[s];
        sum += log_evidence(stem.evidence, noise_[s]) + shared.stem_changes[s];
        for (std::size_t k = 0; k < stem.block.names.size(); ++k)
            if (!priors_.contains(stem.block.names[k])) // the prior of an error term
                sum += 0.5 * stem.block.at[k] * stem.block.at[k];
    }
    for (std::size_t k = 0; k < shared.names.size(); ++k)
        if (const double at = shared.at(static_cast<Eigen::Index>(k));
            !priors_.contains(shared.names[k]))
            sum -= 0.5 * at * at;
    return sum;
}

/// That the effects act, and in which stems; the evidence of a stem has the odds of its effects.
double ModelFits::log_prior_of_effects(const Model& model) const {
    double sum = 0.0;
    for (const ActingEffect& each : model.effects) {
        if (each.is_known)
            continue;
        if (each.is_shared())
            sum += log_prior_odds();
        else
            sum += (1.0 - static_cast<double>(each.stems.size())) * log_prior_odds() +
                   log_presence(each.stems.size(), stems_->fitted().size());
    }
    return sum;
}

/// Prior density of the shared parameters and the volume of their posterior.
double ModelFits::log_volume(const Model& model) const {
    std::vector<Eigen::Index> places;
    double sum = 0.0;
    Eigen::MatrixXd hessian = model.shared.hessian;
    for (const SharedParameter& each : shared_parameters(model)) {
        if (model.effects[each.effect].is_known)
            continue;
        const ParameterPrior& prior =
            parameter_priors_.at(model.shared.names[static_cast<std::size_t>(each.at)]);
        places.push_back(each.at);
        hessian(each.at, each.at) += prior.precision();
        sum += prior.log_density(model.shared.at(each.at)) + 0.5 * std::log(2.0 * std::numbers::pi);
    }
    if (places.empty())
        return sum;
    const Eigen::MatrixXd covariance = fit::ScaledSpectrum(hessian).inverse()(places, places);
    return sum + 0.5 * fit::ScaledSpectrum(covariance).log_determinant();
}

/// Did all sizes of an effect end where the effect is absent?
bool ModelFits::has_absent_effect(const Model& model) const {
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
void ModelFits::add_priors(const Model& model) {
    for (const ActingEffect& each : model.effects) {
        if (!each.is_shared())
            continue;
        const std::vector<physics::EffectParameter>& cards = each.effect.effect->parameters;
        for (const std::size_t k : free_parameters(each.effect))
            if (const std::string name = shared_name(each.name(), cards[k].name, each.rig);
                !priors_.contains(name))
                add_prior(each, k, name);
    }
}

void ModelFits::add_prior(const ActingEffect& effect, std::size_t k, const std::string& name) {
    ParameterPrior mean;
    SharedPrior prior;
    prior.precision = 0.0; // a fit has no priors of sizes
    double deviation = 0.0;
    for (const std::size_t s : effect.stems) {
        const fit::StemModel model = stem_with(effect, s, *stems_);
        const fit::FreeParameter parameter =
            fit::effect_parameter(*effect.effect.effect, model.spec.stem, k);
        const auto [lower, upper] =
            std::minmax({fit::to_coordinate(parameter.fitted_as, parameter.lower),
                         fit::to_coordinate(parameter.fitted_as, parameter.upper)});
        prior.lower = std::max(prior.lower, lower);
        prior.upper = std::min(prior.upper, upper);
        mean = prior_of(parameter, model);
        deviation += mean.deviation;
    }
    mean.deviation = deviation / static_cast<double>(effect.stems.size());
    prior.mean = mean.is_place ? 0.5 * (prior.lower + prior.upper) : mean.absent;
    if (mean.known_within > 0.0) {
        prior.mean = mean.known;
        prior.precision = 1.0 / (mean.known_within * mean.known_within);
    }
    if (mean.is_one_sided && !mean.is_place) // absent is a bound, also of an inverse
        (mean.deviation > 0.0 ? prior.lower : prior.upper) = mean.absent;
    parameter_priors_[name] = mean;
    priors_[name] = prior;
}

} // namespace culm::diagnose
