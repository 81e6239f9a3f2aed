// SPDX-License-Identifier: BSD-3-Clause
#include "fit/fit_model.hpp"

#include "core/error.hpp"
#include "fit/solve/reading_errors.hpp"
#include "fit/solve/residual_statistics.hpp"
#include "fit/start/starts.hpp"

#include <algorithm>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace culm::fit {
namespace {

/// Largest ratio of the residuals to those of a contained model; not 1 because the runs have noise.
constexpr double allowed_excess = 1.001;
constexpr int screening_iterations = 3;
constexpr int most_restarts = 2;
/// Decrease of χ², in units of the reduced χ², that is worth another solution.
constexpr double needed_gain = 0.5;

/// The result of some iterations from a start.
struct BegunFit {
    StartModels models;
    double weighted_rms = 0.0; ///< as in Fit
    double chi_squared = 0.0;
};

/// The best fit of one model from several starts.
class BestFit {
  public:
    /// `recordings` and `options` must outlive this; `noise` is as in JointOptions.
    BestFit(std::span<const ObservedRecording> recordings, const FitOptions& options,
            std::vector<std::vector<double>> noise = {})
        : recordings_(recordings), options_(options), noise_(std::move(noise)) {}

    /// Runs a complete fit from a start.
    void try_start(const StartModels& start, bool is_first_guess) {
        ++starts_;
        try {
            Fit fit = solved(start, joint_options(is_first_guess));
            if (fit.status == FitStatus::NotConverged) // a long valley: continue once
                fit = solved(start_from(fit), joint_options(false));
            fit = settled(std::move(fit));
            if (fit.failed())
                failure_ = fit.reason;
            else if (!best_ || fit.weighted_rms < best_->weighted_rms)
                best_ = std::move(fit);
        } catch (const core::NumericalError& error) {
            failure_ = error.what();
        }
    }

    /// Begins a fit from each start and completes the best one; completes a single start directly.
    void try_starts(const std::vector<StartModels>& starts, bool is_first_guess) {
        if (starts.size() == 1)
            return try_start(starts.front(), is_first_guess);
        std::vector<BegunFit> begun;
        for (const StartModels& start : starts)
            try {
                begun.push_back(begin(start, is_first_guess));
            } catch (const core::NumericalError& error) {
                failure_ = error.what();
                ++starts_;
            }
        go_on(std::move(begun));
    }

    /// As try_starts(), for a model that is larger than that of `smaller` (a part for each
    /// recording) and, if `is_nested`, contains it. If its fit is worse, the solution has skipped a
    /// cycle, and growing windows are tried; a fit that is still worse has failed. A model that is
    /// not nested uses growing windows at once, unless its start is near the solution.
    void try_larger(const std::vector<StartModels>& starts, std::span<const RecordingFit> smaller,
                    bool is_nested, bool is_near_end = false) {
        try_starts(starts, false);
        if (is_near_end ? is_nested && !is_as_good_as(smaller)
                        : !is_nested || !is_as_good_as(smaller))
            try_starts(starts, true);
        if (!is_nested || !best_ || is_as_good_as(smaller))
            return;
        const measure::ReadingUnit unit = measure::reading_unit(smaller.front().model.spec.sensors);
        failure_ = fmt::format(
            "no start leads to a fit as good as that of the model it contains (rms "
            "{:.4g} {}, without it {:.4g} {})",
            unit.factor * best_->rmse, unit.name, unit.factor * rms(smaller), unit.name);
        best_.reset();
    }

    /// The best fit, or the reason for the last failure.
    [[nodiscard]] Fit take() {
        Fit fit;
        if (best_)
            fit = *std::move(best_);
        else
            fit.reason = failure_;
        fit.starts = starts_;
        fit.runs = runs_;
        return fit;
    }

  private:
    /// Runs some iterations from a start with its places (angles, time scales) fixed. Throws
    /// core::NumericalError if they give no fit.
    [[nodiscard]] BegunFit begin(const StartModels& start, bool is_first_guess) {
        JointOptions few = joint_options(is_first_guess);
        few.chain.largest_iterations = screening_iterations;
        few.is_held = places(start);
        const Fit fit = solved(start, few);
        return {start_from(fit), fit.weighted_rms, fit.chi_squared};
    }

    /// Completes the best of the begun fits, and then each next one that was already better when it
    /// was begun.
    void go_on(std::vector<BegunFit> begun) {
        std::ranges::stable_sort(begun, {}, &BegunFit::weighted_rms);
        starts_ += static_cast<int>(begun.size());
        for (const BegunFit& fit : begun) {
            if (best_ &&
                !(fit.chi_squared <
                  best_->chi_squared - needed_gain * std::max(1.0, best_->reduced_chi_squared)))
                break;
            try_start(fit.models, false);
            --starts_;
        }
    }

