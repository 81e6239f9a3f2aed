// SPDX-License-Identifier: BSD-3-Clause
#include "fit/fit_model.hpp"
#include "fit/fit_numbers.hpp"
#include "fit/solve/reading_errors.hpp"
#include "run/modes.hpp"

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

/// Changes Y and β of the model so that the case which it computes has those of `wanted`.
void compute_with(const physics::StemParameters<double>& wanted, StemModel& model) {
    const physics::StemParameters<double> now = case_beside_errors(model).stem;
    for (const auto member : {&physics::StemParameters<double>::bond_youngs_modulus,
                              &physics::StemParameters<double>::bond_damping})
        if (now.*member > 0.0)
            model.spec.stem.*member *= wanted.*member / now.*member;
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
        const physics::StemParameters<double> computed = case_beside_errors(start[m]).stem;
        start[m] = beside_errors(std::move(start[m]), exact[m]);
        compute_with(computed, start[m]);
    }
    Fit stated = refined(start, judged.effects, smaller, exact, options);
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

StartModels with_chain(const Fit& numbers, std::span<const ObservedRecording> from,
                       const FitOptions& from_options,
                       std::span<const ObservedRecording> recordings, const FitOptions& options) {
    const StartModels before = models_of(numbers, from, from_options);
    StartModels models = models_of(numbers, recordings, options);
    for (std::size_t m = 0; m < models.size(); ++m) {
        const auto modes = run::chain_modes(case_beside_errors(before[m]), 1);
        if (modes.empty())
            continue;
        StemModel computed = models[m];
        computed.spec = case_beside_errors(models[m]);
        keep_first_mode(modes.front(), computed);
        compute_with(computed.spec.stem, models[m]);
    }
    return models;
}

BaselineFit baseline_with_chain(const BaselineFit& other, const FitOptions& from,
                                std::span<const measure::Measurement> measurements,
                                const FitOptions& options) {
    if (other.alone.empty()) // nothing moves: there is no fit to start from
        return fit_baseline(measurements, options);
    std::vector<ObservedRecording> recordings = observed(measurements);
    std::vector<RecordingFit> alone;
    for (std::size_t m = 0; m < recordings.size(); ++m) {
        const std::span<const ObservedRecording> own(&recordings[m], 1);
        Fit numbers;
        numbers.parameters = other.alone[m].parameters;
        alone.push_back(fit_chain_with_held(with_chain(numbers, own, from, own, options).front(),
                                            recordings[m], {}, options.solve()));
    }
    recordings = with_reading_errors(recordings, alone, options.heartbeat);
    for (std::size_t m = 0; m < recordings.size(); ++m)
        recordings[m].noise_model = other.recordings[m].noise_model;
    return fit_chain_to(std::move(recordings), std::move(alone), std::nullopt, options);
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

} // namespace culm::fit
