// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/laboratory/laboratory_search.hpp"

#include "core/error.hpp"
#include "diagnose/laboratory/rig_prediction.hpp"
#include "diagnose/planned_model.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <utility>

#include <fmt/core.h>

namespace culm::diagnose {
namespace {

constexpr std::size_t most_models = 24;
/// A stem has an own effect if that is more probable than not.
constexpr double present_from = 0.5;
/// Share of the gain of stems' own values that a shared value must explain to be fitted first.
constexpr double most_of_gain = 0.5;

/// Names of the error terms that several stems have.
std::vector<std::string> shared_terms_of(const std::vector<ObservedStem>& stems) {
    std::map<std::string, int> count;
    for (const ObservedStem& stem : stems) {
        std::set<std::string> own;
        for (const fit::Pull& pull : stem.chain.pulls)
            if (!fit::is_of_row(pull.kind))
                own.insert(pull.id);
        for (const std::string& name : own)
            ++count[name];
    }
    std::vector<std::string> names;
    for (const auto& [name, stems_with_it] : count)
        if (stems_with_it > 1)
            names.push_back(name);
    return names;
}

class LaboratorySearch {
  public:
    LaboratorySearch(std::span<const Specimen> specimens, const DiagnosisOptions& options)
        : stems_(specimens, options), options_(options) {}

    [[nodiscard]] LaboratorySearchResult run() {
        fit_chains();
        explore();
        LaboratorySearchResult out;
        for (auto& [key, prediction] : predictions_)
            if (!visited_keys_.contains(key)) {
                prediction.log_evidence = expected(prediction);
                out.unvisited.push_back(std::move(prediction));
            }
        std::ranges::stable_sort(out.unvisited, std::greater{},
                                 &LaboratoryPrediction::log_evidence);
        out.stems = std::move(stems_.stems);
        out.best = base_;
        out.visited = std::move(visited_);
        out.surveys = std::move(surveys_);
        out.noise = fit_.noise();
        out.priors = fit_.priors();
        return out;
    }

  private:
    [[nodiscard]] const LaboratoryModel& base() const { return visited_[base_]; }

    // --- The published chain

    void fit_chains() {
        options_.report(
            fmt::format("fitting the published chain to {} stems", stems_.specimens.size()));
        auto baselines = stems_.map([&](std::size_t s, const fit::FitOptions& options) {
            return baseline_of(stems_.specimens[s], options);
        });
        for (std::size_t s = 0; s < baselines.size(); ++s)
            stems_.stems.push_back(observed_stem(stems_.specimens[s], *std::move(baselines[s])));
        if (stems_.fitted_stems() == 0)
            throw core::NumericalError(core::FailureKind::FitFailed,
                                       "no stem can be fitted; the first one: " +
                                           stems_.stems.front().failure);
        visit_chain();
    }

    void visit_chain() {
        stems_.shared_terms = shared_terms_of(stems_.stems);
        visited_.clear();
        visited_keys_.clear();
        predictions_.clear();
        LaboratoryModel chain;
        chain.own.resize(stems_.stems.size());
        std::vector<NoiseScale> noise;
        for (const ObservedStem& stem : stems_.stems) {
            chain.stems.push_back({stem.chain, {}, {}});
            noise.push_back(noise_as_assumed(stem.chain));
        }
        fit_.set_noise(std::move(noise));
        for (const std::string& rig : stems_.rigs())
            for (const physics::SelectedEffect& each : stems_.known_of_rig)
                chain.rig_effects.push_back(stems_.with_default_values(each, rig, true));
        fit_.fit(chain);
        if (chain.failed())
            throw core::NumericalError(core::FailureKind::FitFailed,
                                       "the model cannot be fitted: " + chain.failure);
        visited_keys_.insert(name_of(chain));
        visited_.push_back(std::move(chain));
        set_base(0);
    }

    void set_base(std::size_t place) {
        base_ = place;
        surveys_.clear();
    }

    // --- Predictions

