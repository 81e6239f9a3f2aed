// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/posterior.hpp"

#include "diagnose/planned_model.hpp"
#include "physics/effects/library.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace culm::diagnose {
namespace {

using Names = std::vector<std::string>;

/// An effect of a model and the fall of χ² that is due to it alone.
struct Share {
    std::string effect;
    double fall = 0.0;
    bool moves_material = false;           ///< Y or β leaves its interval without it
    const VisitedModel* smaller = nullptr; ///< the model without it, if that was fitted
};

class Judgement {
  public:
    Judgement(const SearchResult& search, const SearchOptions& options, const Policy& policy)
        : search_(search), options_(options), policy_(policy) {
        for (const fit::RecordingMisfit& misfit : search.best_fit.misfits)
            readings_ += static_cast<double>(misfit.readings);
    }

    /// Effects of a visited model that matter. The smallest immaterial effect is removed, and the
    /// rest are judged without it: if two effects do the same, one remains.
    [[nodiscard]] Names material(std::size_t model, std::vector<ImmaterialEffect>* rest) const {
        std::vector<Share> shares = shares_of(model);
        while (!shares.empty()) {
            std::ranges::stable_sort(shares, std::greater{}, &Share::fall);
            if (is_material(shares))
                break;
            const Share least = std::move(shares.back());
            shares.pop_back();
            if (rest != nullptr)
                rest->push_back({least.effect, std::sqrt(std::max(0.0, least.fall / readings_))});
            if (least.smaller != nullptr)
                return material(static_cast<std::size_t>(least.smaller - search_.visited.data()),
                                rest);
        }
        Names names;
        for (const Share& share : shares)
            names.push_back(share.effect);
        return in_order(std::move(names));
    }

    /// The same for a model that adds effects with these falls of χ² to its base model.
    [[nodiscard]] Names material(const UnvisitedModel& model) const {
        Names names = material(model.base, nullptr);
        std::vector<Share> shares = shares_of(model.base);
        for (std::size_t k = 0; k < model.added.size(); ++k) {
            shares.push_back({model.added[k], model.falls[k], false, nullptr});
            if (is_material(shares))
                names.push_back(model.added[k]);
            else
                shares.pop_back();
        }
        return in_order(std::move(names));
    }

    /// χ² above the noise.
    [[nodiscard]] double excess(const VisitedModel& model) const {
        return std::max(0.0, misfit(model) - readings_);
    }

  private:
    /// Does the last and smallest share matter in addition to the others?
    [[nodiscard]] bool is_material(const std::vector<Share>& shares) const {
        double before = 0.0; // mean square that the others explain
        for (std::size_t k = 0; k + 1 < shares.size(); ++k)
            before += std::max(0.0, shares[k].fall / readings_);
        const double least =
            std::max(policy_.immaterial_noise, policy_.immaterial_share * std::sqrt(before));
        return std::sqrt(std::max(0.0, shares.back().fall / readings_)) > least ||
               shares.back().moves_material;
    }

    [[nodiscard]] Names in_order(Names names) const {
        std::ranges::sort(names, {}, [&](const std::string& name) {
            const auto found = std::ranges::find_if(
                options_.candidates, [&](const auto& each) { return each.effect->name() == name; });
            return std::pair(found - options_.candidates.begin(), name);
        });
        return names;
    }

    /// The model without one effect, if it was visited.
    [[nodiscard]] const VisitedModel* without(const VisitedModel& model, std::size_t k) const {
        fit::SelectedEffects rest = model.fit.effects;
        rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(k));
        const ModelKey key = key_of(rest);
        const auto found = std::ranges::find_if(search_.visited, [&](const VisitedModel& each) {
            return key_of(each.fit.effects) == key && !each.fit.failed();
        });
        return found == search_.visited.end() ? nullptr : &*found;
    }

