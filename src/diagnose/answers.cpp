// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/answers.hpp"

#include "core/order_statistics.hpp"
#include "reduce/distributions.hpp"
#include "reduce/population_statistics.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

namespace culm::diagnose {
namespace {

/// An effect that is less probable is not listed.
constexpr double least_probability = 0.05;

StemNumbers numbers_of(const fit::Fit& fit) {
    StemNumbers out;
    out.rmse = fit.rmse;
    out.over_noise =
        std::sqrt(fit.chi_squared / static_cast<double>(std::max<std::size_t>(fit.readings, 1)));
    for (const fit::FittedParameter& each : fit.parameters)
        if (each.id == physics::bond_youngs_modulus) {
            out.youngs_modulus = each.value;
            out.youngs_modulus_error = each.standard_error;
        } else if (each.id == physics::bond_damping) {
            out.damping = each.value;
            out.damping_error = each.standard_error;
        }
    return out;
}

/// Adds the uncertainty of the shared numbers, which the stem's own numbers follow.
void add_shared_uncertainty(const StemFit& stem, const SearchResult& search, const Model& model,
                            const Eigen::MatrixXd& covariance, StemNumbers& numbers) {
    const SharedBlock& block = stem.block;
    std::vector<Eigen::Index> effects; // the error terms are in the budget already
    std::vector<Eigen::Index> places;
    for (Eigen::Index k = 0; k < block.size(); ++k) {
        const std::string& name = block.names[static_cast<std::size_t>(k)];
        if (search.fits.priors().contains(name)) {
            effects.push_back(k);
            places.push_back(model.shared.find(name));
        }
    }
    if (effects.empty())
        return;
    const Eigen::MatrixXd own = covariance(places, places);
    for (std::size_t k = 0; k < stem.fit.parameters.size(); ++k) {
        const Eigen::VectorXd by =
            block.follow.row(static_cast<Eigen::Index>(k))(effects).transpose();
        const double added = std::sqrt(by.dot(own * by));
        const physics::ParameterId& id = stem.fit.parameters[k].id;
        if (id == physics::bond_youngs_modulus)
            numbers.youngs_modulus_error_by_shared = added;
        if (id == physics::bond_damping)
            numbers.damping_error_by_shared = added;
    }
    numbers.youngs_modulus_error =
        std::hypot(numbers.youngs_modulus_error, numbers.youngs_modulus_error_by_shared);
    numbers.damping_error = std::hypot(numbers.damping_error, numbers.damping_error_by_shared);
}

/// Distances of ln value from the median, in robust standard deviations.
void add_distances(std::vector<StemAnswer>& stems, double StemNumbers::*number,
                   double StemAnswer::*distance) {
    std::vector<double> logarithms;
    for (const StemAnswer& stem : stems)
        if (stem.failure.empty())
            logarithms.push_back(std::log(stem.after.*number));
    const double middle = core::median(logarithms);
    const double scale = core::robust_deviation(logarithms);
    for (StemAnswer& stem : stems)
        if (stem.failure.empty() && scale > 0.0)
            stem.*distance = (std::log(stem.after.*number) - middle) / scale;
}

class Effects {
  public:
    Effects(const SearchResult& search, const Posterior& posterior, std::size_t answer)
        : search_(search), posterior_(posterior), answer_(search.visited[answer]) {}

    [[nodiscard]] std::vector<EffectAnswer> list() {
        for (const ActingEffect& each : answer_.effects) {
            EffectAnswer& added = add(owned(each));
            added.is_known = each.is_known;
            added.values = values_of(each);
            if (!each.is_shared() && !each.is_known)
                add_stems(each, added);
        }
        std::map<OwnedEffect, double> probability;
        for (const Explanation& each : posterior_.explanations)
            for (const OwnedEffect& name : each.effects)
                probability[name] += each.probability;
        for (const auto& [name, value] : probability)
            if (value > least_probability &&
                std::ranges::find(answer_.effects, name, owned) == answer_.effects.end())
                add(name);
        return std::move(out_);
    }

