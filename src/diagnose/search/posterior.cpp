// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/search/posterior.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <optional>
#include <tuple>
#include <utility>

namespace culm::diagnose {
namespace {

using Names = std::vector<OwnedEffect>;

/// An effect of a model and the fall of χ² that is due to it alone.
struct Share {
    OwnedEffect effect;
    double fall = 0.0;
    double readings = 0.0;              ///< of the stems in which it acts
    std::optional<std::size_t> smaller; ///< the visited model without it

    /// Mean square over the noise that it explains.
    [[nodiscard]] double explained() const { return std::max(0.0, fall / readings); }
    [[nodiscard]] bool is_shared() const { return !effect.second.empty(); }
    /// By which the least important one is found first.
    [[nodiscard]] static std::pair<bool, double> rank(const Share& share) {
        return {share.is_shared(), share.explained()};
    }
};

class Judgement {
  public:
    explicit Judgement(const SearchResult& search)
        : search_(search), policy_(search.stems->options().policy) {
        for (std::size_t k = 0; k < search.visited.size(); ++k)
            if (!search.visited[k].failed())
                place_.emplace(key_of(search.visited[k].effects), k);
    }

    /// Effects of a visited model that matter. The smallest immaterial effect is removed, and the
    /// rest are judged without it: if two effects do the same, one remains.
    [[nodiscard]] Names material(std::size_t model,
                                 std::vector<ImmaterialEffect>* rest = nullptr) const {
        std::vector<Share> shares = shares_of(model);
        while (!shares.empty()) {
            const auto least = std::ranges::min_element(shares, {}, Share::rank);
            if (is_material(*least, shares))
                break;
            const Share removed = std::move(*least);
            shares.erase(least);
            if (rest != nullptr)
                rest->push_back({removed.effect, std::sqrt(removed.explained())});
            if (removed.smaller)
                return material(*removed.smaller, rest);
        }
        Names names;
        for (const Share& share : shares)
            names.push_back(share.effect);
        return in_order(std::move(names));
    }

    /// The same for a model that adds effects with these falls of χ² to its base model.
    [[nodiscard]] Names material(const UnvisitedModel& model) const {
        Names names = material(model.base);
        std::vector<Share> shares = shares_of(model.base);
        for (const auto& [name, fall] : model.added) {
            const auto effect = std::ranges::find(model.effects, name, owned);
            shares.push_back({name, fall, readings_of(*effect), {}});
            if (is_material(shares.back(), shares))
                names.push_back(name);
            else
                shares.pop_back();
        }
        return in_order(std::move(names));
    }

  private:
    /// Does the share matter in addition to the others? What an effect of a rig explains in one
    /// recording is compared neither with the noise nor with the others: it changes Y and β of all
    /// stems alike, so that their means are wrong by it.
    [[nodiscard]] bool is_material(const Share& share, const std::vector<Share>& all) const {
        double others = 0.0; // mean square that they explain
        for (const Share& each : all)
            others += &each == &share ? 0.0 : each.explained();
        others = std::min(others, largest_explained());
        return share.is_shared() ||
               std::sqrt(share.explained()) >
                   std::max(policy_.immaterial_noise, policy_.immaterial_share * std::sqrt(others));
    }

    /// Mean square over the noise that a chain which follows the motion leaves: what effects
    /// explain beyond that is the motion itself, not an error of laws (explained_share()).
    [[nodiscard]] double largest_explained() const {
        double sum = 0.0;
        const Model& best = search_.best_model();
        for (const std::size_t s : search_.stems->fitted())
            for (std::size_t m = 0; m < best.stems[s].evidence.misfits.size(); ++m)
                sum += misfit_of(best, s, m) / best.stems[s].fit.misfits[m].over_followed();
        return sum / std::max(1.0, best.readings());
    }

    [[nodiscard]] Names in_order(Names names) const {
        std::ranges::sort(names, {}, [&](const OwnedEffect& name) {
            return std::pair(search_.stems->options().place_of(name.first), name);
        });
        return names;
    }