    void survey() {
        if (!surveys_.empty())
            return;
        options_.report(fmt::format("computing the effects of {} candidates about {}",
                                    options_.candidates.size(), name_of(base())));
        auto found = stems_.map([&](std::size_t s, const fit::FitOptions& options) {
            return survey_of(stems_.stems[s], stems_.effects_of(base(), s), base().stems[s].fit,
                             !stems_.specimens[s].rig.empty(), options_.candidates, options);
        });
        for (std::optional<StemSurvey>& each : found)
            surveys_.push_back(std::move(each).value_or(StemSurvey{}));
        std::vector<NoiseScale> noise;
        for (const StemFit& stem : base().stems)
            noise.push_back(noise_scale_of(stem.fit));
        fit_.set_noise(std::move(noise));
        for (LaboratoryModel& model : visited_)
            if (!model.failed())
                fit_.judge(model);
    }

    void predict() {
        // About another model, sets of several effects were predicted across a larger misfit.
        std::erase_if(predictions_, [&](const auto& entry) {
            return entry.second.base != base_ && entry.second.rig_effects.size() > 1;
        });
        for (const std::string& rig : stems_.rigs()) {
            const RigPrediction rig_prediction(stems_, surveys_, base(), rig);
            const auto added = static_cast<std::size_t>(
                std::ranges::count_if(base().rig_effects, [&](const RigEffect& each) {
                    return each.rig == rig && !each.is_known;
                }));
            std::size_t room = options_.most_effects > added ? options_.most_effects - added : 0;
            if (is_rough())
                room = std::min<std::size_t>(room, 1);
            for_each_set(options_.candidates.size(), room,
                         [&](const auto& set) { return predict_set(rig_prediction, set); });
        }
        for (std::size_t c = 0; c < options_.candidates.size(); ++c)
            predict_own(c);
    }

    [[nodiscard]] bool is_rough() const {
        double chi_squared = 0.0;
        double readings = 1.0;
        for (const StemFit& stem : base().stems) {
            chi_squared += stem.fit.chi_squared;
            readings += static_cast<double>(stem.fit.readings);
        }
        return chi_squared > options_.policy.rough_misfit * readings;
    }

    /// False if no model has these additions.
    bool predict_set(const RigPrediction& rig, const std::vector<std::size_t>& set) {
        fit::SelectedEffects together;
        for (const std::size_t each : set)
            together.push_back(options_.candidates[each]);
        if (!rig.failure(set.back()).empty() || !can_be_combined(together))
            return false;
        const PredictedGain gain = rig.gain(set);
        if (std::isfinite(gain.log_evidence)) {
            LaboratoryPrediction added;
            for (std::size_t e = 0; e < set.size(); ++e)
                added.rig_effects.push_back(rig.estimated(set[e], e, gain));
            added.gain = gain.log_evidence;
            add_prediction(std::move(added));
        }
        return true;
    }

    void predict_own(std::size_t candidate) {
        std::vector<double> gains;
        std::vector<std::size_t> stems;
        for (std::size_t s = 0; s < surveys_.size(); ++s)
            if (!surveys_[s].own_gains.empty()) {
                gains.push_back(surveys_[s].own_gains[candidate]);
                stems.push_back(s);
            }
        const std::vector<double> presence = presence_of(gains);
        LaboratoryPrediction added;
        added.own.push_back(options_.candidates[candidate]);
        for (std::size_t k = 0; k < stems.size(); ++k)
            if (presence[k] > present_from) {
                added.stems.push_back(stems[k]);
                added.gain += gains[k];
            }
        if (added.stems.empty())
            return;
        added.gain += log_prior_odds() + log_presence(added.stems.size(), stems_.fitted_stems());
        add_prediction(std::move(added));
    }

    void add_prediction(LaboratoryPrediction added) {
        added.base = base_;
        const std::string key = name_of(owners_of(added, base()));
        if (!visited_keys_.contains(key))
            predictions_[key] = std::move(added);
    }

    /// The model that was predicted, before its fit.
    [[nodiscard]] LaboratoryModel with(const LaboratoryPrediction& added) const {
        LaboratoryModel model = visited_[added.base];
        model.base = added.base;
        model.predicted_gain = added.gain;
        model.rig_effects.insert(model.rig_effects.end(), added.rig_effects.begin(),
                                 added.rig_effects.end());
        for (const std::size_t s : added.stems)
            model.own[s].insert(model.own[s].end(), added.own.begin(), added.own.end());
        return model;
    }

