// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/search/search.hpp"

#include "core/error.hpp"
#include "diagnose/adequacy.hpp"
#include "diagnose/evidence/estimated_starts.hpp"
#include "diagnose/search/prediction.hpp"
#include "fit/fit_numbers.hpp"
#include "fit/start/starts.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <set>
#include <utility>

#include <fmt/core.h>
#include <fmt/ranges.h>

namespace culm::diagnose {
namespace {

/// Number of models fitted concurrently; two keep two ranks busy.
constexpr std::size_t models_per_round = 2;
/// The search ends after this number of models; the rest is recorded.
constexpr std::size_t most_visited = 40;
constexpr int most_noise_estimates = 2;

std::vector<NoiseScale> noise_about(const Model& best) {
    std::vector<NoiseScale> noise;
    for (const StemFit& stem : best.stems)
        noise.push_back(noise_scale_of(stem.fit));
    return noise;
}

/// Mean over the readings of the stems.
double mean_of(const std::vector<NoiseScale>& noise, const Model& model) {
    double sum = 0.0;
    for (std::size_t s = 0; s < noise.size(); ++s)
        sum += noise[s].mean_known() * static_cast<double>(model.stems[s].fit.readings);
    return sum / std::max(1.0, model.readings());
}

class Search {
  public:
    Search(std::span<const Specimen> specimens, const DiagnosisOptions& options)
        : options_(options), owned_stems_(std::make_shared<Stems>(specimens, options)),
          stems_(*owned_stems_), fits_(stems_) {
        visit_chain();
    }

    [[nodiscard]] SearchResult run() {
        explore();
        predict();
        SearchResult out{owned_stems_, {}, {}, base_, fits_, {}, batches_, is_complete_};
        for (auto& [key, prediction] : predictions_)
            if (std::isfinite(prediction.log_evidence) && !is_visited(prediction.effects))
                out.unvisited.push_back(std::move(prediction));
        std::ranges::stable_sort(out.unvisited, std::greater{}, &UnvisitedModel::log_evidence);
        out.visited = std::move(visited_);
        out.about = std::move(about_);
        judge_about_best(out);
        return out;
    }

  private:
    [[nodiscard]] const Model& base() const { return visited_[base_]; }

    // --- Fits

    void visit_chain() {
        visited_.clear();
        PlannedModel chain;
        for (std::size_t s = 0; s < stems_.size(); ++s)
            chain.model.stems.push_back({stems_[s].chain, {}, {}, {}});
        fits_.set_noise(noise_of_search(stems_, chain.model));
        add_known(chain.model);
        for (const std::size_t s : stems_.fitted())
            chain.starts[s] = chain.model.effects_of(s, stems_).sharing.rig_of.empty()
                                  ? StemStart{&stems_[s].chain, {}}
                                  : StemStart{};
        std::vector<PlannedModel> planned{std::move(chain)};
        fits_.fit(planned);
        Model& model = planned.front().model;
        if (model.failed())
            throw core::NumericalError(core::FailureKind::FitFailed,
                                       "the model cannot be fitted: " + model.failure);
        batches_ += model.batches();
        visited_.push_back(std::move(model));
        set_base(0);
    }

    void add_known(Model& model) const {
        for (const physics::SelectedEffect& each : options_.known) {
            const bool is_of_rig = each.effect->belongs_to == physics::BelongsTo::Rig;
            std::vector<std::size_t> others = stems_.fitted();
            for (const std::string& rig : stems_.rigs())
                if (is_of_rig) {
                    ActingEffect& added = model.effects.emplace_back(on_rig(each, rig, stems_));
                    added.is_known = true;
                    std::erase_if(others, [&](std::size_t s) { return added.acts_in(s); });
                }
            if (!others.empty())
                model.effects.push_back({each, {}, std::move(others), {}, true});
        }
    }

    void visit(std::vector<PlannedModel> planned) {
        std::vector<std::string> names;
        names.reserve(planned.size());
        for (const PlannedModel& each : planned)
            names.push_back(name_of(each.model.effects, stems_));
        options_.report(fmt::format("fitting {}", fmt::join(names, "; ")));
        fits_.fit(planned);
        for (PlannedModel& each : planned) {
            batches_ += each.model.batches();
            visited_.push_back(std::move(each.model));
        }
    }

    [[nodiscard]] bool is_visited(const std::vector<ActingEffect>& effects) const {
        return find_model(visited_, effects) != nullptr;
    }