  private:
    EffectAnswer& add(const OwnedEffect& name) {
        const physics::Family family = family_of(search_.stems->options(), name.first);
        EffectAnswer& added = out_.emplace_back();
        added.effect = name.first;
        added.rig = name.second;
        added.family = to_string(family);
        for (const Explanation& each : posterior_.explanations) {
            const bool has = std::ranges::find(each.effects, name) != each.effects.end();
            const bool has_family =
                std::ranges::any_of(each.effects, [&](const OwnedEffect& other) {
                    return other.second == name.second &&
                           family_of(search_.stems->options(), other.first) == family;
                });
            added.probability += has ? each.probability : 0.0;
            added.family_probability += has || has_family ? each.probability : 0.0;
        }
        if (!search_.stems->is_one())
            add_power(name, added);
        return added;
    }

    /// The log odds grow with the number of stems, as far as they come from the readings.
    void add_power(const OwnedEffect& name, EffectAnswer& added) const {
        std::optional<std::size_t> with;
        std::optional<std::size_t> without;
        for (std::size_t k = 0; k < search_.visited.size(); ++k) {
            if (!std::isfinite(search_.about_best[k]))
                continue;
            const std::vector<ActingEffect>& effects = search_.visited[k].effects;
            std::optional<std::size_t>& best =
                std::ranges::find(effects, name, owned) != effects.end() ? with : without;
            if (!best || search_.about_best[k] > search_.about_best[*best])
                best = k;
        }
        if (!with || !without)
            return;
        double of_readings = 0.0;
        const std::vector<std::size_t> stems =
            name.second.empty() ? search_.stems->fitted() : search_.stems->on_rig(name.second);
        for (const std::size_t s : stems)
            of_readings +=
                log_evidence(search_.visited[*with].stems[s].evidence, search_.fits.noise()[s]) -
                log_evidence(search_.visited[*without].stems[s].evidence, search_.fits.noise()[s]);
        const double held = search_.stems->options().policy.held_probability;
        const double wanted = std::log(held / (1.0 - held));
        added.log_odds = search_.about_best[*with] - search_.about_best[*without];
        added.log_odds_per_stem = of_readings / static_cast<double>(stems.size());
        if (added.log_odds < wanted && added.log_odds_per_stem > 0.0)
            added.stems_needed = std::ceil((wanted - added.log_odds) / added.log_odds_per_stem);
    }

    [[nodiscard]] std::vector<SharedValue> values_of(const ActingEffect& effect) const {
        std::vector<SharedValue> values;
        if (!effect.is_shared())
            return values;
        const Eigen::MatrixXd covariance = answer_.shared.covariance();
        for (const physics::EffectParameter& each : effect.effect.effect->parameters) {
            const std::string name = shared_name(effect.name(), each.name, effect.rig);
            const Eigen::Index at = answer_.shared.find(name);
            if (at < 0)
                continue;
            const double middle = answer_.shared.at(at);
            const double half = reduce::normal_quantile_95 * std::sqrt(covariance(at, at));
            const SharedPrior& prior = search_.fits.priors().at(name);
            const double one =
                fit::from_coordinate(each.fitted_as, std::max(middle - half, prior.lower));
            const double other =
                fit::from_coordinate(each.fitted_as, std::min(middle + half, prior.upper));
            values.push_back({each.name, each.unit, fit::from_coordinate(each.fitted_as, middle),
                              std::min(one, other), std::max(one, other)});
        }
        return values;
    }