    /// Log evidence of a model that was not fitted. Across a large misfit predictions are too high:
    /// the gains about a base are scaled by what fits of its additions reached.
    [[nodiscard]] double expected(const LaboratoryPrediction& prediction) const {
        const double from = visited_[prediction.base].log_evidence;
        double reached = 0.0;
        for (const LaboratoryModel& model : visited_)
            if (model.predicted_gain > 0.0 && model.base == prediction.base)
                reached = std::max(reached, (model.log_evidence - from) / model.predicted_gain);
        const bool is_known = reached > 0.0 && prediction.gain > 0.0;
        return from + (is_known ? std::min(reached, 1.0) : 1.0) * prediction.gain;
    }

    /// An effect of a rig is fitted with one value for all stems before it gets one for each, if
    /// that is predicted to explain most of it.
    [[nodiscard]] bool is_shared_first(const LaboratoryPrediction& own) const {
        return !own.own.empty() && std::ranges::any_of(predictions_, [&](const auto& entry) {
            const LaboratoryPrediction& shared = entry.second;
            return shared.base == own.base && shared.rig_effects.size() == 1 &&
                   shared.rig_effects.front().effect.effect == own.own.front().effect &&
                   shared.gain > most_of_gain * own.gain && !visited_keys_.contains(entry.first);
        });
    }

    // --- The search

    void explore() {
        for (;;) {
            const auto likeliest =
                std::ranges::max_element(visited_, {}, &LaboratoryModel::log_evidence);
            if (const auto now = static_cast<std::size_t>(likeliest - visited_.begin());
                now != base_)
                set_base(now);
            const bool is_full = visited_.size() >= most_models;
            if (!is_full && visit_smaller())
                continue;
            survey();
            predict();
            const LaboratoryPrediction* next = nullptr;
            for (const auto& [key, each] : predictions_)
                if (!visited_keys_.contains(key) && !is_shared_first(each) &&
                    (next == nullptr || expected(each) > expected(*next)))
                    next = &each;
            const double gain = next == nullptr ? -std::numeric_limits<double>::infinity()
                                                : expected(*next) - base().log_evidence;
            if (!is_full && !(gain > 0.0) && estimate_noise_again())
                continue;
            if (is_full || !(gain > -options_.policy.unvisited_margin))
                return;
            fit_and_add(with(*next), {next->stems.begin(), next->stems.end()});
        }
    }

    void fit_and_add(LaboratoryModel model, const std::set<std::size_t>& with_new_own = {}) {
        const std::string key = name_of(model);
        options_.report("fitting " + key);
        visited_keys_.insert(key);
        fit_.fit(model, with_new_own);
        if (!model.failed() && name_of(model) != key)
            model.failure = "the effect is absent from every stem";
        if (model.failed())
            model.log_evidence = -std::numeric_limits<double>::infinity();
        visited_.push_back(std::move(model));
    }

    /// Fits the base without one of its effects; true if a model was fitted.
    bool visit_smaller() {
        std::set<std::string> own;
        for (const fit::SelectedEffects& each : base().own)
            for (const physics::SelectedEffect& effect : each)
                own.insert(effect.effect->name());
        const std::size_t added = base().rig_effects.size() + own.size();
        for (std::size_t k = 0; k < base().rig_effects.size() && added > 1; ++k) {
            LaboratoryModel model = base();
            if (model.rig_effects[k].is_known)
                continue;
            model.rig_effects.erase(model.rig_effects.begin() + static_cast<std::ptrdiff_t>(k));
            if (fit_smaller(std::move(model)))
                return true;
        }
        for (const std::string& name : own) {
            LaboratoryModel model = base();
            for (fit::SelectedEffects& each : model.own)
                std::erase_if(each, [&](const auto& one) { return one.effect->name() == name; });
            if (added > 1 && fit_smaller(model))
                return true;
            for (const physics::SelectedEffect& candidate : options_.candidates)
                if (candidate.effect->name() == name &&
                    candidate.effect->belongs_to() == physics::BelongsTo::Rig &&
                    share(candidate, model) && fit_smaller(std::move(model)))
                    return true;
        }
        return false;
    }

