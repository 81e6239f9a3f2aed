// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/posterior.hpp"

#include "diagnose/planned_model.hpp"
#include "physics/effects/library.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

namespace culm::diagnose {
namespace {

using Names = std::vector<std::string>;

/// An effect of a model and the fall of χ² that is due to it alone.
struct Share {
    std::string effect;
    double fall = 0.0;
    std::optional<std::size_t> smaller; ///< the visited model without it
};

class Judgement {
  public:
    Judgement(const SearchResult& search, const DiagnosisOptions& options)
        : search_(search), options_(options) {
        for (const fit::RecordingMisfit& misfit : search.best_fit.misfits)
            readings_ += static_cast<double>(misfit.readings);
    }

    /// Effects of a visited model that matter. The smallest immaterial effect is removed, and the
    /// rest are judged without it: if two effects do the same, one remains.
    [[nodiscard]] Names material(std::size_t model,
                                 std::vector<ImmaterialEffect>* rest = nullptr) const {
        std::vector<Share> shares = shares_of(model);
        while (!shares.empty()) {
            std::ranges::stable_sort(shares, std::greater{}, &Share::fall);
            if (is_material(shares))
                break;
            const Share least = std::move(shares.back());
            shares.pop_back();
            if (rest != nullptr)
                rest->push_back({least.effect, std::sqrt(std::max(0.0, least.fall / readings_))});
            if (least.smaller)
                return material(*least.smaller, rest);
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
        for (std::size_t k = 0; k < model.added.size(); ++k) {
            shares.push_back({model.added[k], model.falls[k], {}});
            if (is_material(shares))
                names.push_back(model.added[k]);
            else
                shares.pop_back();
        }
        return in_order(std::move(names));
    }

  private:
    /// Does the last and smallest share matter in addition to the others?
    [[nodiscard]] bool is_material(const std::vector<Share>& shares) const {
        double before = 0.0; // mean square that the others explain
        for (std::size_t k = 0; k + 1 < shares.size(); ++k)
            before += std::max(0.0, shares[k].fall / readings_);
        const double least = std::max(options_.policy.immaterial_noise,
                                      options_.policy.immaterial_share * std::sqrt(before));
        return std::sqrt(std::max(0.0, shares.back().fall / readings_)) > least;
    }

    [[nodiscard]] Names in_order(Names names) const {
        std::ranges::sort(names, {}, [&](const std::string& name) {
            const auto found = std::ranges::find_if(
                options_.candidates, [&](const auto& each) { return each.effect->name() == name; });
            return std::pair(found - options_.candidates.begin(), name);
        });
        return names;
    }

    [[nodiscard]] std::vector<Share> shares_of(std::size_t place) const {
        const VisitedModel& model = search_.visited[place];
        std::vector<Share> shares;
        for (std::size_t k = options_.known.size(); k < model.fit.effects.size(); ++k) {
            Share share;
            share.effect = model.fit.effects[k].effect->name();
            fit::SelectedEffects rest = model.fit.effects;
            rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(k));
            const ModelKey key = key_of(rest);
            const auto smaller = std::ranges::find_if(search_.visited, [&](const auto& each) {
                return key_of(each.fit.effects) == key && !each.fit.failed();
            });
            if (smaller != search_.visited.end()) {
                share.smaller = static_cast<std::size_t>(smaller - search_.visited.begin());
                share.fall = misfit(*smaller) - misfit(model);
            } else {
                share.fall = fall_of(model, share.effect);
            }
            shares.push_back(std::move(share));
        }
        return shares;
    }

    /// χ² in units of the noise about the best model.
    [[nodiscard]] double misfit(const VisitedModel& model) const {
        double sum = model.evidence.squared_pulls;
        for (std::size_t m = 0; m < model.evidence.misfits.size(); ++m)
            sum += model.evidence.misfits[m] /
                   (search_.noise.is_noise_known[m] ? 1.0 : search_.noise.variance[m]);
        return sum;
    }