    /// Stems that have an own effect, from the fits with and without it and from predictions.
    void add_stems(const ActingEffect& effect, EffectAnswer& added) const {
        const Stems& stems = *search_.stems;
        const auto place = std::ranges::find(answer_.effects, owned(effect), owned);
        const Model* const smaller =
            find_model(search_.visited,
                       without(answer_.effects, std::size_t(place - answer_.effects.begin())));
        const std::vector<std::size_t> fitted = stems.fitted();
        std::vector<double> gains;
        gains.reserve(fitted.size());
        for (const std::size_t s : fitted)
            gains.push_back(gain_in(s, effect, smaller));
        const std::vector<double> presence = presence_of(gains);
        for (std::size_t k = 0; k < fitted.size(); ++k) {
            const std::string& name = stems.specimen(fitted[k]).name;
            if (presence[k] >= stems.options().policy.held_probability)
                added.stems.push_back(name);
            else if (presence[k] > present_from)
                added.possible_stems.push_back(name);
        }
    }

    [[nodiscard]] double gain_in(std::size_t s, const ActingEffect& effect,
                                 const Model* smaller) const {
        if (effect.acts_in(s))
            return smaller == nullptr || smaller->failed()
                       ? std::numeric_limits<double>::infinity()
                       : log_evidence(answer_.stems[s].evidence, search_.fits.noise()[s]) -
                             log_evidence(smaller->stems[s].evidence, search_.fits.noise()[s]) -
                             log_prior_odds();
        const std::size_t c = search_.stems->options().place_of(effect.name());
        return !search_.about || !search_.about->view(s).columns[c].failure.empty()
                   ? -std::numeric_limits<double>::infinity()
                   : search_.about->in_stem(s).gain(std::array{c}).log_evidence - log_prior_odds();
    }

    const SearchResult& search_;
    const Posterior& posterior_;
    const Model& answer_;
    std::vector<EffectAnswer> out_;
};

} // namespace

std::vector<EffectAnswer> effect_answers(const SearchResult& search, const Posterior& posterior,
                                         std::size_t answer) {
    return Effects(search, posterior, answer).list();
}

std::vector<StemAnswer> stem_answers(const SearchResult& search, std::size_t answer) {
    const Stems& stems = *search.stems;
    const Model& model = search.visited[answer];
    const Eigen::MatrixXd covariance =
        model.shared.names.empty() ? Eigen::MatrixXd() : model.shared.covariance();
    std::vector<StemAnswer> out;
    for (std::size_t s = 0; s < stems.size(); ++s) {
        StemAnswer& stem = out.emplace_back();
        stem.name = stems.specimen(s).name;
        stem.rig = stems.specimen(s).rig;
        stem.failure = stems[s].failure;
        if (!stem.failure.empty())
            continue;
        const StemFit& found = model.stems[s];
        stem.before = numbers_of(stems[s].chain);
        stem.after = numbers_of(found.fit);
        add_shared_uncertainty(found, search, model, covariance, stem.after);
        stem.finding = has_structure(found.fit, found.verdict, stems.options().policy)
                           ? found.verdict.finding
                           : Finding::Adequate;
        stem.tests = found.verdict.reason;
        for (const ActingEffect& each : model.effects) {
            if (each.is_shared() || !each.acts_in(s))
                continue;
            if (!each.is_known)
                stem.own.push_back(each.name());
            for (const fit::FittedParameter& parameter : found.fit.parameters)
                if (parameter.id.effect == each.name())
                    stem.own_values.push_back(parameter);
        }
    }
    add_distances(out, &StemNumbers::youngs_modulus, &StemAnswer::youngs_modulus_distance);
    add_distances(out, &StemNumbers::damping, &StemAnswer::damping_distance);
    return out;
}

Population population_of(const std::vector<StemAnswer>& stems, StemNumbers StemAnswer::*numbers) {
    std::vector<double> moduli;
    std::vector<double> dampings;
    for (const StemAnswer& stem : stems)
        if (stem.failure.empty()) {
            moduli.push_back((stem.*numbers).youngs_modulus);
            dampings.push_back((stem.*numbers).damping);
        }
    if (moduli.size() < 2)
        return {};
    return {reduce::summarise(moduli), reduce::summarise(dampings),
            reduce::fit_line(moduli, dampings).correlation};
}

} // namespace culm::diagnose
