// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/planned_model.hpp"

#include "core/error.hpp"
#include "diagnose/adequacy.hpp"
#include "fit/linear/layout.hpp"
#include "fit/solve/error_solution.hpp"
#include "fit/start/starts.hpp"
#include "physics/effects/library.hpp"
#include "run/modes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <set>
#include <utility>

namespace culm::diagnose {
namespace {

/// Are the amounts those of the model without the effect?
bool is_absent_at(const EffectNode& node, const std::vector<double>& amounts) {
    return !node.columns.front().is_certain &&
           std::ranges::all_of(amounts, [](double amount) { return amount == 0.0; });
}

/// Position along the secant from the model without the effect to the node, as a fraction.
double way_to(const EffectNode& node, const std::vector<double>& amounts) {
    if (is_absent_at(node, amounts))
        return 0.0;
    const double secant = node.columns.front().secant;
    return secant == 0.0 ? 1.0 : amounts.front() / secant;
}

/// Size `k` among the effect's parameters, as a coordinate; `value` if the node has no column for
/// it. If recordings have separate sizes, each has its own column.
double size_of(const EffectNode& node, const std::vector<double>& amounts, std::size_t k,
               std::size_t recording, const ParameterPrior& prior, double value) {
    const bool has_own = std::ranges::count(node.columns, k, &EffectColumn::parameter) > 1;
    double coordinate = prior.absent;
    std::size_t seen = 0;
    for (std::size_t c = 0; c < node.columns.size(); ++c) {
        if (node.columns[c].parameter != k)
            continue;
        if (!has_own || seen == recording)
            coordinate += amounts[c] * prior.deviation;
        ++seen;
    }
    return seen > 0 ? coordinate : value;
}

void place_effect(const CandidateView& view, const EffectNode& node,
                  const std::vector<double>& amounts, std::size_t recording,
                  fit::StemModel& model) {
    const std::string name = view.effect.effect->name();
    std::size_t k = 0;
    for (const fit::FreeParameter& parameter : model.parameters) {
        if (parameter.access.id.effect != name)
            continue;
        double value = node.values[k];
        if (!parameter.is_place)
            value = fit::from_coordinate(parameter.fitted_as,
                                         size_of(node, amounts, k, recording,
                                                 prior_of(parameter, model),
                                                 fit::to_coordinate(parameter.fitted_as, value)));
        else if (parameter.fitted_as == physics::FittedAs::Inverse && is_absent_at(node, amounts))
            value = parameter.upper; // the stiffness of a rigid clamp
        if (!std::isfinite(value))   // a stiffness without compliance
            value = parameter.upper;
        parameter.access.set(model.spec, std::clamp(value, parameter.lower, parameter.upper));
        ++k;
    }
}

/// The model with the effect of these amounts. Along a secant Y and β change such that the first
/// mode stays; with several recordings they do not. A beat has another frequency.
fit::StemModel with_effect(const fit::StemModel& base, const CandidateView& view,
                           const EffectNode& node, const std::vector<double>& amounts,
                           std::size_t recording,
                           std::span<const fit::ObservedRecording> recordings) {
    fit::StemModel model = candidate_model(base, {view.effect}, recordings[recording]);
    place_effect(view, node, amounts, recording, model);
    if (node.columns.front().secant != 0.0 && view.effect.effect->dimensions() < 3 &&
        recordings.size() == 1)
        if (const auto modes = run::chain_modes(base.spec, 1); !modes.empty()) {
            fit::keep_first_mode(modes.front(), model);
            return model;
        }
    const double share = way_to(node, amounts);
    model.spec.stem.bond_youngs_modulus *= std::pow(node.modulus_ratio, share);
    model.spec.stem.bond_damping *= std::pow(node.damping_ratio, share);
    return model;
}

/// Factors of the linear estimate that are tried before a fit, one in each lane. The last one is
/// the model without the effects: a fit that starts there is not worse than that.
constexpr std::array tried_factors{1.0, 1.0 / 4.0, 1.0 / 16.0, 0.0};

/// A start with the effects is preferred up to this ratio of its χ² to that without them: it leads
/// out of the smaller model's minimum.
constexpr double follows_within = 10.0;

/// Fits from the start with the smallest χ².
fit::Fit fit_from(const std::vector<fit::StartModels>& starts, const fit::SelectedEffects& effects,
                  const fit::Fit& smaller, std::span<const fit::ObservedRecording> recordings,
                  const fit::FitOptions& options) {
    const fit::WeightedSystem& system = smaller.system;
    const Eigen::VectorXd measured = system.residual + system.predicted;
    std::size_t best = 0;
    int batches = 0;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t first = 0; first < starts.size() && !std::isfinite(least); ++first)
        try { // where the whole step is too large for a chain, shorter ones may do
            const std::vector<fit::StartModels> shorter(
                starts.begin() + static_cast<std::ptrdiff_t>(first), starts.end());
            const auto readings =
                fit::readings_together(shorter, smaller, recordings, options.heartbeat, batches);
            for (std::size_t k = 0; k < readings.size(); ++k)
                if (const double squares =
                        (measured - readings[k]).head(system.readings()).squaredNorm() *
                        (starts.size() > 1 && first + k + 1 == starts.size() ? follows_within
                                                                             : 1.0);
                    squares < least) {
                    least = squares;
                    best = first + k;
                }
        } catch (const core::NumericalError&) {
        }
    fit::Fit fit = fit::fit_near(starts[best], effects, smaller, recordings, options);
    fit.batches += batches;
    return fit;
}

/// A fit and the effects that may join it.
class Additions {
  public:
    /// Throws core::NumericalError if an effect has no columns. All must outlive this.
    Additions(const fit::SelectedEffects& effects, const fit::Fit& smaller,
              std::span<const fit::ObservedRecording> recordings, const fit::FitOptions& options)
        : smaller_(smaller), recordings_(recordings), options_(options) {
        for (const physics::SelectedEffect& effect : effects) {
            views_.push_back({effect, effect_columns(smaller, effect, recordings, options)});
            if (const std::string& failure = views_.back().columns.failure; !failure.empty())
                throw core::NumericalError(core::FailureKind::FitFailed, failure);
        }
        linear_.emplace(smaller.system, views_);
    }

