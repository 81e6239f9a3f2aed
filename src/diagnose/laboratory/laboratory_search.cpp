// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/laboratory/laboratory_search.hpp"

#include "core/error.hpp"
#include "diagnose/evidence/linear_evidence.hpp"
#include "diagnose/planned_model.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <set>
#include <utility>

#include <Eigen/Cholesky>
#include <fmt/core.h>
#include <fmt/ranges.h>

namespace culm::diagnose {
namespace {

constexpr int most_newton_steps = 8;
/// Squared Newton step, in standard deviations, below which the shared numbers have converged.
constexpr double small_step = 0.01;
constexpr std::size_t most_visited = 24;
constexpr std::size_t most_noise_estimates = 1;

/// Names of the error terms that several stems have.
std::vector<std::string> shared_terms_of(const std::vector<ObservedStem>& stems) {
    std::map<std::string, int> count;
    for (const ObservedStem& stem : stems) {
        std::set<std::string> own;
        for (const fit::ObservedRecording& recording : stem.recordings)
            if (recording.errors)
                for (const fit::ReadingErrors::Term& term : recording.errors->terms)
                    if (!term.is_of_row)
                        own.insert(term.name);
        for (const std::string& name : own)
            ++count[name];
    }
    std::vector<std::string> names;
    for (const auto& [name, stems_with_it] : count)
        if (stems_with_it > 1)
            names.push_back(name);
    return names;
}

std::string key_of(const LaboratoryModel& model) {
    std::set<std::string> names;
    for (const RigEffect& each : model.rig_effects)
        names.insert(each.effect.effect->name() + " of rig " + each.rig);
    for (const fit::SelectedEffects& own : model.own)
        for (const physics::SelectedEffect& each : own)
            names.insert(each.effect->name());
    return fmt::format("{}", fmt::join(names, ", "));
}

std::string key_of(const LaboratoryModel& base, const LaboratoryPrediction& added) {
    LaboratoryModel model;
    model.rig_effects = base.rig_effects;
    model.own = base.own;
    model.rig_effects.insert(model.rig_effects.end(), added.rig_effects.begin(),
                             added.rig_effects.end());
    model.own.push_back(added.own);
    return key_of(model);
}

class LaboratorySearch {
  public:
    LaboratorySearch(std::span<const Specimen> specimens, const SearchOptions& options,
                     const Policy& policy)
        : specimens_(specimens), options_(options), policy_(policy) {
        for (const physics::SelectedEffect& each : options.known)
            (each.effect->belongs_to() == physics::BelongsTo::Rig ? known_rig_ : known_own_)
                .push_back(each);
    }

    [[nodiscard]] LaboratorySearchResult run() {
        fit_chains();
        explore();
        LaboratorySearchResult out;
        survey();
        predict();
        for (auto& [key, prediction] : predictions_)
            if (!visited_keys_.contains(key)) {
                prediction.log_evidence = expected(prediction);
                out.unvisited.push_back(std::move(prediction));
            }
        std::ranges::stable_sort(out.unvisited, std::greater{},
                                 &LaboratoryPrediction::log_evidence);
        out.stems = std::move(stems_);
        out.best = base_;
        out.visited = std::move(visited_);
        out.surveys = std::move(surveys_);
        out.noise = std::move(noise_);
        out.priors = std::move(priors_);
        return out;
    }

  private:
    using Changes = std::vector<Eigen::VectorXd>;

    void report(const std::string& next) const {
        if (options_.progress)
            options_.progress(next);
    }
    [[nodiscard]] const LaboratoryModel& base() const { return visited_[base_]; }
    [[nodiscard]] fit::FitOptions with(const run::Heartbeat& heartbeat) const {
        return with_heartbeat(options_.candidate, heartbeat);
    }
    [[nodiscard]] std::vector<double> costs() const {
        std::vector<double> costs;
        for (const Specimen& specimen : specimens_) {
            double readings = 0.0;
            for (const measure::Measurement& recording : specimen.recordings)
                readings += recording.times.back();
            costs.push_back(readings);
        }
        return costs;
    }
    [[nodiscard]] bool is_left_out(std::size_t stem) const { return !stems_[stem].failure.empty(); }

    /// Applies `work` to the stems for which `is_wanted`; other stems and lost ones have none.
    template <class Work>
    auto for_stems(const std::vector<bool>& is_wanted, const Work& work) const {
        using T = std::invoke_result_t<Work, std::size_t, const fit::FitOptions&>;
        std::vector<std::size_t> items;
        std::vector<double> all_costs = costs();
        std::vector<double> own_costs;
        for (std::size_t s = 0; s < is_wanted.size(); ++s)
            if (is_wanted[s]) {
                items.push_back(s);
                own_costs.push_back(all_costs[s]);
            }
        std::vector<std::optional<T>> found(is_wanted.size());
        std::vector<std::optional<T>> answers =
            options_.map.values(own_costs, [&](std::size_t item, const run::Heartbeat& heartbeat) {
                return work(items[item], with(heartbeat));
            });
        for (std::size_t k = 0; k < items.size(); ++k)
            found[items[k]] = std::move(answers[k]);
        return found;
    }

