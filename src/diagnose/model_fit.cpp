// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/model_fit.hpp"

#include "core/error.hpp"
#include "diagnose/best_fit.hpp"
#include "diagnose/fit_starts.hpp"
#include "diagnose/joint_starts.hpp"

#include <algorithm>
#include <array>
#include <numeric>
#include <optional>
#include <string_view>
#include <utility>

namespace culm::diagnose {
namespace {

constexpr std::array<std::string_view, 3> effects_of_recordings{"tip_mass.", "finite_release.",
                                                                "base_motion."};
constexpr std::size_t most_reconciling = 4;

/// The fit of one recording as a fit of a set.
ModelFit as_model_fit(CandidateFit candidate) {
    ModelFit out;
    out.names = std::move(candidate.names);
    out.failure = std::move(candidate.failure);
    out.runs = candidate.runs;
    out.moves = candidate.moves;
    if (!candidate.fit)
        return out;
    const calibrate::ChainFit& fit = *candidate.fit;
    out.parameters = fit.parameters;
    out.places.emplace_back(fit.parameters.size());
    std::iota(out.places.front().begin(), out.places.front().end(), 0);
    out.chi_squared = fit.chi_squared;
    out.readings = fit.readings;
    out.reduced_chi_squared = fit.reduced_chi_squared;
    out.rmse = fit.rmse;
    out.parts.push_back(std::move(*candidate.fit));
    return out;
}

/// One recording's part of a fit.
CandidateFit as_candidate_fit(const ModelFit& model, std::size_t recording, bool moves) {
    CandidateFit out;
    out.names = model.names;
    out.failure = model.failure;
    out.moves = moves;
    if (model.is_fitted())
        out.fit = model.parts[recording];
    return out;
}

bool can_move(const calibrate::StemModel& model, const measure::Measurement& recording) {
    return recording.release != measure::ReleaseKind::HeldStraight || can_move_straight_stem(model);
}

std::vector<std::vector<double>> noises(std::span<const calibrate::ChainFit> fits) {
    std::vector<std::vector<double>> out;
    for (const calibrate::ChainFit& fit : fits)
        out.push_back(fit.noise);
    return out;
}

/// One model for several recordings.
class JointModel {
  public:
    JointModel(const SelectedEffects& effects, std::span<const measure::Measurement> recordings,
               const CandidateOptions& options)
        : effects_(effects), recordings_(recordings), options_(options) {
        for (const measure::Measurement& recording : recordings) {
            models_.push_back(candidate_model(calibrate::baseline_model(recording, options.chain),
                                              effects, recording));
            swings_.push_back(recorded_swing(recording, options));
        }
    }

    [[nodiscard]] bool moves() const {
        for (std::size_t m = 0; m < models_.size(); ++m)
            if (can_move(models_[m], recordings_[m]))
                return true;
        return false;
    }

    /// From each recording's own fit: the chain itself (no `smaller`), or with effects of which
    /// some move what stood still without them.
    [[nodiscard]] ModelFit fit_from_own(const ModelFit* smaller) {
        std::vector<calibrate::ChainFit> alone;
        for (std::size_t m = 0; m < recordings_.size(); ++m) {
            CandidateFit own = fit_alone(smaller, m);
            runs_ += own.runs;
            if (!own.fit)
                return failed(recordings_[m].stem.id + " alone: " + own.failure);
            alone.push_back(std::move(*own.fit));
        }
        BestFit best(recordings_, options_, noises(alone));
        best.try_starts(shared_starts(models_, alone, swings_), false);
        return told(best);
    }

    /// From a joint fit with fewer effects.
    [[nodiscard]] ModelFit fit_from(const ModelFit& smaller) {
        BestFit best(recordings_, options_, noises(smaller.parts));
        best.try_larger(starts_from(smaller), smaller.parts, is_nested(models_.front()));
        return told(best);
    }

    /// Does a recording move that stood still in `smaller`?
    [[nodiscard]] bool moves_more_than(const ModelFit& smaller) const {
        for (std::size_t m = 0; m < models_.size(); ++m)
            if (can_move(models_[m], recordings_[m]) &&
                !can_move(smaller.parts[m].model, recordings_[m]))
                return true;
        return false;
    }