    /// Each stem starts from its numbers in the model that was fitted before, in the base, or from
    /// the estimate about the model by which it was predicted.
    [[nodiscard]] PlannedModel plan_for(const std::vector<ActingEffect>& effects,
                                        const Prediction* prediction = nullptr) const {
        const Model* const before = fitted_before(effects);
        const Model& from = before != nullptr       ? *before
                            : prediction == nullptr ? base()
                                                    : visited_[prediction->base];
        PlannedModel plan;
        plan.predicted = prediction != nullptr ? prediction->log_evidence : not_predicted;
        plan.model.effects = before != nullptr ? before->effects : effects;
        plan.model.stems = from.stems;
        for (const std::size_t s : stems_.fitted()) {
            const StemEffects now = plan.model.effects_of(s, stems_);
            if (before == nullptr && key_of_stem(now.all) == key_of_stem(from.stems[s].fit.effects))
                continue;
            StemStart& start = plan.starts[s];
            if (before != nullptr || prediction == nullptr || !prediction->gains.contains(s))
                continue;
            start.smaller = &from.stems[s].fit;
            if (prediction->base == base_ && about_)
                start.starts = [this, s, prediction](const fit::Fit* smaller,
                                                     const fit::FitOptions&) {
                    return estimate(s, *prediction, *smaller);
                };
        }
        return plan;
    }

    /// Names of a stem's effects and the recordings where they are absent.
    [[nodiscard]] static std::set<std::string> key_of_stem(const fit::SelectedEffects& effects) {
        std::set<std::string> key;
        for (const physics::SelectedEffect& each : effects)
            key.insert(
                fmt::format("{} without {}", each.effect->name, fmt::join(each.absent_from, ", ")));
        return key;
    }

    /// The model as it was fitted with a previous noise; null: it was not.
    [[nodiscard]] const Model* fitted_before(const std::vector<ActingEffect>& effects) const {
        const Model* const found = find_model(visited_before_, effects);
        return found == nullptr || found->failed() ? nullptr : found;
    }

    [[nodiscard]] std::vector<fit::StartModels>
    estimate(std::size_t s, const Prediction& prediction, const fit::Fit& smaller) const {
        const std::vector<fit::ObservedRecording>& recordings = stems_[s].recordings;
        const SharedColumns columns =
            shared_columns(smaller, recordings, base().effects_of(s, stems_).sharing);
        return starts_to_estimate(
            {smaller, recordings, columns, options_.candidates, about_->view(s)},
            prediction.candidates, prediction.gains.at(s));
    }

    // --- The search

    void explore() {
        while (visited_.size() < most_visited) {
            const auto likeliest = std::ranges::max_element(visited_, {}, &Model::log_evidence);
            if (const auto now = static_cast<std::size_t>(likeliest - visited_.begin());
                now != base_)
                set_base(now);
            std::vector<PlannedModel> planned = neighbours();
            if (planned.empty())
                planned = with_own_first_modes();
            if (planned.empty()) {
                predict();
                planned = likeliest_unvisited();
            }
            if (planned.empty()) {
                predict_swaps();
                planned = likeliest_unvisited();
            }
            // Models that are not expected to be the best are judged by the noise about the best.
            const bool is_better_expected = std::ranges::any_of(planned, [&](const auto& each) {
                return !(each.predicted <= base().log_evidence); // or is not predicted
            });
            if (!is_better_expected && estimate_noise_again())
                continue;
            if (planned.empty())
                return;
            visit(std::move(planned));
        }
        is_complete_ = false;
    }

    void set_base(std::size_t place) {
        base_ = place;
        about_.reset();
        is_far_ = most_leave_too_much(stems_, base(), visited_.front());
        fits_.set_noise(noise_of_search(stems_, base()));
        for (Model& each : visited_)
            fits_.judge(each);
        update_predictions();
    }

    /// With the present noise.
    void update_predictions() {
        for (auto& [key, prediction] : predictions_)
            prediction.log_evidence =
                visited_[prediction.base].log_evidence +
                prediction.gain * prediction.noise / mean_of(fits_.noise(), base());
    }

    [[nodiscard]] bool is_rough() const {
        return base().chi_squared() > options_.policy.rough_misfit * base().readings();
    }

    /// Those that differ from the base by one effect and were not fitted; other laws of an answer.
    [[nodiscard]] std::vector<PlannedModel> neighbours() {
        std::vector<PlannedModel> planned;
        for (const std::vector<ActingEffect>& effects : neighbours_of(base(), stems_, !is_far_))
            if (!is_visited(effects))
                planned.push_back(plan_for(effects));
        return planned;
    }