    // --- The published chain

    void fit_chains() {
        report(fmt::format("fitting the published chain to {} stems", specimens_.size()));
        const std::vector<bool> all(specimens_.size(), true);
        auto baselines = for_stems(all, [&](std::size_t s, const fit::FitOptions& options) {
            return baseline_of(specimens_[s], options);
        });
        for (std::size_t s = 0; s < specimens_.size(); ++s) {
            StemBaseline lost;
            lost.failure = "the rank that computed it was lost";
            stems_.push_back(
                observed_stem(specimens_[s], std::move(baselines[s]).value_or(std::move(lost))));
        }
        if (std::ranges::none_of(stems_, [](const auto& stem) { return stem.failure.empty(); }))
            throw core::NumericalError(core::FailureKind::FitFailed,
                                       "no stem can be fitted; the first one: " +
                                           stems_.front().failure);
        visit_chain();
    }

    void visit_chain() {
        shared_terms_ = shared_terms_of(stems_);
        visited_.clear();
        visited_keys_.clear();
        LaboratoryModel chain;
        chain.own.resize(stems_.size());
        for (const ObservedStem& stem : stems_)
            chain.stems.push_back({stem.chain, {}, {}});
        std::set<std::string> rigs;
        for (const Specimen& specimen : specimens_)
            if (!specimen.rig.empty())
                rigs.insert(specimen.rig);
        for (const std::string& rig : rigs)
            for (const physics::SelectedEffect& each : known_rig_)
                chain.rig_effects.push_back(with_default_values(each, rig));
        noise_.clear();
        for (const ObservedStem& stem : stems_)
            noise_.push_back(noise_as_assumed(stem.chain));
        fit(chain);
        if (chain.failed())
            throw core::NumericalError(core::FailureKind::FitFailed,
                                       "the model cannot be fitted: " + chain.failure);
        add_visited(std::move(chain));
        set_base(0);
    }

    [[nodiscard]] RigEffect with_default_values(const physics::SelectedEffect& effect,
                                                const std::string& rig) const {
        const auto on_rig = std::ranges::find(specimens_, rig, &Specimen::rig);
        RigEffect out{effect, rig, {}, true};
        const auto chain = fit::chain_of(on_rig->recordings.front(), options_.candidate.chain);
        out.values = physics::with_defaults(effect, chain.spec.stem).values;
        return out;
    }

    // --- Fits

    [[nodiscard]] StemEffects effects_of(const LaboratoryModel& model, std::size_t stem) const {
        StemEffects effects{{}, known_own_, model.own[stem], shared_terms_};
        for (const RigEffect& each : model.rig_effects)
            if (each.rig == specimens_[stem].rig)
                effects.rig.push_back(each);
        return effects;
    }

    /// Newton's method for the shared numbers, from the model's values. The stems' own numbers are
    /// fitted in every step, and follow the step linearly before that.
    void fit(LaboratoryModel& model, const std::set<std::size_t>& with_new_own = {}) {
        std::vector<bool> is_wanted(stems_.size(), false);
        for (std::size_t s = 0; s < stems_.size(); ++s)
            is_wanted[s] = !is_left_out(s);
        Changes changes(stems_.size());
        double reached = -std::numeric_limits<double>::infinity();
        for (int step = 0; step < most_newton_steps; ++step) {
            const bool is_first = step == 0;
            auto fits = for_stems(is_wanted, [&](std::size_t s, const fit::FitOptions& options) {
                const StemEffects effects = effects_of(model, s);
                if (is_first && with_new_own.contains(s))
                    return fit_stem_from_starts(stems_[s], effects, model.stems[s].fit, options);
                return fit_stem(stems_[s], effects, model.stems[s].fit, changes[s], options);
            });
            for (std::size_t s = 0; s < stems_.size(); ++s)
                if (is_wanted[s] &&
                    !take_fit(std::move(fits[s]), s, is_first && with_new_own.contains(s), model))
                    return;
            judge(model);
            const double size = step_size(model);
            if (model.rig_effects.empty() || size < small_step || step + 1 == most_newton_steps)
                break;
            // A step that made the model worse is the last one: the quadratic model is not valid.
            if (model.log_evidence < reached - 1.0 && step > 1)
                break;
            reached = std::max(reached, model.log_evidence);
            changes = take_step(model);
        }
    }

    /// Stores the fit of a stem; false if the model has failed. A stem in which its new effect
    /// ended absent, or could not be fitted, stays without it.
    bool take_fit(std::optional<StemFit> found, std::size_t stem, bool has_new_own,
                  LaboratoryModel& model) const {
        StemFit& mine = model.stems[stem];
        const bool is_without = has_new_own && found &&
                                (found->fit.failed() || !found->evidence.absent_effects.empty());
        if (is_without) {
            model.own[stem].pop_back();
            mine.fit.effects = effects_of(model, stem).all();
            return true;
        }
        if (found)
            mine = *std::move(found);
        mine.fit = fit::arrived(found ? std::optional(mine.fit) : std::nullopt,
                                effects_of(model, stem).all());
        if (mine.fit.failed())
            model.failure = fmt::format("{}: {}", specimens_[stem].name, mine.fit.reason);
        return !model.failed();
    }