    /// Compares residuals that are weighted by the noise of the best fit.
    [[nodiscard]] bool is_as_good_as(std::span<const RecordingFit> smaller) const {
        return best_ && best_->weighted_rms <= allowed_excess * weighted_rms(smaller, best_->noise);
    }

    [[nodiscard]] Fit solved(const StartModels& start, const JointOptions& options) {
        Fit fit = fit_jointly(start, recordings_, options);
        runs_ += fit.runs;
        return fit;
    }

    /// Places, angles and time scales: their derivatives almost vanish while an effect is small, so
    /// a first step would move them far away.
    [[nodiscard]] std::vector<bool> places(const StartModels& start) const {
        const JointLayout layout = joint_layout(start, recordings_);
        std::vector<bool> held;
        for (const JointLayout::Owner& owner : layout.owners) {
            const std::vector<FreeParameter>& parameters = start[owner.model].parameters;
            held.push_back(owner.parameter < parameters.size() &&
                           parameters[owner.parameter].is_place);
        }
        return held;
    }

    [[nodiscard]] JointOptions joint_options(bool is_first_guess) const {
        JointOptions joint;
        joint.chain.window = options_.window;
        joint.chain.is_first_guess = is_first_guess;
        joint.chain.heartbeat = options_.heartbeat;
        joint.noise = noise_;
        return joint;
    }

    /// A solution can end early where its steps meet a bound. It is restarted from there with the
    /// parameters at a bound fixed, until a restart gains nothing.
    [[nodiscard]] Fit settled(Fit fit) {
        for (int again = 0; again < most_restarts; ++again) {
            JointOptions options = joint_options(false);
            for (const FittedParameter& parameter : fit.parameters)
                options.is_held.push_back(parameter.is_at_bound);
            if (std::ranges::none_of(options.is_held, [](bool held) { return held; }))
                break; // no bound limited the steps
            Fit next = solved(start_from(fit), options);
            const double gain = fit.chi_squared - next.chi_squared;
            const bool is_settled = !(gain > needed_gain * std::max(1.0, next.reduced_chi_squared));
            // Fixed parameters have no covariance, so this solution is used only if it gains
            // enough.
            if (!next.failed() && !is_settled)
                fit = std::move(next);
            if (is_settled)
                break;
        }
        return fit;
    }

    std::span<const ObservedRecording> recordings_;
    const FitOptions& options_;
    std::vector<std::vector<double>> noise_;
    std::optional<Fit> best_;
    std::string failure_; ///< the last one
    int starts_ = 0;
    int runs_ = 0; ///< of chains with all their derivatives
};

constexpr std::size_t most_reconciling = 4;

/// Readings of unknown noise are weighted by the residuals of a smaller model, relative to other
/// recordings and to the constraints of error terms.
std::vector<std::vector<double>> noises(std::span<const RecordingFit> fits) {
    std::vector<std::vector<double>> out;
    for (const RecordingFit& fit : fits)
        out.push_back(fit.noise);
    return out;
}

/// The residuals of a stem that nothing moves are its readings.
Fit motionless(const StemModel& model, const ObservedRecording& recording,
               const FitOptions& options) {
    JointOptions held;
    held.chain.window = options.window;
    held.chain.is_first_guess = false;
    held.chain.heartbeat = options.heartbeat;
    held.is_held.assign(model.free_count(), true);
    Fit fit = fit_jointly({&model, 1}, {&recording, 1}, held);
    fit.status = FitStatus::Motionless;
    fit.starts = 1;
    return fit;
}

/// The message of the error that `work` throws; empty if it throws none.
template <class Work>
std::string failure_of(const Work& work) {
    try {
        work();
        return {};
    } catch (const core::InputError& error) {
        return error.what();
    } catch (const core::NumericalError& error) {
        return error.what();
    }
}

/// Has the fit failed, or is a parameter that `smaller` does not have at a bound or consistent with
/// its absence? Then a part of the model may fit better.
bool is_doubtful(const Fit& fit, const Fit& smaller) {
    return fit.failed() ||
           std::ranges::any_of(fit.parameters, [&](const FittedParameter& parameter) {
               const bool is_new =
                   std::ranges::find(smaller.parameters, parameter.id, &FittedParameter::id) ==
                   smaller.parameters.end();
               return is_new && !parameter.is_place &&
                      (parameter.is_at_bound || is_absent(parameter));
           });
}

bool is_worse(const Fit& fit, const Fit& part) {
    return fit.failed() || fit.weighted_rms > allowed_excess * part.weighted_rms;
}

/// The fits of one model: each finds its own starts.
class FitPlan {
  public:
    /// All must outlive this.
    FitPlan(const SelectedEffects& effects, const Fit& smaller,
            std::span<const ObservedRecording> recordings, const FitOptions& options)
        : effects_(effects), smaller_(smaller), recordings_(recordings), options_(options) {
        failure_ = failure_of([&] {
            for (const ObservedRecording& recording : recordings)
                models_.push_back(observed_model(effects, recording, options.chain));
            if (recordings.size() > 1)
                for (const ObservedRecording& recording : recordings)
                    swings_.push_back(recorded_swing(recording, options));
            if (!effects_.empty() && !smaller.failed() && moves() && !moves_more())
                starts_ = larger_starts();
        });
    }