    /// The base with an effect that gives each recording its first mode (starts_by_frequency()).
    [[nodiscard]] std::vector<PlannedModel> with_own_first_modes() {
        std::vector<PlannedModel> planned;
        if (!stems_.is_one() || stems_[0].recordings.size() < 2 || !is_far_ || base().added() > 0 ||
            !base().moves())
            return planned;
        for (const physics::SelectedEffect& candidate : options_.candidates) {
            std::vector<ActingEffect> effects = base().effects;
            effects.push_back({candidate, {}, {0}, {}, false});
            if (candidate.effect->belongs_to != physics::BelongsTo::Recording ||
                is_visited(effects) || !can_be_combined(effects, stems_))
                continue;
            fit::Fit numbers = base().stems[0].fit;
            numbers.effects.push_back(candidate);
            std::vector<fit::StartModels> starts = fit::starts_by_frequency(
                fit::models_of(numbers, stems_[0].recordings, options_.candidate),
                candidate.effect->name, stems_[0].recordings);
            if (starts.empty())
                continue;
            PlannedModel& plan = planned.emplace_back(plan_for(effects));
            plan.starts[0] = {&base().stems[0].fit,
                              [starts](const fit::Fit*, const fit::FitOptions&) { return starts; }};
        }
        return planned;
    }

    // --- Predictions

    /// Of models with more effects than the base.
    void predict() {
        if (about_)
            return;
        about_.emplace(stems_, base(), fits_.noise());
        swapped_.insert(key_of(base().effects));
        // About a worse model, sets of several effects were predicted across a larger misfit.
        std::erase_if(predictions_, [&](const auto& entry) {
            return entry.second.base != base_ && entry.second.candidates.size() > 1;
        });
        for (const auto& [rig, view] : about_->rigs())
            for_each_set(options_.candidates.size(), room(rig), [&, &of = rig](const auto& set) {
                return predict(*about_, of, base_, set);
            });
        // Sets of own effects are predicted for one stem; several get them one by one, and so does
        // a stem whose residual is far from noise, because the sets would soon be predicted again.
        for_each_set(options_.candidates.size(),
                     stems_.is_one() && !is_rough() ? room({}) : std::min<std::size_t>(room({}), 1),
                     [&](const auto& set) { return predict(*about_, {}, base_, set); });
    }

    /// Number of effects that may be added to a rig; empty: to stems.
    [[nodiscard]] std::size_t room(const std::string& rig) const {
        const auto added = static_cast<std::size_t>(
            std::ranges::count_if(base().effects, [&](const ActingEffect& each) {
                return each.rig == rig && !each.is_known;
            }));
        return options_.most_effects > added ? options_.most_effects - added : 0;
    }

    /// False: no model has these additions.
    bool predict(const Linearised& about, const std::string& rig, std::size_t base,
                 const std::vector<std::size_t>& set) {
        std::optional<Prediction> found = predicted(stems_, about, visited_[base], rig, set);
        if (!found)
            return false;
        found->base = base;
        found->noise = mean_of(fits_.noise(), this->base());
        if (std::isfinite(found->gain))
            predictions_.insert_or_assign(key_of(found->effects), *found);
        return true;
    }

    /// Predicts the models in which another effect replaces one of the base's. A swap is a single
    /// addition to the model without that effect, which was fitted.
    void predict_swaps() {
        const std::vector<ActingEffect> effects = base().effects;
        for (std::size_t k = 0; k < effects.size(); ++k) {
            if (effects[k].is_known)
                continue;
            const std::vector<ActingEffect> smaller = without(effects, k);
            const Model* const found = find_model(visited_, smaller);
            if (found == nullptr || found->failed() || !found->moves() ||
                !swapped_.insert(key_of(smaller)).second)
                continue;
            const auto base = static_cast<std::size_t>(found - visited_.data());
            const Linearised about(stems_, *found, fits_.noise());
            for (std::size_t c = 0; c < options_.candidates.size(); ++c) {
                for (const auto& [rig, view] : about.rigs())
                    predict_unless_visited(about, rig, base, c);
                predict_unless_visited(about, {}, base, c);
            }
        }
    }

    void predict_unless_visited(const Linearised& about, const std::string& rig, std::size_t base,
                                std::size_t candidate) {
        std::vector<ActingEffect> swapped = visited_[base].effects;
        swapped.push_back({options_.candidates[candidate], rig, {}, {}, false});
        if (is_visited(swapped))
            return;
        predict(about, rig, base, {candidate});
    }

    // --- Which predicted models are fitted

    /// Log evidence from which a model is worth a fit: near the best one. If that leaves too much
    /// for an answer, a larger one must explain a share of it.
    [[nodiscard]] double least_wanted() const {
        const Model& best = base();
        const double noise = mean_of(fits_.noise(), best);
        if (is_far_)
            return best.log_evidence + 0.5 * options_.policy.immaterial_share *
                                           std::max(0.0, best.chi_squared() - best.readings()) /
                                           noise;
        return best.log_evidence -
               options_.policy.unvisited_margin * mean_of(noise_about(best), best) / noise;
    }