    /// Squared Newton step of the effects' parameters, in standard deviations.
    [[nodiscard]] double step_size(const LaboratoryModel& model) const {
        double largest = 0.0;
        for_each_parameter(model, [&](const RigEffect& each, std::size_t k,
                                      const physics::EffectParameter& parameter, Eigen::Index at) {
            const double change =
                model.shared.at(at) - to_coordinate(parameter.fitted_as, each.values[k]);
            largest = std::max(largest, change * change * model.shared.hessian(at, at));
        });
        return largest;
    }

    /// Calls action(effect, index of the parameter, its card, index among the shared numbers).
    template <class Action>
    void for_each_parameter(const LaboratoryModel& model, const Action& action) const {
        for (const RigEffect& each : model.rig_effects) {
            const std::vector<physics::EffectParameter> parameters =
                each.effect.effect->parameters();
            for (std::size_t k = 0; k < parameters.size(); ++k) {
                const Eigen::Index at = model.shared.find(
                    shared_name({each.effect.effect->name(), parameters[k].name, {}}, each.rig));
                if (at >= 0)
                    action(each, k, parameters[k], at);
            }
        }
    }

    /// Moves the effects' values to the minimum; returns how the stems' own numbers follow.
    [[nodiscard]] Changes take_step(LaboratoryModel& model) const {
        Changes changes(stems_.size());
        for (std::size_t s = 0; s < stems_.size(); ++s) {
            const SharedBlock& block = model.stems[s].block;
            if (block.names.empty())
                continue;
            Eigen::VectorXd move = Eigen::VectorXd::Zero(block.size());
            for (Eigen::Index k = 0; k < block.size(); ++k) {
                const std::string& name = block.names[static_cast<std::size_t>(k)];
                if (name.find('.') != std::string::npos && priors_.contains(name))
                    move(k) = model.shared.at(model.shared.find(name)) -
                              block.at[static_cast<std::size_t>(k)];
            }
            const auto rows = static_cast<Eigen::Index>(block.follow.size()) /
                              std::max<Eigen::Index>(1, move.size());
            changes[s] =
                Eigen::Map<const Eigen::MatrixXd>(block.follow.data(), rows, move.size()) * move;
        }
        std::vector<RigEffect> moved = model.rig_effects;
        for_each_parameter(model, [&](const RigEffect& each, std::size_t k,
                                      const physics::EffectParameter& parameter, Eigen::Index at) {
            const double value = from_coordinate(parameter.fitted_as, model.shared.at(at));
            moved[static_cast<std::size_t>(&each - model.rig_effects.data())].values[k] =
                std::isfinite(value) ? value : parameter.upper; // a stiffness without compliance
        });
        model.rig_effects = std::move(moved);
        return changes;
    }

    // --- Evidence

    /// log Z = Σ_s [log L_s + log π(θ_s) + ½ d_θ log 2π − ½ log|H_θθ,s|] + log π(φ) + ½ d_φ log 2π
    /// − ½ log|H_φ|, with the stems' error terms that are shared counted once.
    void judge(LaboratoryModel& model) {
        std::vector<SharedBlock> blocks;
        std::vector<double> variances;
        for (std::size_t s = 0; s < stems_.size(); ++s) {
            blocks.push_back(model.stems[s].block);
            variances.push_back(noise_[s].mean_known());
        }
        add_priors(model);
        model.shared = minimum_of(blocks, variances, priors_);
        double sum = 0.0;
        std::map<std::string, std::size_t> present;
        std::string absent;
        for (std::size_t s = 0; s < stems_.size(); ++s) {
            if (is_left_out(s))
                continue;
            const StemFit& stem = model.stems[s];
            sum += log_evidence(stem.evidence, noise_[s]) -
                   static_cast<double>(stem.evidence.effects) * log_prior_odds() +
                   model.shared.stem_changes[s];
            for (std::size_t k = 0; k < blocks[s].names.size(); ++k)
                if (!priors_.contains(blocks[s].names[k])) // an error term
                    sum += 0.5 * blocks[s].at[k] * blocks[s].at[k];
            for (const physics::SelectedEffect& own : model.own[s])
                ++present[own.effect->name()];
            if (!stem.evidence.absent_effects.empty())
                absent = stem.evidence.absent_effects.front();
        }
        for (const auto& [name, count] : present)
            sum += log_prior_odds() + log_presence(count, fitted_stems());
        for (std::size_t k = 0; k < model.shared.names.size(); ++k)
            if (const double at = model.shared.at(static_cast<Eigen::Index>(k));
                !priors_.contains(model.shared.names[k]))
                sum -= 0.5 * at * at;
        for (const RigEffect& each : model.rig_effects)
            sum += each.is_known ? 0.0 : log_prior_odds();
        sum += log_volume(model);
        const bool is_absent = is_at_absence(model) || !absent.empty();
        model.log_evidence = is_absent ? -std::numeric_limits<double>::infinity() : sum;
    }