    [[nodiscard]] double readings_of(const ActingEffect& effect) const {
        double sum = 0.0;
        for (const std::size_t s : effect.stems)
            for (const fit::RecordingMisfit& misfit : search_.best_model().stems[s].fit.misfits)
                sum += static_cast<double>(misfit.readings);
        return std::max(1.0, sum);
    }

    [[nodiscard]] std::vector<Share> shares_of(std::size_t place) const {
        const Model& model = search_.visited[place];
        std::vector<Share> shares;
        for (std::size_t k = 0; k < model.effects.size(); ++k) {
            const ActingEffect& effect = model.effects[k];
            if (effect.is_known)
                continue;
            Share share{owned(effect), 0.0, readings_of(effect), {}};
            if (const auto smaller = place_.find(key_of(without(model.effects, k)));
                smaller != place_.end()) {
                share.smaller = smaller->second;
                share.fall = misfit(search_.visited[smaller->second]) - misfit(model);
            } else {
                share.fall = fall_of(model, effect);
            }
            shares.push_back(std::move(share));
        }
        return shares;
    }

    /// χ² in units of the noise about the best model.
    [[nodiscard]] double misfit(const Model& model) const {
        double sum = 0.0;
        for (const std::size_t s : search_.stems->fitted()) {
            const ModelEvidence& evidence = model.stems[s].evidence;
            sum += evidence.squared_pulls;
            for (std::size_t m = 0; m < evidence.misfits.size(); ++m)
                sum += misfit_of(model, s, m);
        }
        return sum;
    }
    /// Of one recording of a stem.
    [[nodiscard]] double misfit_of(const Model& model, std::size_t s, std::size_t m) const {
        const NoiseScale& noise = search_.fits.noise()[s];
        return model.stems[s].evidence.misfits[m] /
               (noise.is_noise_known[m] ? 1.0 : noise.variance[m]);
    }

    /// From the quadratic form of χ² at the model's minimum.
    [[nodiscard]] static double fall_of(const Model& model, const ActingEffect& effect) {
        double sum = 0.0;
        for (const std::size_t s : effect.stems) {
            double largest = 0.0;
            for (const fit::FittedParameter& parameter : model.stems[s].fit.parameters)
                if (parameter.id.effect == effect.name() && !parameter.is_place &&
                    parameter.standard_error > 0.0) {
                    const double absent = parameter.fitted_as == physics::FittedAs::Inverse
                                              ? 2.0 * parameter.value // one compliance away
                                              : parameter.absent;
                    largest = std::max(
                        largest,
                        std::pow((parameter.value - absent) / parameter.standard_error, 2));
                }
            sum += largest;
        }
        return sum;
    }