    /// Models that may be as likely as the best visited model; the smallest come first, because
    /// they are the bases of better predictions.
    [[nodiscard]] std::vector<PlannedModel> likeliest_unvisited() {
        const double least = least_wanted();
        std::vector<const Prediction*> likely;
        for (const auto& [key, prediction] : predictions_)
            if (prediction.log_evidence > least && !is_visited(prediction.effects))
                likely.push_back(&prediction);
        std::ranges::sort(likely, {}, [](const Prediction* each) {
            return std::pair(each->effects.size(), -each->log_evidence);
        });
        std::vector<PlannedModel> planned;
        for (const Prediction* each : likely)
            if (planned.size() < models_per_round &&
                each->effects.size() == likely.front()->effects.size())
                planned.push_back(plan_for(each->effects, each));
        return planned;
    }

    // --- Noise about the best model

    /// Fits the likeliest models again with the noise about the best one; returns false if the
    /// noise is unchanged.
    [[nodiscard]] bool estimate_noise_again() {
        if (base().effects.empty() || is_rough() || is_far_ ||
            noise_estimates_ == most_noise_estimates || key_of(base().effects) == noise_about_)
            return false;
        noise_about_ = key_of(base().effects);
        ++noise_estimates_;
        std::vector<fit::Fit> best;
        for (const StemFit& stem : base().stems)
            best.push_back(stem.fit);
        if (!stems_.estimate_noise(best))
            return false;
        options_.report("fitting the best model with the noise about it");
        const std::vector<ActingEffect> effects = base().effects;
        visited_before_ = visited_;
        const double chi_squared = visited_.front().chi_squared();
        const ModelKey chain = key_of(visited_.front().effects);
        std::erase_if(swapped_, [&](const ModelKey& key) { return key != chain; });
        std::erase_if(predictions_, [](const auto& entry) { return entry.second.base != 0; });
        visit_chain();
        // χ² of predictions about the chain is nearly proportional to the chain's own χ².
        for (auto& [key, prediction] : predictions_)
            prediction.gain *= visited_.front().chi_squared() / chi_squared;
        update_predictions();
        visit({plan_for(effects)});
        return true;
    }

    const DiagnosisOptions& options_;
    std::shared_ptr<Stems> owned_stems_;
    Stems& stems_;
    ModelFits fits_;
    std::vector<Model> visited_;
    std::vector<Model> visited_before_; ///< with a previous noise
    std::map<ModelKey, Prediction> predictions_;
    std::size_t base_ = 0; ///< the model about which everything is predicted
    bool is_far_ = false;  ///< does the base leave more of the misfit than an answer may?
    std::optional<Linearised> about_; ///< the base; empty: not computed
    std::set<ModelKey> swapped_;      ///< models about which everything was predicted
    ModelKey noise_about_;            ///< the model about which the noise was estimated last
    int noise_estimates_ = 0;
    int batches_ = 0;
    bool is_complete_ = true;
};

} // namespace

fit::Fit SearchResult::rerun(std::size_t model, std::size_t stem) const {
    fit::FitOptions options = stems->options().candidate;
    options.held_effects = visited[model].effects_of(stem, *stems).sharing.held();
    return fit::rerun(visited[model].stems[stem].fit, (*stems)[stem].recordings, options);
}

std::vector<NoiseScale> noise_of_search(const Stems& stems, const Model& best) {
    return stems.is_one() ? std::vector{noise_as_assumed(stems[0].chain)} : noise_about(best);
}

bool most_leave_too_much(const Stems& stems, const Model& model, const Model& first) {
    const std::vector<std::size_t> fitted = stems.fitted();
    const auto count = std::ranges::count_if(fitted, [&](std::size_t s) {
        return leaves_too_much(model.stems[s].fit, model.stems[s].verdict, first.stems[s].fit,
                               stems.options().policy);
    });
    return 2 * count > std::ssize(fitted);
}

void judge_about_best(SearchResult& search) {
    const std::vector<NoiseScale> before = search.fits.noise();
    const Model& best = search.best_model();
    search.fits.set_noise(noise_about(best));
    search.noise_ratio = mean_of(search.fits.noise(), best) / mean_of(before, best);
    search.about_best.clear();
    for (const Model& each : search.visited) {
        Model judged = each;
        judged.offset /= search.noise_ratio; // a difference of χ² in units of the noise
        search.fits.judge(judged);
        search.about_best.push_back(judged.log_evidence);
    }
}

std::optional<std::size_t> likeliest_part(const std::vector<Model>& visited, std::size_t model) {
    std::optional<std::size_t> part;
    for (std::size_t k = 1; k < visited.size() && visited[model].added() > 1; ++k)
        if (visited[k].added() == 1 && std::isfinite(visited[k].log_evidence) &&
            contains_all(visited[model].effects, visited[k].effects) &&
            (!part || visited[k].log_evidence > visited[*part].log_evidence))
            part = k;
    return part;
}

SearchResult search_models(std::span<const Specimen> specimens, const DiagnosisOptions& options) {
    return Search(specimens, options).run();
}

} // namespace culm::diagnose