  private:
    [[nodiscard]] CandidateFit fit_alone(const ModelFit* smaller, std::size_t m) const {
        if (smaller == nullptr)
            return fit_baseline(recordings_[m], options_);
        const bool moved = can_move(smaller->parts[m].model, recordings_[m]);
        return fit_candidate(effects_, as_candidate_fit(*smaller, m, moved), recordings_[m],
                             options_);
    }

    /// candidate_starts of each recording side by side, then those that reconcile recordings which
    /// disagree.
    [[nodiscard]] std::vector<JointStart> starts_from(const ModelFit& smaller) const {
        std::vector<std::vector<calibrate::StemModel>> own;
        std::size_t count = 0;
        for (std::size_t m = 0; m < models_.size(); ++m) {
            own.push_back(candidate_starts(models_[m], smaller.parts[m]));
            count = std::max(count, own.back().size());
        }
        std::vector<JointStart> starts;
        std::vector<JointStart> reconciling;
        for (std::size_t k = 0; k < count; ++k) {
            JointStart& start = starts.emplace_back();
            for (const std::vector<calibrate::StemModel>& each : own)
                start.push_back(each[k % each.size()]);
            if (reconciling.size() < most_reconciling)
                for (JointStart& other : reconciling_starts(start, smaller.parts, swings_))
                    reconciling.push_back(std::move(other));
        }
        std::ranges::move(reconciling, std::back_inserter(starts));
        return starts;
    }

    [[nodiscard]] ModelFit failed(std::string why) const {
        ModelFit out;
        out.failure = std::move(why);
        out.runs = runs_;
        return out;
    }

    [[nodiscard]] ModelFit told(BestFit& best) {
        runs_ += best.runs();
        std::optional<calibrate::JointFit> fit = best.take();
        if (!fit)
            return failed(best.failure());
        ModelFit out;
        out.parts = std::move(fit->parts);
        out.parameters = std::move(fit->parameters);
        out.places = std::move(fit->places);
        out.chi_squared = fit->chi_squared;
        out.readings = fit->readings;
        out.reduced_chi_squared = fit->reduced_chi_squared;
        out.rmse = fit->rmse;
        out.runs = runs_;
        return out;
    }

    const SelectedEffects& effects_;
    std::span<const measure::Measurement> recordings_;
    const CandidateOptions& options_;
    JointStart models_;
    std::vector<RecordedSwing> swings_;
    int runs_ = 0;
};

ModelFit fit_set(const SelectedEffects& effects, const ModelFit& smaller,
                 std::span<const measure::Measurement> recordings,
                 const CandidateOptions& options) {
    JointModel model(effects, recordings, options);
    ModelFit fit;
    if (effects.empty())
        fit = model.fit_from_own(nullptr);
    else if (!smaller.is_fitted())
        fit.failure = "the model that it contains could not be fitted: " + smaller.failure;
    else if (!model.moves())
        fit = smaller;
    else
        fit =
            model.moves_more_than(smaller) ? model.fit_from_own(&smaller) : model.fit_from(smaller);
    fit.moves = model.moves();
    return fit;
}

} // namespace

bool belongs_to_recording(const std::string& parameter) {
    return parameter == "tip_deflection" || parameter == calibrate::release_time_name ||
           std::ranges::any_of(effects_of_recordings, [&](std::string_view beginning) {
               return parameter.starts_with(beginning);
           });
}

ModelFit fit_model(const SelectedEffects& effects, const ModelFit& smaller,
                   std::span<const measure::Measurement> recordings,
                   const CandidateOptions& options) {
    ModelFit fit;
    try {
        if (recordings.size() > 1)
            fit = fit_set(effects, smaller, recordings, options);
        else if (effects.empty())
            fit = as_model_fit(fit_baseline(recordings.front(), options));
        else
            fit = as_model_fit(fit_candidate(effects, as_candidate_fit(smaller, 0, smaller.moves),
                                             recordings.front(), options));
    } catch (const core::InputError& error) {
        fit.failure = error.what();
    } catch (const core::NumericalError& error) {
        fit.failure = error.what();
    }
    fit.names = model_names(in_library_order(effects));
    return fit;
}

} // namespace culm::diagnose