    [[nodiscard]] std::vector<Share> shares_of(std::size_t place) const {
        const VisitedModel& model = search_.visited[place];
        std::vector<Share> shares;
        for (std::size_t k = options_.known.size(); k < model.fit.effects.size(); ++k) {
            Share share;
            share.effect = model.fit.effects[k].effect->name();
            if (const VisitedModel* smaller = without(model, k)) {
                share.smaller = smaller;
                share.fall = misfit(*smaller) - misfit(model);
                share.moves_material =
                    share.fall > fit::contradiction * fit::contradiction && moves(*smaller, model);
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

    /// Does Y or β of the model lie beyond the 95 % interval of the smaller one?
    [[nodiscard]] static bool moves(const VisitedModel& smaller, const VisitedModel& larger) {
        for (const physics::ParameterId& id :
             {physics::bond_youngs_modulus, physics::bond_damping}) {
            const auto before =
                std::ranges::find(smaller.fit.parameters, id, &fit::FittedParameter::id);
            const auto after =
                std::ranges::find(larger.fit.parameters, id, &fit::FittedParameter::id);
            if (before == smaller.fit.parameters.end() || after == larger.fit.parameters.end())
                continue;
            const double change = std::abs(after->value - before->value);
            if (change > interval_half_width(*before))
                return true;
        }
        return false;
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
    const SearchOptions& options_;
    const Policy& policy_;
    double readings_ = 0.0;
};

physics::EffectPointer effect_of(const SearchOptions& options, const std::string& name) {
    for (const physics::SelectedEffect& candidate : options.candidates)
        if (candidate.effect->name() == name)
            return candidate.effect;
    return nullptr;
}

class Probabilities {
  public:
    Probabilities(const SearchResult& search, const SearchOptions& options, bool leaves_structure,
                  const Policy& policy)
        : search_(search), options_(options), leaves_structure_(leaves_structure), policy_(policy),
          judgement_(search, options, policy) {
        best_ = log_evidence(search.visited[search.best].evidence, search.noise);
    }

    [[nodiscard]] Posterior compute() {
        Posterior out;
        for (std::size_t k = 0; k < search_.visited.size(); ++k)
            add_visited(k, out);
        for (const UnvisitedModel& model : search_.unvisited)
            add_unvisited(model);
        for (ModelProbability& model : out.models)
            model.probability /= total_;
        finish(out);
        (void)judgement_.material(search_.best, &out.immaterial);
        return out;
    }

  private:
    void add_visited(std::size_t k, Posterior& out) {
        const VisitedModel& visited = search_.visited[k];
        ModelProbability& model = out.models.emplace_back();
        for (std::size_t e = options_.known.size(); e < visited.fit.effects.size(); ++e)
            model.effects.push_back(visited.fit.effects[e].effect->name());
        if (visited.fit.failed()) {
            model.failure = visited.fit.reason;
            return;
        }
        model.log_evidence = log_evidence(visited.evidence, search_.noise) - best_;
        if (!visited.evidence.absent_effects.empty())
            return; // it is a smaller model
        model.probability =
            is_rival(visited) ? 1.0 : std::exp(model.log_evidence / policy_.temperature);
        total_ += model.probability;
        Names names = resolved_in(judgement_.material(k, nullptr), visited.fit);
        const bool is_exact = names.size() == model.effects.size();
        add(std::move(names), model.probability, k, is_exact);
    }

    /// Does the model explain as much as laws of this accuracy can, without more effects than the
    /// best model?
    [[nodiscard]] bool is_rival(const VisitedModel& model) const {
        const VisitedModel& best = search_.visited[search_.best];
        if (!leaves_structure_ || model.fit.effects.size() > best.fit.effects.size())
            return false;
        return judgement_.excess(model) <=
               policy_.unexplained_share * judgement_.excess(search_.visited.front());
    }

    void add_unvisited(const UnvisitedModel& model) {
        const double probability =
            std::exp((model.log_evidence - search_.visited[search_.best].log_evidence) /
                     (policy_.temperature * search_.noise.mean_known()));
        total_ += probability;
        add(resolved_in(judgement_.material(model), search_.visited[model.base].fit), probability,
            search_.best, false);
    }

    [[nodiscard]] Names resolved_in(Names names, const fit::Fit& fit) const {
        for (std::string& name : names)
            if (const physics::EffectPointer effect = effect_of(options_, name))
                name = special_case_of(*effect, fit);
        return names;
    }

    void add(Names names, double probability, std::size_t model, bool is_exact) {
        std::ranges::sort(names);
        Explanation& entry =
            sets_.try_emplace(names, Explanation{names, 0.0, model, is_exact}).first->second;
        entry.probability += probability;
        if (is_exact != entry.is_exact ? is_exact : is_likelier(model, entry.model)) {
            entry.model = model;
            entry.is_exact = is_exact;
        }
    }

    [[nodiscard]] bool is_likelier(std::size_t one, std::size_t other) const {
        return search_.visited[one].log_evidence > search_.visited[other].log_evidence;
    }

    void finish(Posterior& out) {
        std::map<std::vector<physics::Family>, FamilyExplanation> families;
        for (auto& [names, explanation] : sets_) {
            explanation.probability /= total_;
            const std::vector<NamedFamily> named = named_families(names);
            FamilyExplanation& entry = families[families_of(named)];
            if (entry.families.empty())
                for (const NamedFamily& each : named)
                    entry.families.push_back({each.family, {}});
            entry.probability += explanation.probability;
            if (explanation.probability > entry.largest) {
                entry.largest = explanation.probability;
                entry.model = explanation.model;
            }
            out.explanations.push_back(explanation);
        }
        std::ranges::stable_sort(out.explanations, std::greater{}, &Explanation::probability);
        for (auto& [key, entry] : families)
            out.by_family.push_back(std::move(entry));
        std::ranges::stable_sort(out.by_family, std::greater{}, &FamilyExplanation::probability);
        for (FamilyExplanation& entry : out.by_family)
            name_members(out.explanations, entry);
    }

    /// Names the members that hold the probability of a set of families.
    void name_members(const std::vector<Explanation>& explanations,
                      FamilyExplanation& entry) const {
        double held = 0.0;
        for (const Explanation& explanation : explanations) {
            if (held >= policy_.held_probability * entry.probability)
                return;
            const std::vector<NamedFamily> named = named_families(explanation.effects);
            if (families_of(named) != families_of(entry.families))
                continue;
            held += explanation.probability;
            for (std::size_t k = 0; k < named.size(); ++k) {
                std::vector<std::string>& members = entry.families[k].members;
                if (std::ranges::find(members, named[k].members.front()) == members.end())
                    members.push_back(named[k].members.front());
            }
        }
    }

    /// Each effect with its family, in the order of families and names.
    [[nodiscard]] std::vector<NamedFamily> named_families(const Names& names) const {
        std::vector<NamedFamily> named;
        for (const std::string& name : names)
            named.push_back({family_named(name), {name}});
        std::ranges::sort(named, {}, [](const NamedFamily& each) {
            return std::pair(each.family, each.members.front());
        });
        return named;
    }

    [[nodiscard]] static std::vector<physics::Family>
    families_of(const std::vector<NamedFamily>& named) {
        std::vector<physics::Family> families;
        families.reserve(named.size());
        for (const NamedFamily& each : named)
            families.push_back(each.family);
        return families;
    }

    [[nodiscard]] physics::Family family_named(const std::string& name) const {
        if (const physics::EffectPointer effect = effect_of(options_, name))
            return effect->family();
        return physics::effect_named(name)->family();
    }

    const SearchResult& search_;
    const SearchOptions& options_;
    bool leaves_structure_;
    const Policy& policy_;
    Judgement judgement_;
    double best_ = 0.0;
    double total_ = 0.0;
    std::map<Names, Explanation> sets_;
};

} // namespace

Posterior posterior_of(const SearchResult& search, const SearchOptions& options,
                       bool leaves_structure, const Policy& policy) {
    return Probabilities(search, options, leaves_structure, policy).compute();
}

} // namespace culm::diagnose