    /// Adds the effect to every rig on which stems have it as their own effect; false if there
    /// is no such rig. A size starts from the mean of the stems' values.
    [[nodiscard]] bool share(const physics::SelectedEffect& effect, LaboratoryModel& model) const {
        const std::string name = effect.effect->name();
        std::set<std::string> rigs;
        for (std::size_t s = 0; s < stems_.stems.size(); ++s)
            if (!stems_.specimens[s].rig.empty() &&
                std::ranges::any_of(base().own[s],
                                    [&](const auto& each) { return each.effect->name() == name; }))
                rigs.insert(stems_.specimens[s].rig);
        for (const std::string& rig : rigs) {
            RigEffect added = stems_.with_default_values(effect, rig, false);
            const std::vector<physics::EffectParameter> parameters = effect.effect->parameters();
            for (std::size_t k = 0; k < parameters.size(); ++k) {
                double sum = 0.0;
                double count = 0.0;
                for (std::size_t s = 0; s < stems_.stems.size(); ++s)
                    for (const fit::FittedParameter& each : base().stems[s].fit.parameters)
                        if (stems_.specimens[s].rig == rig && each.id.effect == name &&
                            each.id.name == parameters[k].name) {
                            sum += fit::to_coordinate(each.fitted_as, each.value);
                            count += 1.0;
                        }
                if (count > 0.0)
                    added.values[k] = fit::from_coordinate(parameters[k].fitted_as, sum / count);
            }
            model.rig_effects.push_back(std::move(added));
        }
        return !rigs.empty();
    }

    bool fit_smaller(LaboratoryModel model) {
        if (visited_keys_.contains(name_of(model)))
            return false;
        model.predicted_gain = 0.0;
        fit_and_add(std::move(model));
        return true;
    }

    // --- Noise about the best model

    /// Once; false if the noise is unchanged.
    bool estimate_noise_again() {
        if (has_new_noise_ || base_ == 0 || is_rough())
            return false;
        has_new_noise_ = true;
        options_.report("estimating the noise about the best model");
        auto found = stems_.map([&](std::size_t s, const fit::FitOptions& options) {
            return baseline_with_noise_about(base().stems[s].fit, stems_.specimens[s],
                                             stems_.stems[s], options);
        });
        bool is_other = false;
        for (std::size_t s = 0; s < found.size(); ++s)
            if (found[s] && *found[s]) {
                stems_.stems[s] = observed_stem(stems_.specimens[s], **std::move(found[s]));
                is_other = true;
            }
        if (!is_other)
            return false;
        LaboratoryModel best = base();
        visit_chain();
        fit_and_add(std::move(best));
        return true;
    }

    LaboratoryStems stems_;
    LaboratoryFit fit_{stems_};
    const DiagnosisOptions& options_;
    std::vector<LaboratoryModel> visited_;
    std::set<std::string> visited_keys_;
    std::size_t base_ = 0;
    std::vector<StemSurvey> surveys_;
    std::map<std::string, LaboratoryPrediction> predictions_;
    bool has_new_noise_ = false;
};

} // namespace

EffectOwners owners_of(const LaboratoryPrediction& prediction, const LaboratoryModel& base) {
    EffectOwners owners = owners_of(base);
    for (const RigEffect& each : prediction.rig_effects)
        owners.emplace(each.effect.effect->name(), each.rig);
    for (const physics::SelectedEffect& each : prediction.own)
        owners.emplace(each.effect->name(), "");
    return owners;
}

std::vector<double> presence_of(std::span<const double> gains) {
    constexpr int iterations = 50;
    std::vector<double> probability(gains.size(), 0.0);
    double share = 0.5;
    for (int k = 0; k < iterations; ++k) {
        double sum = 0.0;
        for (std::size_t s = 0; s < gains.size(); ++s) {
            // −infinity: the effect cannot act in this stem.
            const double log_odds = std::log(share / (1.0 - share)) + gains[s];
            probability[s] = 1.0 / (1.0 + std::exp(-log_odds));
            sum += probability[s];
        }
        share = (1.0 + sum) / (2.0 + static_cast<double>(gains.size()));
    }
    return probability;
}

LaboratorySearchResult search_laboratory(std::span<const Specimen> specimens,
                                         const DiagnosisOptions& options) {
    return LaboratorySearch(specimens, options).run();
}

} // namespace culm::diagnose
