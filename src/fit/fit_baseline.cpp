// SPDX-License-Identifier: BSD-3-Clause
#include "fit/fit_model.hpp"
#include "fit/fit_numbers.hpp"
#include "fit/solve/reading_errors.hpp"

#include <algorithm>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace culm::fit {
namespace {

/// The chain with the noise and the errors of `known`, from the fits without them. `exact` is the
/// fit of all recordings without either.
BaselineFit fit_chain_to(std::vector<ObservedRecording> known, std::vector<RecordingFit> alone,
                         std::optional<Fit> exact, const FitOptions& options) {
    BaselineFit out{std::move(known), {}, {}, std::move(alone)};
    const std::vector<ObservedRecording> stated = with_inputs_as_stated(out.recordings);
    const bool is_exact = exact && !stated.front().errors && !stated.front().noise_model;
    out.stated = is_exact ? *std::move(exact) : fit_again({}, out.alone, stated, options);
    // The terms are linearised about each recording's own fit. Where recordings disagree, a joint
    // fit may be cycles away from it.
    const bool is_one = stated.size() == 1 && !out.stated.failed();
    if (is_one && !is_exact)
        out.recordings = with_reading_errors(out.recordings, out.stated.parts, options.heartbeat);
    out.fit = fit_again({}, is_one ? out.stated.parts : out.alone, out.recordings, options);
    if (out.fit.failed())
        out.fit = out.stated;
    out.fit.runs += out.stated.runs;
    if (!out.stated.failed())
        add_input_uncertainty(out.recordings, out.fit.reduced_chi_squared, out.stated);
    return out;
}

/// The largest fitted model within `effects`; the chain itself if there is none.
const Fit& model_within(const SelectedEffects& effects, const std::vector<Fit>& models) {
    const Fit* within = &models.front();
    for (const Fit& model : models)
        if (!model.failed() && std::ranges::all_of(model.effects, [&](const auto& each) {
                return contains(effects, each);
            }))
            within = &model;
    return *within;
}

/// The last model that could be fitted and in which the stem moves; null if there is none.
const Fit* last_moving(const std::vector<Fit>& models) {
    const auto last = std::find_if(models.rbegin(), models.rend(), [](const Fit& model) {
        return !model.failed() && model.moves();
    });
    return last == models.rend() ? nullptr : &*last;
}

/// Linearises the error terms about `stated`, fits the model together with them, and adds their
/// contribution to the intervals of `stated`.
ModelFit judged_model(Fit stated, std::span<const ObservedRecording> recordings,
                      const FitOptions& options) {
    if (stated.failed() || !stated.moves())
        return {stated, stated};
    const std::vector<ObservedRecording> known =
        with_reading_errors(recordings, stated.parts, options.heartbeat);
    ModelFit out{std::move(stated), {}};
    out.judged = fit_again(out.stated.effects, out.stated.parts, known, options);
    if (out.judged.failed()) // the inputs diverge if the model is far off
        out.judged = out.stated;
    out.judged.runs += out.stated.runs;
    add_input_uncertainty(known, out.judged.reduced_chi_squared, out.stated);
    return out;
}

} // namespace

Fit as_stated(const Fit& judged, const Fit& smaller, std::span<const ObservedRecording> recordings,
              const FitOptions& options) {
    if (judged.effects.empty())
        return smaller;
    if (judged.failed() || !judged.moves())
        return judged;
    const std::vector<ObservedRecording> exact = with_inputs_as_stated(recordings);
    StartModels start = models_of(judged, recordings, options);
    for (std::size_t m = 0; m < start.size(); ++m) {
        const run::CaseSpec computed = case_beside_errors(start[m]);
        start[m] = beside_errors(std::move(start[m]), exact[m]);
        const run::CaseSpec unchanged = case_beside_errors(start[m]);
        for (const auto member : {&physics::StemParameters<double>::bond_youngs_modulus,
                                  &physics::StemParameters<double>::bond_damping})
            if (unchanged.stem.*member > 0.0)
                start[m].spec.stem.*member *= computed.stem.*member / unchanged.stem.*member;
    }
    Fit stated = refined(start, judged.effects, smaller, exact, options);
    if (stated.failed())
        stated = fit_with_parts(judged.effects, smaller, exact, options);
    if (!stated.failed())
        add_input_uncertainty(with_reading_errors(recordings, stated.parts, options.heartbeat),
                              judged.reduced_chi_squared, stated);
    return stated;
}

