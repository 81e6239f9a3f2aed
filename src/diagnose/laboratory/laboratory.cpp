// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/laboratory/laboratory.hpp"

#include "core/order_statistics.hpp"
#include "reduce/distributions.hpp"
#include "reduce/population_statistics.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>
#include <set>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace culm::diagnose {
namespace {

/// An effect that is less probable is not listed.
constexpr double least_probability = 0.05;

StemNumbers numbers_of_stem(const fit::Fit& fit) {
    StemNumbers out;
    out.rmse = fit.rmse;
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

double over_noise(const fit::Fit& fit) {
    return std::sqrt(fit.chi_squared / static_cast<double>(std::max<std::size_t>(fit.readings, 1)));
}

/// Adds the uncertainty of the shared numbers, which the stem's own numbers follow.
void add_shared_uncertainty(const StemFit& stem, const SharedMinimum& shared,
                            const Eigen::MatrixXd& covariance,
                            const std::map<std::string, SharedPrior>& priors,
                            StemNumbers& numbers) {
    const SharedBlock& block = stem.block;
    if (block.names.empty())
        return;
    const auto rows = static_cast<Eigen::Index>(block.follow.size()) / block.size();
    const Eigen::Map<const Eigen::MatrixXd> follow(block.follow.data(), rows, block.size());
    std::vector<Eigen::Index> effects; // the error terms are in the budget already
    std::vector<Eigen::Index> places;
    for (Eigen::Index k = 0; k < block.size(); ++k)
        if (priors.contains(block.names[static_cast<std::size_t>(k)])) {
            effects.push_back(k);
            places.push_back(shared.find(block.names[static_cast<std::size_t>(k)]));
        }
    const Eigen::MatrixXd own = covariance(places, places);
    for (std::size_t k = 0; k < stem.fit.parameters.size(); ++k) {
        const auto row = static_cast<Eigen::Index>(k);
        if (row >= rows)
            break;
        const Eigen::VectorXd by = follow.row(row)(effects).transpose();
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

Population population_of(const std::vector<StemAnswer>& stems, StemNumbers StemAnswer::*numbers) {
    std::vector<double> moduli;
    std::vector<double> dampings;
    for (const StemAnswer& stem : stems)
        if (stem.failure.empty()) {
            moduli.push_back((stem.*numbers).youngs_modulus);
            dampings.push_back((stem.*numbers).damping);
        }
    const reduce::SampleSummary modulus = reduce::summarise(moduli);
    const reduce::SampleSummary damping = reduce::summarise(dampings);
    return {modulus.mean, modulus.standard_deviation, damping.mean, damping.standard_deviation,
            reduce::fit_line(moduli, dampings).correlation};
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

class LaboratoryAnswer {
  public:
    LaboratoryAnswer(std::span<const Specimen> specimens, const DiagnosisOptions& options)
        : specimens_(specimens), options_(options), search_(search_laboratory(specimens, options)) {
    }

    [[nodiscard]] Laboratory answer() {
        weigh_models();
        add_rig_effects();
        add_own_effects();
        add_limits();
        conclude();
        add_stems();
        return std::move(out_);
    }

  private:
    [[nodiscard]] const LaboratoryModel& best() const { return search_.visited[search_.best]; }
    /// The model whose numbers are the answer: if nothing certain is missing, the published chain.
    [[nodiscard]] const LaboratoryModel& answered() const {
        return out_.conclusion == Conclusion::Adequate ? search_.visited.front() : best();
    }

    using Key = EffectOwners::value_type;

    /// P ∝ Z over the fitted models and the predictions of the others.
    void weigh_models() {
        std::vector<std::pair<double, EffectOwners>> models;
        for (const LaboratoryModel& model : search_.visited)
            if (std::isfinite(model.log_evidence)) {
                models.emplace_back(model.log_evidence, owners_of(model));
                is_possible_.push_back(&model);
            }
        for (const LaboratoryPrediction& each : search_.unvisited) {
            models.emplace_back(each.log_evidence, owners_of(each, search_.visited[each.base]));
            out_.largest_unvisited =
                std::max(out_.largest_unvisited, each.log_evidence - best().log_evidence);
        }
        double sum = 0.0;
        for (const auto& [log_evidence, effects] : models)
            sum += std::exp(log_evidence - best().log_evidence);
        for (const auto& [log_evidence, effects] : models) {
            const double probability = std::exp(log_evidence - best().log_evidence) / sum;
            std::set<std::pair<physics::Family, std::string>> families;
            for (const Key& key : effects) {
                probability_[key] += probability;
                families.emplace(family_of(key.first), key.second);
            }
            for (const auto& family : families)
                family_probability_[family] += probability;
            if (effects == owners_of(search_.visited.front()))
                chain_probability_ += probability;
        }
        std::ranges::stable_sort(is_possible_, std::greater{},
                                 [](const LaboratoryModel* each) { return each->log_evidence; });
        for (const LaboratoryModel* each : is_possible_) {
            out_.models.push_back(name_of(owners_of(*each)));
            out_.log_evidence.push_back(each->log_evidence - search_.visited.front().log_evidence);
        }
    }

    [[nodiscard]] physics::Family family_of(const std::string& effect) const {
        for (const fit::SelectedEffects* effects : {&options_.candidates, &options_.known})
            for (const physics::SelectedEffect& each : *effects)
                if (each.effect->name() == effect)
                    return each.effect->family();
        return physics::Family::Own;
    }

    void add_rig_effects() {
        for (const RigEffect& each : best().rig_effects) {
            RigAnswer& added = add_rig_effect({each.effect.effect->name(), each.rig});
            added.is_known = each.is_known;
            added.values = values_of(each);
        }
        for (const auto& [key, probability] : probability_)
            if (!key.second.empty() && probability > least_probability &&
                std::ranges::none_of(out_.effects, [&](const RigAnswer& each) {
                    return each.effect == key.first && each.rig == key.second;
                }))
                add_rig_effect(key);
    }

    RigAnswer& add_rig_effect(const Key& key) {
        const physics::Family family = family_of(key.first);
        const auto of_family = family_probability_.find({family, key.second});
        RigAnswer& added = out_.effects.emplace_back();
        added.effect = key.first;
        added.rig = key.second;
        added.probability = probability_[key];
        added.family = to_string(family);
        added.family_probability =
            of_family == family_probability_.end() ? added.probability : of_family->second;
        add_power(key, added);
        return added;
    }

    /// The log odds grow with the number of stems, as far as they come from the readings.
    void add_power(const Key& key, RigAnswer& added) const {
        const LaboratoryModel* with = nullptr;
        const LaboratoryModel* without = nullptr;
        for (const LaboratoryModel* each : is_possible_) {
            const LaboratoryModel*& first = owners_of(*each).contains(key) ? with : without;
            if (first == nullptr)
                first = each;
        }
        if (with == nullptr || without == nullptr)
            return;
        double of_readings = 0.0;
        double stems = 0.0;
        for (std::size_t s = 0; s < with->stems.size(); ++s)
            if (specimens_[s].rig == key.second && search_.stems[s].failure.empty()) {
                of_readings += log_evidence(with->stems[s].evidence, search_.noise[s]) -
                               log_evidence(without->stems[s].evidence, search_.noise[s]);
                stems += 1.0;
            }
        const double held = options_.policy.held_probability;
        const double wanted = std::log(held / (1.0 - held));
        const double log_odds = with->log_evidence - without->log_evidence;
        const double per_stem = of_readings / stems;
        added.log_odds = log_odds;
        added.log_odds_per_stem = per_stem;
        if (log_odds < wanted && per_stem > 0.0)
            added.stems_needed = std::ceil((wanted - log_odds) / per_stem);
    }

    [[nodiscard]] std::vector<SharedValue> values_of(const RigEffect& effect) const {
        std::vector<SharedValue> values;
        const SharedMinimum& shared = best().shared;
        const Eigen::MatrixXd covariance = shared.covariance();
        for (const physics::EffectParameter& each : effect.effect.effect->parameters()) {
            const Eigen::Index at = shared.find(effect.shared_name(each.name));
            if (at < 0)
                continue;
            const double half = reduce::normal_quantile_95 * std::sqrt(covariance(at, at));
            const SharedPrior& prior =
                search_.priors.at(shared.names[static_cast<std::size_t>(at)]);
            const double one =
                fit::from_coordinate(each.fitted_as, std::max(shared.at(at) - half, prior.lower));
            const double other =
                fit::from_coordinate(each.fitted_as, std::min(shared.at(at) + half, prior.upper));
            values.push_back({each.name, each.unit,
                              fit::from_coordinate(each.fitted_as, shared.at(at)),
                              std::min(one, other), std::max(one, other)});
        }
        return values;
    }

    void add_own_effects() {
        std::map<std::string, std::vector<std::string>> stems;
        for (std::size_t s = 0; s < specimens_.size(); ++s)
            for (const physics::SelectedEffect& each : best().own[s])
                stems[each.effect->name()].push_back(specimens_[s].name);
        for (auto& [effect, names] : stems)
            out_.own.push_back({effect, probability_[{effect, ""}], std::move(names)});
    }

    /// 3 standard deviations of a size where the effect is absent, from the columns of the search.
    void add_limits() {
        for (std::size_t c = 0; c < options_.candidates.size(); ++c) {
            std::map<std::string, std::vector<double>> information; // (rigs)(stems)
            SizeInformation size;
            for (std::size_t s = 0; s < specimens_.size(); ++s)
                if (std::optional<SizeInformation> own = information_of(c, s)) {
                    information[specimens_[s].rig].push_back(own->information);
                    size = *std::move(own);
                }
            const auto value = [&](double information_in_all) {
                const double deviation = 3.0 / std::sqrt(information_in_all);
                return fit::from_coordinate(size.card.fitted_as,
                                            size.prior.absent +
                                                std::copysign(deviation, size.prior.deviation));
            };
            for (const auto& [rig, stems] : information)
                out_.limits.push_back({options_.candidates[c].effect->name(), rig, size.card.name,
                                       size.card.unit, value(core::median(stems)),
                                       value(std::accumulate(stems.begin(), stems.end(), 0.0))});
        }
    }

    /// What a stem shows of a candidate's size, per coordinate, with the shared numbers known.
    struct SizeInformation {
        double information = 0.0;
        ParameterPrior prior;
        physics::EffectParameter card;
    };

    /// Of the first size of a candidate of the rig.
    [[nodiscard]] std::optional<SizeInformation> information_of(std::size_t candidate,
                                                                std::size_t stem) const {
        const StemSurvey& survey = search_.surveys[stem];
        if (survey.rig_columns.empty() || !survey.rig_columns[candidate].failure.empty())
            return std::nullopt;
        Eigen::Index column = 0;
        for (std::size_t c = 0; c < candidate; ++c)
            column += survey.rig_columns[c].column_count();
        const auto count = static_cast<Eigen::Index>(survey.overlap.size());
        const Eigen::Map<const Eigen::MatrixXd> gram(survey.gram.data(), count, count);
        for (const EffectNode& node : survey.rig_columns[candidate].nodes)
            for (const EffectColumn& each : node.columns) {
                if (each.parameter < survey.priors[candidate].size() &&
                    gram(column, column) > 0.0) {
                    const ParameterPrior& prior = survey.priors[candidate][each.parameter];
                    const physics::SelectedEffect& effect = options_.candidates[candidate];
                    return SizeInformation{
                        gram(column, column) / (prior.deviation * prior.deviation), prior,
                        effect.effect->parameters()[free_parameters(effect)[each.parameter]]};
                }
                ++column;
            }
        return std::nullopt;
    }

    // --- Stems

    void add_stems() {
        options_.report("testing all stems");
        const Eigen::MatrixXd covariance = answered().shared.covariance();
        std::vector<double> costs(specimens_.size(), 1.0);
        std::vector<StemAnswer> answers =
            options_.map.values(costs, [&](std::size_t s, const run::Heartbeat& heartbeat) {
                return stem_answer(s, with_heartbeat(options_.candidate, heartbeat));
            });
        for (std::size_t s = 0; s < answers.size(); ++s) {
            StemAnswer& stem = out_.stems.emplace_back(std::move(answers[s]));
            stem.name = specimens_[s].name;
            stem.rig = specimens_[s].rig;
            for (const physics::SelectedEffect& each : answered().own[s])
                stem.own.push_back(each.effect->name());
            if (stem.failure.empty())
                add_shared_uncertainty(answered().stems[s], answered().shared, covariance,
                                       search_.priors, stem.after);
        }
        conclude_from_residuals();
        out_.before = population_of(out_.stems, &StemAnswer::before);
        out_.after = population_of(out_.stems, &StemAnswer::after);
        add_distances(out_.stems, &StemNumbers::youngs_modulus,
                      &StemAnswer::youngs_modulus_distance);
        add_distances(out_.stems, &StemNumbers::damping, &StemAnswer::damping_distance);
    }

    [[nodiscard]] StemAnswer stem_answer(std::size_t s, const fit::FitOptions& options) const {
        StemAnswer out;
        const ObservedStem& stem = search_.stems[s];
        out.failure = stem.failure;
        if (!out.failure.empty())
            return out;
        const fit::Fit fit = fit::rerun(answered().stems[s].fit, stem.recordings, options);
        out.before = numbers_of_stem(stem.chain);
        out.over_noise_before = over_noise(stem.chain);
        out.after = numbers_of_stem(fit);
        out.over_noise = over_noise(fit);
        const SetVerdict verdict = verdict_on(fit, stem.recordings, options_.policy);
        out.finding = has_structure(fit, stem.recordings, options_.policy) ? verdict.finding
                                                                           : Finding::Adequate;
        out.tests = verdict.reason;
        for (const fit::FittedParameter& each : fit.parameters)
            if (each.id.is_of_effect())
                out.own_values.push_back(each);
        return out;
    }

    // --- Verdict

    void conclude() {
        const double held = options_.policy.held_probability;
        std::set<std::string> certain;
        bool is_open = false;
        for (const RigAnswer& each : out_.effects) {
            if (each.is_known)
                continue;
            if (each.probability >= held)
                certain.insert(each.effect);
            else if (each.family_probability < held)
                is_open = is_open || each.family_probability > 1.0 - held;
            else if (std::ranges::none_of(out_.effects, [&](const RigAnswer& other) {
                         return other.family == each.family && other.rig == each.rig &&
                                (other.is_known || other.probability >= held);
                     }))
                certain.insert("an effect of " + each.family);
        }
        for (const OwnAnswer& each : out_.own) {
            if (each.probability >= held)
                certain.insert(each.effect + " of stems");
            is_open = is_open || each.probability < held;
        }
        if (!certain.empty()) {
            out_.conclusion = Conclusion::Effect;
            out_.reason = fmt::format(
                "{} {} missing from the published chain{}", fmt::join(certain, " and "),
                certain.size() == 1 ? "is" : "are", is_open ? "; other effects are possible" : "");
        } else if (chain_probability_ >= held) {
            out_.conclusion = Conclusion::Adequate;
            out_.reason = fmt::format("the published chain explains the stems (probability {:.2f})",
                                      chain_probability_);
        } else {
            out_.conclusion = Conclusion::Tie;
            out_.reason = chain_probability_ > 1.0 - held
                              ? fmt::format("the published chain is among the possible "
                                            "explanations (probability {:.2f})",
                                            chain_probability_)
                              : std::string("something is missing from the published chain, and "
                                            "no single effect is certain");
        }
    }

    /// Most stems are not explained: no answer is.
    void conclude_from_residuals() {
        const auto unexplained = std::ranges::count_if(out_.stems, [](const StemAnswer& stem) {
            return stem.failure.empty() && stem.finding == Finding::Inadequate;
        });
        const auto fitted = std::ranges::count_if(
            out_.stems, [](const StemAnswer& stem) { return stem.failure.empty(); });
        if (2 * unexplained <= fitted)
            return;
        out_.conclusion = Conclusion::Unknown;
        out_.reason = fmt::format("the residuals of {} of {} stems have structure that no model "
                                  "explains; in the best one {}",
                                  unexplained, fitted, out_.reason);
    }

    std::span<const Specimen> specimens_;
    const DiagnosisOptions& options_;
    LaboratorySearchResult search_;
    std::map<Key, double> probability_;
    std::map<std::pair<physics::Family, std::string>, double> family_probability_;
    double chain_probability_ = 0.0;
    std::vector<const LaboratoryModel*> is_possible_; ///< fitted, the likeliest first
    Laboratory out_;
};

} // namespace

Laboratory diagnose_laboratory(std::span<const Specimen> specimens,
                               const DiagnosisOptions& options) {
    return LaboratoryAnswer(specimens, options).answer();
}

} // namespace culm::diagnose