    /// As fit_model().
    [[nodiscard]] Fit fit() const {
        Fit fit;
        fit.reason = failure_;
        if (failure_.empty())
            if (std::string failure = failure_of([&] { fit = fitted(); }); !failure.empty()) {
                fit.status = FitStatus::Failed;
                fit.reason = std::move(failure);
            }
        if (!fit.failed() && !moves())
            fit.status = FitStatus::Motionless;
        fit.effects = effects_;
        fit.names = model_names(in_library_order(effects_));
        return fit;
    }

    /// Fits all recordings together, from each one's own fit of the same model.
    [[nodiscard]] Fit fit_from_alone(std::span<const RecordingFit> alone) const {
        BestFit best(recordings_, options_, noises(alone));
        best.try_starts(shared_starts(models_, alone, swings_, joint_layout(models_, recordings_)),
                        false);
        return best.take();
    }

  private:
    [[nodiscard]] Fit fitted() const {
        if (!effects_.empty() && smaller_.failed()) {
            Fit none;
            none.reason = "the model that it contains could not be fitted: " + smaller_.reason;
            return none;
        }
        if (!effects_.empty() && !moves())
            return smaller_;
        if (starts_.empty())
            return recordings_.size() > 1 ? fit_from_own() : fit_alone(0);
        BestFit best(recordings_, options_, noises(smaller_.parts));
        best.try_larger(starts_, smaller_.parts, is_nested(models_.front()));
        return best.take();
    }

    [[nodiscard]] bool moves() const {
        for (std::size_t m = 0; m < models_.size(); ++m)
            if (can_move(models_[m], recordings_[m]))
                return true;
        return false;
    }

    /// Does the model move a recording's stem that is at rest in `smaller`?
    [[nodiscard]] bool moves_more() const {
        for (std::size_t m = 0; m < models_.size(); ++m)
            if (can_move(models_[m], recordings_[m]) &&
                !can_move(smaller_.parts[m].model, recordings_[m]))
                return true;
        return false;
    }

    /// The candidate_starts() of all recordings, combined, then starts that reconcile recordings
    /// which disagree.
    [[nodiscard]] std::vector<StartModels> larger_starts() const {
        std::vector<std::vector<StemModel>> own;
        std::size_t count = 0;
        for (std::size_t m = 0; m < models_.size(); ++m) {
            own.push_back(candidate_starts(models_[m], smaller_.parts[m]));
            count = std::max(count, own.back().size());
        }
        std::vector<StartModels> starts;
        std::vector<StartModels> reconciling;
        for (std::size_t k = 0; k < count; ++k) {
            StartModels& start = starts.emplace_back();
            for (const std::vector<StemModel>& each : own)
                start.push_back(each[k % each.size()]);
            if (recordings_.size() > 1 && reconciling.size() < most_reconciling)
                for (StartModels& other : reconciling_starts(start, smaller_.parts, swings_))
                    reconciling.push_back(std::move(other));
        }
        std::ranges::move(reconciling, std::back_inserter(starts));
        return starts;
    }

    /// Fits one recording separately: the chain, or the effects without which its stem is at rest.
    [[nodiscard]] Fit fit_alone(std::size_t recording) const {
        const std::span<const ObservedRecording> own(&recordings_[recording], 1);
        if (!can_move(models_[recording], own.front())) {
            if (effects_.empty())
                return motionless(models_[recording], own.front(), options_);
            Fit still;
            still.status = FitStatus::Motionless;
            still.parts = {smaller_.parts[recording]};
            return still;
        }
        BestFit best(own, options_);
        if (!effects_.empty() && can_move(smaller_.parts[recording].model, own.front())) {
            std::vector<StartModels> starts;
            for (StemModel& start : candidate_starts(models_[recording], smaller_.parts[recording]))
                starts.push_back({std::move(start)});
            best.try_larger(starts, {&smaller_.parts[recording], 1}, is_nested(models_[recording]));
        } else {
            best.try_start({models_[recording]}, true);
        }
        return best.take();
    }