    [[nodiscard]] std::size_t fitted_stems() const {
        std::size_t count = 0;
        for (std::size_t s = 0; s < stems_.size(); ++s)
            count += is_left_out(s) ? 0 : 1;
        return count;
    }

    /// Prior density of the effects' parameters and the volume of their posterior.
    [[nodiscard]] double log_volume(const LaboratoryModel& model) const {
        std::vector<Eigen::Index> places;
        double sum = 0.0;
        for_each_parameter(model, [&](const RigEffect& each, std::size_t k,
                                      const physics::EffectParameter& parameter, Eigen::Index at) {
            if (each.is_known)
                return;
            places.push_back(at);
            sum += parameter_priors_.at(model.shared.names[static_cast<std::size_t>(at)])
                       .log_density(model.shared.at(at));
            static_cast<void>(k);
            static_cast<void>(parameter);
        });
        if (places.empty())
            return sum;
        const Eigen::VectorXd scale = model.shared.hessian.diagonal().cwiseSqrt().cwiseInverse();
        const Eigen::MatrixXd scaled =
            scale.asDiagonal() * model.shared.hessian * scale.asDiagonal();
        const Eigen::MatrixXd inverse =
            scaled.ldlt().solve(Eigen::MatrixXd::Identity(scaled.rows(), scaled.cols()));
        const Eigen::MatrixXd covariance = inverse(places, places);
        const Eigen::LDLT<Eigen::MatrixXd> factors(covariance);
        for (Eigen::Index k = 0; k < covariance.rows(); ++k)
            sum += 0.5 * std::log(std::max(factors.vectorD()(k), 1e-12)) +
                   std::log(scale(places[static_cast<std::size_t>(k)])) +
                   0.5 * std::log(2.0 * std::numbers::pi);
        return sum;
    }

    /// Did a size of an effect end where the effect is absent?
    [[nodiscard]] bool is_at_absence(const LaboratoryModel& model) const {
        std::map<const RigEffect*, bool> is_there;
        for_each_parameter(model, [&](const RigEffect& each, std::size_t /*k*/,
                                      const physics::EffectParameter& /*parameter*/,
                                      Eigen::Index at) {
            const ParameterPrior& prior =
                parameter_priors_.at(model.shared.names[static_cast<std::size_t>(at)]);
            const double deviation = std::abs(prior.deviation);
            if (!prior.is_place)
                is_there[&each] = is_there[&each] ||
                                  std::abs(model.shared.at(at) - prior.absent) > 1e-6 * deviation;
        });
        return std::ranges::any_of(is_there, [](const auto& entry) { return !entry.second; });
    }

    /// The common prior of the parameters of the model's effects: the mean of the stems' priors,
    /// whose usual sizes suit each stem; the bounds are those that suit all stems.
    void add_priors(const LaboratoryModel& model) {
        for (const RigEffect& each : model.rig_effects) {
            const std::vector<physics::EffectParameter> parameters =
                each.effect.effect->parameters();
            for (std::size_t k = 0; k < parameters.size(); ++k) {
                const std::string name =
                    shared_name({each.effect.effect->name(), parameters[k].name, {}}, each.rig);
                if (!parameters[k].calibrated || each.effect.fixed[k] || priors_.contains(name))
                    continue;
                add_prior(each, k, name);
            }
        }
    }

    void add_prior(const RigEffect& effect, std::size_t k, const std::string& name) {
        ParameterPrior mean;
        SharedPrior prior;
        double count = 0.0;
        double deviation = 0.0;
        for (std::size_t s = 0; s < stems_.size(); ++s) {
            if (is_left_out(s) || specimens_[s].rig != effect.rig)
                continue;
            fit::StemModel model =
                fit::models_of(stems_[s].chain, stems_[s].recordings, options_.candidate).front();
            physics::SelectedEffect free = effect.effect;
            model = candidate_model(model, {free}, stems_[s].recordings.front());
            const fit::FreeParameter parameter =
                fit::effect_parameter(*free.effect, model.spec.stem, k);
            mean = prior_of(parameter, model);
            deviation += mean.deviation;
            count += 1.0;
            const double one = to_coordinate(parameter.fitted_as, parameter.lower);
            const double other = to_coordinate(parameter.fitted_as, parameter.upper);
            prior.lower = std::max(prior.lower, std::min(one, other));
            prior.upper = std::min(prior.upper, std::max(one, other));
        }
        mean.deviation = deviation / count;
        prior.mean = mean.is_place ? 0.5 * (prior.lower + prior.upper) : mean.absent;
        prior.precision = mean.precision();
        if (mean.is_one_sided && !mean.is_place) // absent is a bound, also of an inverse
            (mean.deviation > 0.0 ? prior.lower : prior.upper) = mean.absent;
        parameter_priors_[name] = mean;
        priors_[name] = prior;
    }

    void add_visited(LaboratoryModel model) {
        if (!model.failed())
            visited_keys_.insert(key_of(model));
        visited_.push_back(std::move(model));
    }

    void set_base(std::size_t place) {
        base_ = place;
        surveys_.clear();
    }

    // --- Predictions