    /// From the quadratic form of χ² at the model's minimum.
    [[nodiscard]] static double fall_of(const VisitedModel& model, const std::string& effect) {
        double largest = 0.0;
        for (const fit::FittedParameter& parameter : model.fit.parameters)
            if (parameter.id.effect == effect && !parameter.is_place &&
                parameter.standard_error > 0.0) {
                const double absent = parameter.fitted_as == physics::FittedAs::Inverse
                                          ? 2.0 * parameter.value // one compliance away
                                          : parameter.absent;
                largest = std::max(
                    largest, std::pow((parameter.value - absent) / parameter.standard_error, 2));
            }
        return largest;
    }

    const SearchResult& search_;
    const DiagnosisOptions& options_;
    double readings_ = 0.0;
};

physics::EffectPointer effect_of(const DiagnosisOptions& options, const std::string& name) {
    for (const physics::SelectedEffect& candidate : options.candidates)
        if (candidate.effect->name() == name)
            return candidate.effect;
    return nullptr;
}

/// Adds the probability of a model to the explanation by the same effects.
void add(Explanation found, const std::vector<VisitedModel>& visited,
         std::map<Names, Explanation>& sets) {
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
    for (const std::string& name : names) {
        const physics::EffectPointer effect = effect_of(options, name);
        named.push_back({(effect ? effect : physics::effect_named(name))->family(), {name}});
    }
    std::ranges::sort(named, {}, [](const NamedFamily& each) {
        return std::pair(each.family, each.members.front());
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
        if (!std::ranges::equal(named, entry.families, {}, &NamedFamily::family,
                                &NamedFamily::family))
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
void add_explanations(std::map<Names, Explanation> sets, double total,
                      const DiagnosisOptions& options, Posterior& out) {
    std::map<std::vector<physics::Family>, FamilyExplanation> by_family;
    for (auto& [names, explanation] : sets) {
        explanation.probability /= total;
        std::vector<NamedFamily> families = named_families(names, options);
        std::vector<physics::Family> key;
        for (NamedFamily& each : families) {
            key.push_back(each.family);
            each.members.clear();
        }
        FamilyExplanation& entry = by_family[key];
        entry.families = std::move(families);
        entry.probability += explanation.probability;
        if (explanation.probability > entry.largest) {
            entry.largest = explanation.probability;
            entry.model = explanation.model;
        }
        out.explanations.push_back(explanation);
    }
    std::ranges::stable_sort(out.explanations, std::greater{}, &Explanation::probability);
    for (auto& [key, entry] : by_family) {
        name_members(out.explanations, options, entry);
        out.by_family.push_back(std::move(entry));
    }
    std::ranges::stable_sort(out.by_family, std::greater{}, &FamilyExplanation::probability);
}

} // namespace

Posterior posterior_of(const SearchResult& search, const DiagnosisOptions& options) {
    const Judgement judgement(search, options);
    const VisitedModel& best = search.visited[search.best];
    Posterior out;
    std::map<Names, Explanation> sets;
    double total = 0.0;
    const double best_evidence = log_evidence(best.evidence, search.noise);
    for (std::size_t k = 0; k < search.visited.size(); ++k) {
        const VisitedModel& visited = search.visited[k];
        ModelProbability& model = out.models.emplace_back();
        for (std::size_t e = options.known.size(); e < visited.fit.effects.size(); ++e)
            model.effects.push_back(visited.fit.effects[e].effect->name());
        if (visited.fit.failed()) {
            model.failure = visited.fit.reason;
            continue;
        }
        model.log_evidence = log_evidence(visited.evidence, search.noise) - best_evidence;
        if (!visited.evidence.absent_effects.empty())
            continue; // it is a smaller model
        model.probability = std::exp(model.log_evidence);
        total += model.probability;
        const Names names = judgement.material(k);
        add({names, model.probability, k, names.size() == model.effects.size()}, search.visited,
            sets);
    }
    for (const UnvisitedModel& model : search.unvisited) {
        const double probability =
            std::exp((model.log_evidence - best.log_evidence) / search.noise.mean_known());
        total += probability;
        add({judgement.material(model), probability, search.best, false}, search.visited, sets);
    }
    for (ModelProbability& model : out.models)
        model.probability /= total;
    add_explanations(std::move(sets), total, options, out);
    (void)judgement.material(search.best, &out.immaterial);
    return out;
}

} // namespace culm::diagnose