    [[nodiscard]] int batches() const { ///< of lanes, for the columns
        int sum = 0;
        for (const CandidateView& view : views_)
            sum += view.columns.batches;
        return sum;
    }

    /// The effect that is predicted to explain most.
    [[nodiscard]] std::size_t likeliest() const {
        std::vector<double> gains;
        for (std::size_t k = 0; k < views_.size(); ++k)
            gains.push_back(linear_->gain({&k, 1}).log_evidence);
        return static_cast<std::size_t>(std::ranges::max_element(gains) - gains.begin());
    }

    /// Fits the model with these effects, from where their columns lead.
    [[nodiscard]] fit::Fit with(const std::vector<std::size_t>& chosen) const {
        PredictedGain gain = linear_->gain(chosen);
        if (gain.nodes.empty()) // all allowed sizes make the fit worse: it starts without them
            for (const std::size_t k : chosen) {
                gain.nodes.push_back(0);
                gain.amounts.emplace_back(views_[k].columns.nodes.front().columns.size(), 0.0);
            }
        fit::SelectedEffects effects = smaller_.effects;
        for (const std::size_t k : chosen)
            effects.push_back(views_[k].effect);
        return fit_from(starts_to_estimate(smaller_, recordings_, views_, *linear_, chosen, gain),
                        effects, smaller_, recordings_, options_);
    }

  private:
    const fit::Fit& smaller_;
    std::span<const fit::ObservedRecording> recordings_;
    const fit::FitOptions& options_;
    std::vector<CandidateView> views_;
    std::optional<LinearEvidence> linear_;
};

/// Does the size of effect number `place` of the fit permit that the effect is absent from the
/// recording? An effect acts in at least one recording.
bool may_be_absent(const fit::Fit& fit, std::size_t place, const std::string& recording) {
    const physics::SelectedEffect& effect = fit.effects[place];
    return fit::belongs_to_recording({effect.effect->name(), {}, {}}) &&
           effect.absent_from.size() + 1 < fit.misfits.size() &&
           std::ranges::any_of(fit.parameters, [&](const fit::FittedParameter& parameter) {
               return parameter.id.effect == effect.effect->name() &&
                      parameter.id.recording == recording && !parameter.is_place &&
                      (is_absent(parameter) || parameter.is_at_bound);
           });
}

} // namespace

ModelKey key_of(const fit::SelectedEffects& effects) {
    ModelKey key;
    for (const physics::SelectedEffect& selected : effects) {
        std::string& text = key.emplace_back(physics::to_string(selected));
        for (const std::string& recording : selected.absent_from)
            text += " without " + recording;
    }
    std::ranges::sort(key);
    return key;
}

bool can_be_combined(const fit::SelectedEffects& effects) {
    std::vector<physics::EffectPointer> pointers;
    std::set<physics::Family> laws;
    for (const physics::SelectedEffect& selected : effects) {
        pointers.push_back(selected.effect);
        if (physics::is_one_law(selected.effect->family()) &&
            !laws.insert(selected.effect->family()).second)
            return false;
    }
    try {
        physics::check_combination(pointers);
    } catch (const core::InputError&) {
        return false;
    }
    return true;
}

