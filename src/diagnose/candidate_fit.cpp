// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/candidate_fit.hpp"

#include "core/error.hpp"
#include "diagnose/fit_starts.hpp"
#include "physics/effects/library.hpp"

#include <algorithm>
#include <utility>

#include <fmt/core.h>

namespace culm::diagnose {
namespace {

/// A larger model may end this much above the one that it contains: the runs have noise.
constexpr double allowed_excess = 1.001;
constexpr int screening_iterations = 3;
constexpr int most_restarts = 2;
/// Of χ², in units of the reduced χ²: worth another solution.
constexpr double needed_gain = 0.5;

calibrate::ChainFitOptions fit_options(const CandidateOptions& options, bool is_first_guess) {
    calibrate::ChainFitOptions fit;
    fit.window = options.window;
    fit.is_first_guess = is_first_guess;
    fit.heartbeat = options.heartbeat;
    return fit;
}

/// Every effect has a size that a fit can make vanish: the larger model contains the smaller one.
bool is_nested(const calibrate::StemModel& model) {
    return std::ranges::all_of(model.spec.effects, [&model](const auto& active) {
        const std::string beginning = active.effect->name() + ".";
        return std::ranges::any_of(model.parameters, [&](const auto& parameter) {
            return parameter.access.name.starts_with(beginning) && !parameter.is_place;
        });
    });
}

/// Solutions of one model from several starts; keeps the best.
class BestFit {
  public:
    BestFit(const measure::Measurement& measurement, const CandidateOptions& options)
        : measurement_(measurement), options_(options) {}

    /// Goes all the way from a start.
    void try_start(const calibrate::StemModel& start, bool is_first_guess) {
        ++starts_;
        try {
            calibrate::ChainFit fit = settled(counted(
                calibrate::fit_chain(start, measurement_, fit_options(options_, is_first_guess))));
            if (!fit.has_converged)
                failure_ = fit.reason;
            else if (!best_ || fit.rmse < best_->rmse)
                best_ = std::move(fit);
        } catch (const core::NumericalError& error) {
            failure_ = error.what();
        }
    }
    /// Goes all the way from the one that is best after some iterations, and from the next if it
    /// was better then than that one is in the end.
    void try_starts(const std::vector<calibrate::StemModel>& starts, bool is_first_guess) {
        if (starts.size() == 1)
            return try_start(starts.front(), is_first_guess);
        std::vector<calibrate::ChainFit> begun;
        for (const calibrate::StemModel& start : starts) {
            calibrate::ChainFitOptions few = fit_options(options_, is_first_guess);
            few.largest_iterations = screening_iterations;
            try {
                begun.push_back(counted(calibrate::fit_chain(start, measurement_, few)));
            } catch (const core::NumericalError& error) {
                failure_ = error.what();
            }
        }
        std::ranges::stable_sort(begun, {}, &calibrate::ChainFit::rmse);
        starts_ += static_cast<int>(starts.size());
        for (const calibrate::ChainFit& fit : begun) {
            if (best_ &&
                !(fit.chi_squared <
                  best_->chi_squared - needed_gain * std::max(1.0, best_->reduced_chi_squared)))
                break;
            try_start(fit.model, false);
            --starts_;
        }
    }
    [[nodiscard]] bool is_within(double rmse) const { return best_ && best_->rmse <= rmse; }

    void store(CandidateFit& result) {
        result.starts = starts_;
        result.runs = runs_;
        if (best_)
            result.fit = std::move(best_);
        else
            result.failure = failure_;
    }

  private:
    calibrate::ChainFit counted(calibrate::ChainFit fit) {
        runs_ += fit.runs;
        return fit;
    }