    /// Starts from each recording's own fit.
    [[nodiscard]] Fit fit_from_own() const {
        std::vector<RecordingFit> alone;
        int runs = 0;
        for (std::size_t m = 0; m < recordings_.size(); ++m) {
            Fit own = fit_alone(m);
            runs += own.runs;
            if (own.failed()) {
                own.reason = recordings_[m].stem.id + " alone: " + own.reason;
                own.runs = runs;
                return own;
            }
            alone.push_back(std::move(own.parts.front()));
        }
        Fit fit = fit_from_alone(alone);
        fit.runs += runs;
        return fit;
    }

    std::string failure_; ///< why there is no plan
    const SelectedEffects& effects_;
    const Fit& smaller_;
    std::span<const ObservedRecording> recordings_;
    const FitOptions& options_;
    StartModels models_;
    std::vector<RecordedSwing> swings_; ///< of several recordings
    std::vector<StartModels> starts_;   ///< from `smaller`, if it has a fit and moves as much
};

} // namespace

Fit fit_model(const SelectedEffects& effects, const Fit& smaller,
              std::span<const ObservedRecording> recordings, const FitOptions& options) {
    return FitPlan(effects, smaller, recordings, options).fit();
}

Fit fit_again(const SelectedEffects& effects, std::span<const RecordingFit> from,
              std::span<const ObservedRecording> recordings, const FitOptions& options) {
    Fit fit;
    int runs = 0;
    std::vector<RecordingFit> own(from.begin(), from.end());
    for (std::size_t m = 0; m < recordings.size(); ++m) {
        BestFit best(recordings.subspan(m, 1), options, {from[m].noise});
        best.try_start({linear_start(from[m], recordings[m])}, false);
        fit = best.take();
        runs += fit.runs;
        if (fit.failed()) {
            fit.reason = fmt::format("{} with the errors of its readings: {}",
                                     recordings[m].stem.id, fit.reason);
            break;
        }
        own[m] = fit.parts.front();
    }
    if (recordings.size() > 1 && !fit.failed()) {
        const Fit none; // the plan starts from `own`
        fit = FitPlan(effects, none, recordings, options).fit_from_alone(own);
        fit.runs += runs;
    }
    fit.effects = effects;
    fit.names = model_names(in_library_order(effects));
    return fit;
}

Fit refined(const StartModels& start, const SelectedEffects& effects, const Fit& smaller,
            std::span<const ObservedRecording> recordings, const FitOptions& options) {
    BestFit best(recordings, options, noises(smaller.parts));
    best.try_larger({start}, smaller.parts, is_nested(start.front()), true);
    Fit fit = best.take();
    fit.effects = effects;
    fit.names = model_names(in_library_order(effects));
    return fit;
}

Fit fit_with_parts(const SelectedEffects& effects, const Fit& smaller,
                   std::span<const ObservedRecording> recordings, const FitOptions& options) {
    Fit whole = fit_model(effects, smaller, recordings, options);
    const auto added = std::ranges::count_if(
        effects, [&](const auto& each) { return !contains(smaller.effects, each); });
    if (added < 2 || !is_doubtful(whole, smaller))
        return whole;
    std::optional<Fit> best;
    for (std::size_t k = 0; k < effects.size(); ++k) {
        if (contains(smaller.effects, effects[k]) || !has_fitted_number(*effects[k].effect))
            continue;
        SelectedEffects rest = effects;
        rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(k));
        // Effects that are added together may compensate each other from the first step. Compared
        // with the best smaller model, only one of them is new.
        Fit part = fit_with_parts(rest, smaller, recordings, options);
        whole.runs += part.runs;
        if (part.is_fitted() && (!best || part.weighted_rms < best->weighted_rms))
            best = std::move(part);
    }
    if (!best || !is_worse(whole, *best))
        return whole;
    Fit again = fit_model(effects, *best, recordings, options);
    again.runs += whole.runs;
    if (is_worse(again, *best)) {
        again.reason =
            fmt::format("no start leads to a fit as good as that of {}, which it contains",
                        fmt::join(best->names, " + "));
        again.status = FitStatus::Failed;
        again.parts.clear();
    }
    return again;
}

double relative_cost(const SelectedEffects& effects) {
    constexpr double of_spatial = 6.0;
    return std::ranges::any_of(effects,
                               [](const auto& each) { return each.effect->dimensions() > 2; })
               ? of_spatial
               : 1.0;
}

} // namespace culm::fit