std::vector<fit::StartModels>
starts_to_estimate(const fit::Fit& base, std::span<const fit::ObservedRecording> recordings,
                   const std::vector<CandidateView>& views, const LinearEvidence& linear,
                   const std::vector<std::size_t>& chosen, PredictedGain gain) {
    const fit::StartModels fitted = fit::start_from(base);
    const fit::JointLayout layout = fit::joint_layout(fitted, recordings);
    const std::vector<std::vector<double>> whole = gain.amounts;
    std::vector<fit::StartModels> starts;
    for (const double factor : tried_factors) {
        for (std::size_t e = 0; e < chosen.size(); ++e)
            for (std::size_t k = 0; k < whole[e].size(); ++k)
                gain.amounts[e][k] = factor * whole[e][k];
        fit::StartModels& models =
            starts.emplace_back(fit::moved(fitted, layout, linear.own_change(chosen, gain)));
        for (std::size_t e = 0; e < chosen.size(); ++e) {
            const CandidateView& view = views[chosen[e]];
            const EffectNode& node = view.columns.nodes[gain.nodes[e]];
            for (std::size_t m = 0; m < models.size(); ++m)
                models[m] = with_effect(models[m], view, node, gain.amounts[e], m, recordings);
        }
    }
    return starts;
}

bool contains_all(const fit::SelectedEffects& effects, const fit::SelectedEffects& some) {
    return std::ranges::all_of(some,
                               [&](const auto& each) { return fit::contains(effects, each); });
}

std::vector<fit::SelectedEffects>
sets_to_compare(const fit::Fit& fit, std::span<const fit::ObservedRecording> recordings,
                std::size_t known) {
    std::vector<fit::SelectedEffects> sets;
    const fit::SelectedEffects& effects = fit.effects;
    for (std::size_t k = known; k < effects.size(); ++k) {
        if (effects.size() > known + 1) {
            fit::SelectedEffects& smaller = sets.emplace_back(effects);
            smaller.erase(smaller.begin() + static_cast<std::ptrdiff_t>(k));
        }
        for (const measure::Measurement& recording : recordings)
            if (may_be_absent(fit, k, recording.stem.id)) {
                std::vector<std::string>& absent = sets.emplace_back(effects)[k].absent_from;
                absent.push_back(recording.stem.id);
                std::ranges::sort(absent);
            }
    }
    return sets;
}

fit::Fit fit_larger(const fit::SelectedEffects& effects, const fit::Fit& smaller,
                    std::span<const fit::ObservedRecording> recordings,
                    const fit::FitOptions& options) {
    if (!smaller.moves() || smaller.failed())
        return fit::fit_model(effects, smaller, recordings, options);
    int batches = 0;
    fit::Fit fit = smaller;
    fit::Fit together;
    fit::SelectedEffects rest = fit::in_library_order(effects);
    std::erase_if(rest, [&](const auto& each) { return fit::contains(smaller.effects, each); });
    try {
        while (!rest.empty() && !fit.failed()) {
            const Additions additions(rest, fit, recordings, options);
            batches += additions.batches();
            if (rest.size() > 1 && fit.effects.size() == smaller.effects.size()) {
                std::vector<std::size_t> all(rest.size());
                std::iota(all.begin(), all.end(), 0);
                together = additions.with(all);
                batches += together.batches;
            }
            const std::size_t next = additions.likeliest();
            fit = additions.with({next});
            batches += fit.batches;
            rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(next));
        }
    } catch (const std::runtime_error& error) { // InputError or NumericalError
        fit = {};
        fit.reason = error.what();
    }
    if (!together.failed() && (fit.failed() || together.weighted_rms < fit.weighted_rms))
        fit = std::move(together);
    fit.batches = batches;
    fit.effects = effects;
    fit.names = fit::model_names(fit::in_library_order(effects));
    return fit;
}

FittedModel fit_planned(const PlannedModel& planned, const fit::Fit& smaller,
                        std::span<const fit::ObservedRecording> recordings,
                        const fit::SelectedEffects& known, const Policy& policy,
                        const fit::FitOptions& options) {
    const fit::Fit fit =
        planned.starts.empty()
            ? fit_larger(planned.effects, smaller, recordings, options)
            : fit_from(planned.starts, planned.effects, smaller, recordings, options);
    FittedModel out;
    if (!fit.failed())
        out.evidence = evidence_of(fit, recordings, known);
    out.is_inadequate =
        fit.is_fitted() && verdict_on(fit, recordings, policy).finding == Finding::Inadequate;
    out.fit = fit::to_numbers(fit);
    return out;
}

} // namespace culm::diagnose
