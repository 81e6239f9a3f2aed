// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/fit_plan.hpp"

#include "core/error.hpp"
#include "diagnose/fit_starts.hpp"

#include <algorithm>
#include <limits>
#include <numeric>
#include <optional>
#include <utility>

#include <nlohmann/json.hpp>

namespace culm::diagnose {
namespace {

using nlohmann::json;

constexpr std::size_t most_reconciling = 4;

std::vector<std::vector<double>> noises(std::span<const calibrate::ChainFit> fits) {
    std::vector<std::vector<double>> out;
    for (const calibrate::ChainFit& fit : fits)
        out.push_back(fit.noise);
    return out;
}

/// A single recording's own noise says it all.
std::vector<std::vector<double>> weights_beside(const ModelFit& smaller) {
    return smaller.parts.size() > 1 ? noises(smaller.parts) : std::vector<std::vector<double>>{};
}

/// The fit of one recording as a fit of a set.
ModelFit as_model_fit(CandidateFit candidate) {
    ModelFit out;
    out.failure = std::move(candidate.failure);
    out.runs = candidate.runs;
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

ModelFit told(BestFit& best) {
    ModelFit out;
    out.runs = best.runs();
    std::optional<calibrate::JointFit> fit = best.take();
    if (!fit) {
        out.failure = best.failure();
        return out;
    }
    out.parts = std::move(fit->parts);
    out.parameters = std::move(fit->parameters);
    out.places = std::move(fit->places);
    out.chi_squared = fit->chi_squared;
    out.readings = fit->readings;
    out.reduced_chi_squared = fit->reduced_chi_squared;
    out.rmse = fit->rmse;
    out.out_of_reach = fit->out_of_reach;
    return out;
}

/// What a model or its fit throws if it cannot be; empty if it can.
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

std::string to_text(const BegunFit& begun, int runs) {
    json values = json::array();
    for (const calibrate::StemModel& model : begun.models) {
        json own = json::array({model.release_time});
        for (const calibrate::FreeParameter& parameter : model.parameters)
            own.push_back(parameter.access.get(model.spec));
        values.push_back(std::move(own));
    }
    return json{std::move(values), begun.weighted_rms, begun.chi_squared, runs}.dump();
}

/// Adds to `runs` those that the text tells of.
BegunFit begun_from(const std::string& text, const JointStart& start, int& runs) {
    const json read = json::parse(text);
    BegunFit begun{start, read[1], read[2]};
    for (std::size_t m = 0; m < begun.models.size(); ++m) {
        calibrate::StemModel& model = begun.models[m];
        model.release_time = read[0][m][0];
        for (std::size_t k = 0; k < model.parameters.size(); ++k)
            model.parameters[k].access.set(model.spec, read[0][m][k + 1]);
    }
    runs += read[3].get<int>();
    return begun;
}

} // namespace

FitPlan::FitPlan(const SelectedEffects& effects, const ModelFit& smaller,
                 std::span<const measure::Measurement> recordings, const CandidateOptions& options)
    : effects_(effects), smaller_(smaller), recordings_(recordings) {
    failure_ = failure_of([&] {
        for (const measure::Measurement& recording : recordings)
            models_.push_back(candidate_model(calibrate::baseline_model(recording, options.chain),
                                              effects, recording));
        if (recordings.size() > 1)
            for (const measure::Measurement& recording : recordings)
                swings_.push_back(recorded_swing(recording, options));
        if (!effects_.empty() && smaller.is_fitted() && moves() && !moves_more())
            starts_ = larger_starts();
    });
}

std::string FitPlan::begin(std::size_t k, const CandidateOptions& options) const {
    std::string text;
    (void)failure_of([&] { // the other starts may lead somewhere
        BestFit best(recordings_, options, weights_beside(smaller_));
        const BegunFit begun = best.begin(starts_[k], false);
        text = to_text(begun, best.runs());
    });
    return text;
}

double FitPlan::chi_squared_of(const std::string& begun) {
    return begun.empty() ? std::numeric_limits<double>::infinity()
                         : json::parse(begun)[2].get<double>();
}

ModelFit FitPlan::finish(const std::vector<std::string>& begun,
                         const CandidateOptions& options) const {
    ModelFit fit;
    fit.failure = failure_;
    if (failure_.empty()) {
        std::string failure = failure_of([&] { fit = fitted(begun, options); });
        if (!failure.empty())
            fit.failure = std::move(failure);
        fit.moves = moves();
    }
    fit.names = model_names(in_library_order(effects_));
    return fit;
}

ModelFit FitPlan::fitted(const std::vector<std::string>& begun,
                         const CandidateOptions& options) const {
    if (effects_.empty())
        return recordings_.size() > 1 ? fit_from_own(options)
                                      : as_model_fit(fit_baseline(recordings_.front(), options));
    if (!smaller_.is_fitted()) {
        ModelFit none;
        none.failure = "the model that it contains could not be fitted: " + smaller_.failure;
        return none;
    }
    if (!moves())
        return smaller_;
    if (!starts_.empty())
        return fit_from_starts(begun, options);
    return recordings_.size() > 1 ? fit_from_own(options) : fit_alone(0, options);
}

bool FitPlan::moves() const {
    for (std::size_t m = 0; m < models_.size(); ++m)
        if (can_move(models_[m], recordings_[m]))
            return true;
    return false;
}

/// Does a recording move that stood still in `smaller`?
bool FitPlan::moves_more() const {
    for (std::size_t m = 0; m < models_.size(); ++m)
        if (can_move(models_[m], recordings_[m]) &&
            !can_move(smaller_.parts[m].model, recordings_[m]))
            return true;
    return false;
}

/// candidate_starts of each recording side by side, then those that reconcile recordings which
/// disagree.
std::vector<JointStart> FitPlan::larger_starts() const {
    std::vector<std::vector<calibrate::StemModel>> own;
    std::size_t count = 0;
    for (std::size_t m = 0; m < models_.size(); ++m) {
        own.push_back(candidate_starts(models_[m], smaller_.parts[m]));
        count = std::max(count, own.back().size());
    }
    std::vector<JointStart> starts;
    std::vector<JointStart> reconciling;
    for (std::size_t k = 0; k < count; ++k) {
        JointStart& start = starts.emplace_back();
        for (const std::vector<calibrate::StemModel>& each : own)
            start.push_back(each[k % each.size()]);
        if (recordings_.size() > 1 && reconciling.size() < most_reconciling)
            for (JointStart& other : reconciling_starts(start, smaller_.parts, swings_))
                reconciling.push_back(std::move(other));
    }
    std::ranges::move(reconciling, std::back_inserter(starts));
    return starts;
}

/// One recording by itself: the chain, or what makes it move where it stood still without it.
ModelFit FitPlan::fit_alone(std::size_t recording, const CandidateOptions& options) const {
    const measure::Measurement& own = recordings_[recording];
    if (effects_.empty())
        return as_model_fit(fit_baseline(own, options));
    CandidateFit smaller;
    smaller.names = smaller_.names;
    smaller.moves = can_move(smaller_.parts[recording].model, own);
    smaller.fit = smaller_.parts[recording];
    CandidateOptions to_the_end = options; // what is wanted is wanted of all recordings
    to_the_end.wanted_chi_squared.reset();
    return as_model_fit(fit_candidate(effects_, smaller, own, to_the_end));
}

/// From each recording's own fit.
ModelFit FitPlan::fit_from_own(const CandidateOptions& options) const {
    std::vector<calibrate::ChainFit> alone;
    int runs = 0;
    for (std::size_t m = 0; m < recordings_.size(); ++m) {
        ModelFit own = fit_alone(m, options);
        runs += own.runs;
        if (!own.is_fitted()) {
            own.failure = recordings_[m].stem.id + " alone: " + own.failure;
            own.runs = runs;
            return own;
        }
        alone.push_back(std::move(own.parts.front()));
    }
    BestFit best(recordings_, options, noises(alone));
    best.try_starts(shared_starts(models_, alone, swings_), false);
    ModelFit fit = told(best);
    fit.runs += runs;
    return fit;
}

ModelFit FitPlan::fit_from_starts(const std::vector<std::string>& begun,
                                  const CandidateOptions& options) const {
    std::optional<std::vector<BegunFit>> from;
    int runs = 0;
    if (start_count() > 0) {
        from.emplace();
        for (std::size_t k = 0; k < begun.size(); ++k)
            if (!begun[k].empty())
                from->push_back(begun_from(begun[k], starts_[k], runs));
    }
    BestFit best(recordings_, options, weights_beside(smaller_));
    best.try_larger(starts_, std::move(from), smaller_.parts, is_nested(models_.front()));
    ModelFit fit = told(best);
    fit.runs += runs;
    return fit;
}

ModelFit refined(const JointStart& start, const SelectedEffects& effects, const ModelFit& smaller,
                 std::span<const measure::Measurement> recordings,
                 const CandidateOptions& options) {
    BestFit best(recordings, options, weights_beside(smaller));
    best.try_larger({start}, std::nullopt, smaller.parts, is_nested(start.front()));
    ModelFit fit = told(best);
    fit.names = model_names(in_library_order(effects));
    return fit;
}

} // namespace culm::diagnose