    /// A solution can end early where its steps meet a bound: it begins again from there, with the
    /// parameters at a bound held, until that gains nothing.
    calibrate::ChainFit settled(calibrate::ChainFit fit) {
        for (int again = 0; again < most_restarts; ++again) {
            std::vector<bool> is_held;
            for (const calibrate::FittedParameter& parameter : fit.parameters)
                is_held.push_back(parameter.is_at_bound);
            calibrate::ChainFit next = counted(calibrate::fit_chain_with_held(
                fit.model, measurement_, is_held, fit_options(options_, false)));
            const double gain = fit.chi_squared - next.chi_squared;
            const bool is_settled = !(gain > needed_gain * std::max(1.0, next.reduced_chi_squared));
            // What is held has no covariance: the last solution without held ones is kept.
            const bool is_free = std::ranges::none_of(is_held, [](bool held) { return held; });
            if (next.has_converged && (is_free ? gain > 0.0 : !is_settled))
                fit = std::move(next);
            if (is_settled)
                break;
        }
        return fit;
    }

    const measure::Measurement& measurement_;
    const CandidateOptions& options_;
    std::optional<calibrate::ChainFit> best_;
    std::string failure_;
    int starts_ = 0;
    int runs_ = 0;
};

/// Without places to choose from there is room for a start with the usual sizes too.
std::vector<calibrate::StemModel> starts_of(const calibrate::StemModel& model,
                                            const calibrate::ChainFit& smaller) {
    std::vector<calibrate::StemModel> starts = fit_starts(model, smaller, StartSize::Absent);
    const bool has_new_size = std::ranges::any_of(model.parameters, [&](const auto& parameter) {
        return !parameter.is_place && smaller.find(parameter.access.name) == nullptr;
    });
    if (starts.size() == 1 && has_new_size)
        starts.push_back(fit_starts(model, smaller, StartSize::Default).front());
    return starts;
}

} // namespace

CandidateFit fit_baseline(const measure::Measurement& measurement,
                          const CandidateOptions& options) {
    CandidateFit result;
    result.names = {"baseline"};
    const calibrate::StemModel model = calibrate::baseline_model(measurement, options.chain);
    result.moves = measurement.release != measure::ReleaseKind::HeldStraight;
    result.starts = 1;
    if (result.moves) {
        BestFit best(measurement, options);
        best.try_start(model, true);
        best.store(result);
    } else {
        const std::vector<bool> all_held(model.free_count(), true);
        result.fit = calibrate::fit_chain_with_held(model, measurement, all_held,
                                                    fit_options(options, false));
        result.runs = result.fit->runs;
    }
    return result;
}

CandidateFit fit_candidate(const SelectedEffects& effects, const CandidateFit& smaller,
                           const measure::Measurement& measurement,
                           const CandidateOptions& options) {
    CandidateFit result;
    result.names = model_names(in_library_order(effects));
    const calibrate::StemModel baseline = calibrate::baseline_model(measurement, options.chain);
    const calibrate::StemModel model = candidate_model(baseline, effects, measurement);
    if (!smaller.fit) {
        result.failure = "the model that it contains could not be fitted: " + smaller.failure;
        return result;
    }
    if (measurement.release == measure::ReleaseKind::HeldStraight &&
        !can_move_straight_stem(model)) {
        result = smaller;
        result.names = model_names(in_library_order(effects));
        result.moves = false;
        return result;
    }
    const std::vector<calibrate::StemModel> starts =
        smaller.moves ? starts_of(model, *smaller.fit) : std::vector{model};
    const bool must_improve = smaller.moves && is_nested(model);
    const double bound = must_improve ? allowed_excess * smaller.fit->rmse : 0.0;
    BestFit best(measurement, options);
    best.try_starts(starts, !smaller.moves);
    if (must_improve ? !best.is_within(bound) : smaller.moves)
        best.try_starts(starts, true);
    best.store(result);
    if (must_improve && result.fit && result.fit->rmse > bound) {
        result.failure = fmt::format(
            "no start leads to a fit as good as that of the model it contains (rms {:.4g} mm, "
            "without it {:.4g} mm)",
            1e3 * result.fit->rmse, 1e3 * smaller.fit->rmse);
        result.fit.reset();
    }
    return result;
}

} // namespace culm::diagnose