    void survey() {
        if (!surveys_.empty())
            return;
        report(fmt::format("computing the effects of {} candidates about {}",
                           options_.candidates.size(), name_of(base())));
        std::vector<bool> is_wanted(stems_.size(), false);
        for (std::size_t s = 0; s < stems_.size(); ++s)
            is_wanted[s] = !is_left_out(s);
        auto found = for_stems(is_wanted, [&](std::size_t s, const fit::FitOptions& options) {
            return survey_of(stems_[s], effects_of(base(), s), base().stems[s].fit,
                             !specimens_[s].rig.empty(), options_.candidates, options);
        });
        for (std::optional<StemSurvey>& each : found)
            surveys_.push_back(std::move(each).value_or(StemSurvey{}));
        noise_.clear();
        for (const StemFit& stem : base().stems)
            noise_.push_back(noise_scale_of(stem.fit));
        for (LaboratoryModel& model : visited_)
            if (!model.failed())
                judge(model);
    }

    [[nodiscard]] static std::string name_of(const LaboratoryModel& model) {
        const std::string key = key_of(model);
        return key.empty() ? "the published chain" : key;
    }

    void predict() {
        // About another model, sets of several effects were predicted across a larger misfit.
        std::erase_if(predictions_, [&](const auto& entry) {
            return entry.second.base != base_ && entry.second.rig_effects.size() > 1;
        });
        std::set<std::string> rigs;
        for (const Specimen& specimen : specimens_)
            if (!specimen.rig.empty())
                rigs.insert(specimen.rig);
        for (const std::string& rig : rigs)
            predict_rig(rig);
        predict_own();
    }

    [[nodiscard]] bool is_rough() const {
        double chi_squared = 0.0;
        double readings = 1.0;
        for (std::size_t s = 0; s < stems_.size(); ++s) {
            chi_squared += base().stems[s].fit.chi_squared;
            readings += static_cast<double>(base().stems[s].fit.readings);
        }
        return chi_squared > policy_.rough_misfit * readings;
    }

    /// The sums over the stems of a rig, with the numbers that are shared already eliminated.
    struct RigSums {
        std::vector<EffectColumns> columns; ///< (candidates)
        Eigen::MatrixXd gram;
        Eigen::VectorXd overlap;
        std::vector<std::vector<ParameterPrior>> priors; ///< (candidates)(parameters), common
    };

    [[nodiscard]] RigSums sums_of(const std::string& rig) const;
    void predict_rig(const std::string& rig);
    void predict_sets(const RigSums& sums, const LinearEvidence& linear, const std::string& rig,
                      std::size_t room, std::size_t from, std::vector<std::size_t>& set);
    [[nodiscard]] RigEffect estimated(const RigSums& sums, const std::string& rig,
                                      std::size_t candidate, std::size_t node,
                                      const std::vector<double>& amounts) const;

    void add_prediction(LaboratoryPrediction added) {
        added.base = base_;
        const std::string key = key_of(base(), added);
        if (!visited_keys_.contains(key))
            predictions_[key] = std::move(added);
    }

    void predict_own() {
        for (std::size_t c = 0; c < options_.candidates.size(); ++c) {
            std::vector<double> gains;
            std::vector<std::size_t> stems;
            for (std::size_t s = 0; s < stems_.size(); ++s)
                if (!is_left_out(s) && c < surveys_[s].own_gains.size()) {
                    gains.push_back(surveys_[s].own_gains[c] / policy_.temperature);
                    stems.push_back(s);
                }
            const Presence presence = presence_of(gains);
            LaboratoryPrediction added;
            added.own.push_back(options_.candidates[c]);
            for (std::size_t k = 0; k < stems.size(); ++k)
                if (presence.probability[k] > 0.5) {
                    added.stems.push_back(stems[k]);
                    added.gain += policy_.temperature * gains[k];
                }
            if (added.stems.empty())
                continue;
            added.gain += log_prior_odds() + log_presence(added.stems.size(), fitted_stems());
            add_prediction(std::move(added));
        }
    }

    // --- The search

    void explore() {
        while (visited_.size() < most_visited) {
            const auto likeliest =
                std::ranges::max_element(visited_, {}, &LaboratoryModel::log_evidence);
            if (const auto now = static_cast<std::size_t>(likeliest - visited_.begin());
                now != base_)
                set_base(now);
            if (visit_smaller())
                continue;
            survey();
            predict();
            const LaboratoryPrediction* next = nullptr;
            for (const auto& [key, each] : predictions_)
                if (!visited_keys_.contains(key) &&
                    (next == nullptr || expected(each) > expected(*next)))
                    next = &each;
            const double gain = next == nullptr ? -std::numeric_limits<double>::infinity()
                                                : expected(*next) - base().log_evidence;
            if (!(gain > 0.0) && estimate_noise_again())
                continue;
            if (!(gain > -policy_.unvisited_margin))
                return;
            visit(*next);
        }
    }