BaselineFit fit_baseline(std::span<const measure::Measurement> measurements,
                         const FitOptions& options) {
    const std::vector<ObservedRecording> recordings = observed(measurements);
    BaselineFit out{recordings, {}, {}};
    std::vector<RecordingFit> alone;
    const bool is_one = recordings.size() == 1;
    std::optional<Fit> exact;
    int runs = 0;
    for (const ObservedRecording& recording : recordings) {
        Fit own = fit_model({}, {}, {&recording, 1}, options);
        runs += own.runs;
        if (own.failed() || !own.moves()) {
            out.stated = is_one ? std::move(own) : fit_model({}, {}, recordings, options);
            out.fit = out.stated;
            return out;
        }
        alone.push_back(own.parts.front());
        if (is_one)
            exact = std::move(own);
    }
    std::vector<ObservedRecording> known =
        with_reading_errors(recordings, alone, options.heartbeat);
    out = fit_chain_to(std::move(known), std::move(alone), std::move(exact), options);
    out.fit.runs += is_one ? 0 : runs;
    return out;
}

std::optional<BaselineFit>
baseline_beside_noise_of(const Fit& larger, const BaselineFit& baseline,
                         std::span<const measure::Measurement> measurements,
                         const FitOptions& options) {
    if (baseline.alone.empty() || larger.failed())
        return std::nullopt;
    const std::vector<ObservedRecording> recordings = observed(measurements);
    std::vector<ObservedRecording> known = baseline.recordings;
    bool is_other = false;
    for (std::size_t m = 0; m < known.size(); ++m) {
        RecordingFit own = larger.parts[m]; // with the noise that was stated or measured at rest
        if (ReadingNoise noise = reading_noise(recordings[m]); !noise.by_row.empty()) {
            own.noise = std::move(noise.by_row);
            own.noise_source = std::move(noise.source);
        }
        known[m] = with_noise_in_motion(own, recordings[m]);
        known[m].errors = baseline.recordings[m].errors;
        is_other = is_other || !has_same_noise(known[m], baseline.recordings[m]);
    }
    if (!is_other)
        return std::nullopt;
    return fit_chain_to(std::move(known), baseline.alone, std::nullopt, options);
}

NestedFits fit_nested(std::span<const measure::Measurement> measurements,
                      const std::vector<SelectedEffects>& effect_sets, const FitOptions& options) {
    for (const measure::Measurement& recording : measurements) { // throws if a model is invalid
        const StemModel chain = baseline_model(recording, options.chain);
        for (const SelectedEffects& effects : effect_sets)
            static_cast<void>(candidate_model(chain, effects, recording));
    }
    BaselineFit baseline = fit_baseline(measurements, options);
    std::vector<ObservedRecording> exact = with_inputs_as_stated(baseline.recordings);
    std::vector<Fit> stated{baseline.stated};
    for (const SelectedEffects& effects : effect_sets)
        stated.push_back(fit_with_parts(effects, model_within(effects, stated), exact, options));
    // The first estimate of the noise may contain the missing effect.
    const Fit* const last = last_moving(stated);
    std::optional<BaselineFit> again;
    if (last != nullptr && baseline.alone.empty()) {
        again = baseline;
        again->recordings =
            with_reading_errors(observed(measurements), last->parts, options.heartbeat);
    } else if (last != nullptr && !last->effects.empty()) {
        again = baseline_beside_noise_of(*last, baseline, measurements, options);
    }
    if (again && !again->fit.failed()) {
        baseline = *std::move(again);
        exact = with_inputs_as_stated(baseline.recordings);
        for (std::size_t k = 1; k < stated.size(); ++k)
            if (!stated[k].failed() && stated[k].moves())
                stated[k] = fit_again(stated[k].effects, stated[k].parts, exact, options);
    }
    NestedFits out{std::move(baseline.recordings),
                   {{std::move(baseline.stated), std::move(baseline.fit)}}};
    for (std::size_t k = 1; k < stated.size(); ++k)
        out.models.push_back(judged_model(std::move(stated[k]), out.recordings, options));
    return out;
}

} // namespace culm::fit