    const SearchResult& search_;
    const Policy& policy_;
    std::map<ModelKey, std::size_t> place_; ///< of the models that were fitted
};

/// Adds the probability of a model to the explanation by the same effects.
void add(Explanation found, const std::vector<Model>& visited, std::map<Names, Explanation>& sets) {
    std::ranges::sort(found.effects);
    const auto [place, is_new] = sets.try_emplace(found.effects, found);
    if (is_new)
        return;
    Explanation& entry = place->second;
    entry.probability += found.probability;
    const bool is_likelier = visited[found.model].log_evidence > visited[entry.model].log_evidence;
    if (found.is_exact != entry.is_exact ? found.is_exact : is_likelier) {
        entry.model = found.model;
        entry.is_exact = found.is_exact;
    }
}

/// Each effect with its family, in the order of families and names.
std::vector<NamedFamily> named_families(const Names& names, const DiagnosisOptions& options) {
    std::vector<NamedFamily> named;
    for (const auto& [name, rig] : names)
        named.push_back({family_of(options, name), rig, {name}});
    std::ranges::sort(named, {}, [](const NamedFamily& each) {
        return std::tuple(each.family, each.rig, each.members.front());
    });
    return named;
}

/// Names the members that hold the probability of a set of families.
void name_members(const std::vector<Explanation>& explanations, const DiagnosisOptions& options,
                  FamilyExplanation& entry) {
    double held = 0.0;
    for (const Explanation& explanation : explanations) {
        if (held >= options.policy.held_probability * entry.probability)
            return;
        const std::vector<NamedFamily> named = named_families(explanation.effects, options);
        if (!std::ranges::equal(named, entry.families, &NamedFamily::is_same_as))
            continue;
        held += explanation.probability;
        for (std::size_t k = 0; k < named.size(); ++k) {
            std::vector<std::string>& members = entry.families[k].members;
            if (std::ranges::find(members, named[k].members.front()) == members.end())
                members.push_back(named[k].members.front());
        }
    }
}

/// Adds the explanations, whose probabilities sum to `total`, and their sets of families.
void add_explanations(const std::map<Names, Explanation>& sets, double total,
                      const DiagnosisOptions& options, Posterior& out) {
    std::map<std::vector<std::pair<physics::Family, std::string>>, FamilyExplanation> by_family;
    for (const auto& [names, sum] : sets) {
        Explanation& explanation = out.explanations.emplace_back(sum);
        explanation.probability /= total;
        std::vector<NamedFamily> families = named_families(names, options);
        std::vector<std::pair<physics::Family, std::string>> key;
        for (NamedFamily& each : families) {
            key.emplace_back(each.family, each.rig);
            each.members.clear();
        }
        FamilyExplanation& entry = by_family[key];
        entry.families = std::move(families);
        entry.probability += explanation.probability;
        if (explanation.probability > entry.largest) {
            entry.largest = explanation.probability;
            entry.model = explanation.model;
        }
    }
    std::ranges::stable_sort(out.explanations, std::greater{}, &Explanation::probability);
    for (auto& [key, entry] : by_family) {
        name_members(out.explanations, options, entry);
        out.by_family.push_back(std::move(entry));
    }
    std::ranges::stable_sort(out.by_family, std::greater{}, &FamilyExplanation::probability);
}

} // namespace

physics::Family family_of(const DiagnosisOptions& options, const std::string& effect) {
    for (const fit::SelectedEffects* effects : {&options.candidates, &options.known})
        for (const physics::SelectedEffect& each : *effects)
            if (each.effect->name == effect)
                return each.effect->family;
    return physics::Family::Own;
}

Posterior posterior_of(const SearchResult& search) {
    const DiagnosisOptions& options = search.stems->options();
    const Judgement judgement(search);
    Posterior out;
    std::map<Names, Explanation> sets;
    double total = 0.0;
    const double likeliest = std::ranges::max(search.about_best); // not of the search's noise
    const double ahead = likeliest - search.about_best[search.best];
    for (std::size_t k = 0; k < search.visited.size(); ++k) {
        const Model& visited = search.visited[k];
        ModelProbability& model = out.models.emplace_back();
        model.effects = added_names(visited.effects);
        model.failure = visited.failure;
        if (visited.failed())
            continue;
        model.log_evidence = search.about_best[k] - likeliest;
        if (!std::isfinite(model.log_evidence))
            continue; // it is a smaller model
        model.probability = std::exp(model.log_evidence);
        total += model.probability;
        const Names names = judgement.material(k);
        add({names, model.probability, k, names.size() == model.effects.size()}, search.visited,
            sets);
    }
    for (const UnvisitedModel& model : search.unvisited) {
        const double probability = std::exp(
            (model.log_evidence - search.best_model().log_evidence) / search.noise_ratio - ahead);
        total += probability;
        add({judgement.material(model), probability, search.best, false}, search.visited, sets);
    }
    for (ModelProbability& model : out.models)
        model.probability /= total;
    std::ranges::stable_sort(out.models, std::greater{}, &ModelProbability::probability);
    add_explanations(sets, total, options, out);
    (void)judgement.material(search.best, &out.immaterial);
    return out;
}

} // namespace culm::diagnose