    void visit(const LaboratoryPrediction& added) {
        LaboratoryModel model = visited_[added.base];
        model.base = added.base;
        model.predicted_gain = added.gain;
        model.rig_effects.insert(model.rig_effects.end(), added.rig_effects.begin(),
                                 added.rig_effects.end());
        for (const std::size_t s : added.stems)
            model.own[s].insert(model.own[s].end(), added.own.begin(), added.own.end());
        fit_and_add(std::move(model), {added.stems.begin(), added.stems.end()});
    }

    void fit_and_add(LaboratoryModel model, const std::set<std::size_t>& with_new_own = {}) {
        report(fmt::format("fitting {}", name_of(model)));
        const std::string key = key_of(model);
        fit(model, with_new_own);
        if (!model.failed() && key_of(model) != key)
            model.failure = "the effect is absent from every stem";
        if (model.failed())
            model.log_evidence = -std::numeric_limits<double>::infinity();
        visited_keys_.insert(key);
        add_visited(std::move(model));
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
                if (is_form_of(candidate, name) && share(candidate, name, model) &&
                    fit_smaller(std::move(model)))
                    return true;
        }
        return false;
    }

    /// Is the candidate an effect of rigs of this name, or a law that the law of this name
    /// contains?
    [[nodiscard]] bool is_form_of(const physics::SelectedEffect& candidate,
                                  const std::string& name) const {
        if (candidate.effect->belongs_to() != physics::BelongsTo::Rig)
            return false;
        return candidate.effect->name() == name ||
               std::ranges::any_of(options_.candidates, [&](const auto& general) {
                   return general.effect->name() == name &&
                          std::ranges::any_of(general.effect->special_cases(),
                                              [&](const auto& one) {
                                                  return one.effect == candidate.effect->name();
                                              });
               });
    }

    /// Adds the effect to every rig on which stems have `name` as their own effect; false if there
    /// is no such rig. A size starts from the mean of the stems' values.
    [[nodiscard]] bool share(const physics::SelectedEffect& effect, const std::string& name,
                             LaboratoryModel& model) const {
        std::set<std::string> rigs;
        for (std::size_t s = 0; s < stems_.size(); ++s)
            if (!specimens_[s].rig.empty() &&
                std::ranges::any_of(base().own[s],
                                    [&](const auto& each) { return each.effect->name() == name; }))
                rigs.insert(specimens_[s].rig);
        for (const std::string& rig : rigs) {
            RigEffect added = with_default_values(effect, rig);
            added.is_known = false;
            const std::vector<physics::EffectParameter> parameters = effect.effect->parameters();
            for (std::size_t k = 0; k < parameters.size(); ++k) {
                double sum = 0.0;
                double count = 0.0;
                for (std::size_t s = 0; s < stems_.size(); ++s)
                    for (const fit::FittedParameter& each : base().stems[s].fit.parameters)
                        if (specimens_[s].rig == rig && each.id.effect == name &&
                            each.id.name == parameters[k].name) {
                            sum += to_coordinate(each.fitted_as, each.value);
                            count += 1.0;
                        }
                if (count > 0.0)
                    added.values[k] = from_coordinate(parameters[k].fitted_as, sum / count);
            }
            model.rig_effects.push_back(std::move(added));
        }
        return !rigs.empty();
    }

    bool fit_smaller(LaboratoryModel model) {
        if (visited_keys_.contains(key_of(model)))
            return false;
        model.predicted_gain = 0.0;
        fit_and_add(std::move(model));
        return true;
    }

    // --- Noise about the best model

    bool estimate_noise_again() {
        if (noise_estimates_ == most_noise_estimates || base_ == 0 || is_rough())
            return false;
        ++noise_estimates_;
        report("estimating the noise about the best model");
        std::vector<bool> is_wanted(stems_.size(), false);
        for (std::size_t s = 0; s < stems_.size(); ++s)
            is_wanted[s] = !is_left_out(s);
        auto found = for_stems(is_wanted, [&](std::size_t s, const fit::FitOptions& options) {
            return baseline_beside_noise_of(base().stems[s].fit, specimens_[s], stems_[s], options);
        });
        bool is_other = false;
        for (std::size_t s = 0; s < stems_.size(); ++s)
            if (found[s] && *found[s]) {
                stems_[s] = observed_stem(specimens_[s], **std::move(found[s]));
                is_other = true;
            }
        if (!is_other)
            return false;
        LaboratoryModel best = base();
        predictions_.clear();
        visit_chain();
        fit_and_add(std::move(best));
        return true;
    }

    std::span<const Specimen> specimens_;
    const SearchOptions& options_;
    const Policy& policy_;
    fit::SelectedEffects known_rig_;
    fit::SelectedEffects known_own_;
    std::vector<ObservedStem> stems_;
    std::vector<std::string> shared_terms_;
    std::vector<NoiseScale> noise_; ///< (stems)
    std::vector<LaboratoryModel> visited_;
    std::set<std::string> visited_keys_;
    std::size_t base_ = 0;
    std::vector<StemSurvey> surveys_;
    std::map<std::string, LaboratoryPrediction> predictions_;
    std::map<std::string, SharedPrior> priors_;
    std::map<std::string, ParameterPrior> parameter_priors_;
    std::size_t noise_estimates_ = 0;
};

/// Columns of all nodes of some candidates.
Eigen::Index count_of(const std::vector<EffectColumns>& candidates) {
    Eigen::Index count = 0;
    for (const EffectColumns& each : candidates)
        for (const EffectNode& node : each.nodes)
            count += static_cast<Eigen::Index>(node.columns.size());
    return count;
}

/// Have two stems the same points of the grid, with columns for the same sizes?
bool has_same_columns(const EffectColumns& one, const EffectColumns& other) {
    return std::ranges::equal(one.nodes, other.nodes, [](const auto& a, const auto& b) {
        return std::ranges::equal(a.columns, b.columns, [](const auto& left, const auto& right) {
            return left.parameter == right.parameter && left.is_certain == right.is_certain &&
                   (left.secant == 0.0) == (right.secant == 0.0);
        });
    });
}

LaboratorySearch::RigSums LaboratorySearch::sums_of(const std::string& rig) const {
    RigSums sums;
    std::vector<std::size_t> stems;
    for (std::size_t s = 0; s < stems_.size(); ++s)
        if (specimens_[s].rig == rig && !surveys_[s].rig_columns.empty())
            stems.push_back(s);
    for (std::size_t c = 0; c < options_.candidates.size(); ++c) {
        EffectColumns common{"no stem shows it", {}};
        std::vector<ParameterPrior> priors;
        double count = 0.0;
        for (const std::size_t s : stems) {
            const StemSurvey& survey = surveys_[s];
            if (!survey.rig_columns[c].failure.empty() ||
                (count > 0.0 && !has_same_columns(common, survey.rig_columns[c])))
                continue;
            if (count == 0.0) {
                common = survey.rig_columns[c];
                priors = survey.priors[c];
            } else {
                for (std::size_t k = 0; k < priors.size(); ++k)
                    priors[k].deviation += survey.priors[c][k].deviation;
                for (std::size_t n = 0; n < common.nodes.size(); ++n)
                    for (std::size_t k = 0; k < priors.size(); ++k)
                        common.nodes[n].values[k] += survey.rig_columns[c].nodes[n].values[k];
            }
            count += 1.0;
        }
        for (ParameterPrior& prior : priors)
            prior.deviation /= count;
        for (EffectNode& node : common.nodes)
            for (double& value : node.values)
                value /= count;
        sums.columns.push_back(std::move(common));
        sums.priors.push_back(std::move(priors));
    }
    const Eigen::Index columns = count_of(sums.columns);
    const auto shared = static_cast<Eigen::Index>(base().shared.names.size());
    Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(columns + shared, columns + shared);
    Eigen::VectorXd overlap = Eigen::VectorXd::Zero(columns + shared);
    gram.bottomRightCorner(shared, shared) = base().shared.hessian;
    for (const std::size_t s : stems) {
        const StemSurvey& survey = surveys_[s];
        const auto own = static_cast<Eigen::Index>(survey.overlap.size());
        const Eigen::Map<const Eigen::MatrixXd> own_gram(survey.gram.data(), own, own);
        const Eigen::Map<const Eigen::VectorXd> own_overlap(survey.overlap.data(), own);
        std::vector<Eigen::Index> from;
        std::vector<Eigen::Index> to;
        std::vector<double> factors;
        Eigen::Index first = 0;
        Eigen::Index place = 0;
        for (std::size_t c = 0; c < options_.candidates.size(); ++c) {
            const EffectColumns& mine = survey.rig_columns[c];
            const bool is_same = mine.failure.empty() && has_same_columns(sums.columns[c], mine);
            Eigen::Index at = place;
            for (const EffectNode& node : mine.nodes)
                for (const EffectColumn& column : node.columns) {
                    if (is_same) {
                        const bool has_size = column.parameter < sums.priors[c].size();
                        from.push_back(first);
                        to.push_back(at++);
                        factors.push_back(has_size
                                              ? sums.priors[c][column.parameter].deviation /
                                                    survey.priors[c][column.parameter].deviation
                                              : 1.0);
                    }
                    ++first;
                }
            place += count_of({sums.columns[c]});
        }
        // The overlaps at the common values of the numbers that are shared already.
        Eigen::VectorXd here = own_overlap;
        for (std::size_t k = 0; k < survey.shared.size(); ++k) {
            const Eigen::Index at = base().shared.find(survey.shared[k]);
            const auto column = first + static_cast<Eigen::Index>(k);
            here -= own_gram.col(column) * (base().shared.at(at) - survey.shared_at[k]);
            from.push_back(column);
            to.push_back(columns + at);
            factors.push_back(1.0);
        }
        const Eigen::Map<const Eigen::VectorXd> factor(factors.data(),
                                                       static_cast<Eigen::Index>(factors.size()));
        const Eigen::MatrixXd scaled =
            factor.asDiagonal() * own_gram(from, from) * factor.asDiagonal();
        const Eigen::VectorXd scaled_overlap = factor.asDiagonal() * here(from);
        for (std::size_t i = 0; i < to.size(); ++i) {
            const auto row = static_cast<Eigen::Index>(i);
            if (to[i] < columns)
                overlap(to[i]) += scaled_overlap(row);
            for (std::size_t j = 0; j < to.size(); ++j)
                if (to[i] < columns || to[j] < columns) // the Hessian of the shared ones is there
                    gram(to[i], to[j]) += scaled(row, static_cast<Eigen::Index>(j));
        }
    }
    sums.gram = gram.topLeftCorner(columns, columns);
    sums.overlap = overlap.head(columns);
    if (shared > 0) {
        const Eigen::VectorXd scale = base().shared.hessian.diagonal().cwiseSqrt().cwiseInverse();
        const Eigen::LDLT<Eigen::MatrixXd> factors(scale.asDiagonal() * base().shared.hessian *
                                                   scale.asDiagonal());
        const Eigen::MatrixXd across = scale.asDiagonal() * gram.bottomLeftCorner(shared, columns);
        sums.gram -= across.transpose() * factors.solve(across);
    }
    return sums;
}

void LaboratorySearch::predict_rig(const std::string& rig) {
    const RigSums sums = sums_of(rig);
    const LinearEvidence linear(sums.columns, sums.gram, sums.overlap);
    const auto added = static_cast<std::size_t>(
        std::ranges::count_if(base().rig_effects, [&](const RigEffect& each) {
            return each.rig == rig && !each.is_known;
        }));
    std::size_t room = options_.most_effects > added ? options_.most_effects - added : 0;
    if (is_rough())
        room = std::min<std::size_t>(room, 1);
    std::vector<std::size_t> set;
    predict_sets(sums, linear, rig, room, 0, set);
}

void LaboratorySearch::predict_sets(const RigSums& sums, const LinearEvidence& linear,
                                    const std::string& rig, std::size_t room, std::size_t from,
                                    std::vector<std::size_t>& set) {
    if (set.size() == room)
        return;
    for (std::size_t c = from; c < sums.columns.size(); ++c) {
        if (!sums.columns[c].failure.empty())
            continue;
        set.push_back(c);
        fit::SelectedEffects together;
        for (const std::size_t each : set)
            together.push_back(options_.candidates[each]);
        if (can_be_combined(together)) {
            const PredictedGain gain = linear.gain(set);
            if (std::isfinite(gain.log_evidence)) {
                LaboratoryPrediction added;
                for (std::size_t e = 0; e < set.size(); ++e)
                    added.rig_effects.push_back(
                        estimated(sums, rig, set[e], gain.nodes[e], gain.amounts[e]));
                added.gain = gain.log_evidence;
                add_prediction(std::move(added));
            }
            predict_sets(sums, linear, rig, room, c + 1, set);
        }
        set.pop_back();
    }
}

/// The effect with the values of the linear estimate.
RigEffect LaboratorySearch::estimated(const RigSums& sums, const std::string& rig,
                                      std::size_t candidate, std::size_t node_index,
                                      const std::vector<double>& amounts) const {
    const EffectNode& node = sums.columns[candidate].nodes[node_index];
    RigEffect out = with_default_values(options_.candidates[candidate], rig);
    out.is_known = false;
    const std::vector<physics::EffectParameter> parameters = out.effect.effect->parameters();
    std::size_t free = 0;
    for (std::size_t k = 0; k < parameters.size(); ++k) {
        if (!parameters[k].calibrated || out.effect.fixed[k])
            continue;
        out.values[k] = node.values[free];
        const ParameterPrior& prior = sums.priors[candidate][free];
        if (!prior.is_place)
            for (std::size_t c = 0; c < node.columns.size(); ++c)
                if (node.columns[c].parameter == free) {
                    const double value = from_coordinate(
                        parameters[k].fitted_as, prior.absent + amounts[c] * prior.deviation);
                    out.values[k] = std::isfinite(value) ? std::clamp(value, parameters[k].lower,
                                                                      parameters[k].upper)
                                                         : parameters[k].upper;
                }
        ++free;
    }
    return out;
}

} // namespace

double log_presence(std::size_t with_effect, std::size_t stems) {
    const auto m = static_cast<double>(with_effect);
    const auto n = static_cast<double>(stems);
    return std::lgamma(m + 1.0) + std::lgamma(n - m + 1.0) - std::lgamma(n + 2.0);
}

Presence presence_of(std::span<const double> gains) {
    constexpr int iterations = 50;
    Presence out;
    out.probability.assign(gains.size(), 0.5);
    double share = 0.5;
    for (int k = 0; k < iterations; ++k) {
        double sum = 0.0;
        for (std::size_t s = 0; s < gains.size(); ++s) {
            const double odds =
                std::exp(std::clamp(gains[s], -500.0, 500.0)) * share / (1.0 - share);
            out.probability[s] =
                std::isfinite(gains[s]) || gains[s] > 0.0 ? odds / (1.0 + odds) : 0.0;
            sum += out.probability[s];
        }
        share = (1.0 + sum) / (2.0 + static_cast<double>(gains.size()));
    }
    return out;
}

LaboratorySearchResult search_laboratory(std::span<const Specimen> specimens,
                                         const SearchOptions& options, const Policy& policy) {
    return LaboratorySearch(specimens, options, policy).run();
}

} // namespace culm::diagnose
