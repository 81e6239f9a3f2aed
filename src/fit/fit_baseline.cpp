// SPDX-License-Identifier: BSD-3-Clause
#include "core/error.hpp"
#include "fit/errors/terms.hpp"
#include "fit/fit_model.hpp"
#include "fit/fit_numbers.hpp"
#include "fit/noise/reading_noise.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <span>
#include <utility>
#include <vector>

namespace culm::fit {
namespace {

/// The error terms of a recording about its own fit, which is fitted again with them.
Fit fit_with_terms(Fit fit, ObservedRecording& recording, const FitOptions& options) {
    auto terms = std::make_shared<std::vector<ErrorTerm>>();
    auto fitted = std::make_shared<ReadingErrors>();
    std::vector<double> known;
    try {
        Division division =
            division_of(fit.parts.front(), recording.noise_model.get(), options.heartbeat);
        fit.batches += division.batches;
        known = std::move(division.known);
        if (division.doubt)
            terms->push_back(*std::move(division.doubt));
    } catch (const core::NumericalError& error) { // the chain itself can be computed
        recording.missing_terms.push_back(fmt::format(
            "The division into spheres counts as exact, because the finer chain fails: {}",
            error.what()));
    }
    for (const std::vector<ErrorTerm>& some :
         {release_terms(fit, recording), place_terms(fit.parts.front(), recording),
          sensor_terms(recording)})
        for (const ErrorTerm& term : some)
            (term.is_fitted() ? fitted->terms : *terms).push_back(term);
    fitted->times = fit.parts.front().times;
    fitted->known = known;
    recording.terms = std::move(terms);
    if (!fitted->known.empty() || !fitted->terms.empty())
        recording.errors = std::move(fitted);
    return fit_again(fit, {}, {&recording, 1}, options, {known});
}

/// Standard uncertainty of a parameter's logarithm by the stated inputs of one recording alone.
double uncertainty_by_inputs(const Fit& fit, const physics::ParameterId& id) {
    const auto found = std::ranges::find(fit.parameters, id, &FittedParameter::id);
    double sum = 0.0;
    for (const Pull& pull : fit.pulls)
        if (found != fit.parameters.end() && pull.kind == ErrorKind::StatedInput)
            sum += std::pow(pull.changes[static_cast<std::size_t>(found - fit.parameters.begin())] /
                                found->value,
                            2);
    return std::sqrt(sum);
}

/// Factors of Y and β for one of several recordings.
void add_factors(const Fit& alone, ObservedRecording& recording) {
    auto errors = recording.errors ? std::make_shared<ReadingErrors>(*recording.errors)
                                   : std::make_shared<ReadingErrors>();
    if (const double u = uncertainty_by_inputs(alone, physics::bond_youngs_modulus); u > 0.0)
        errors->terms.push_back(
            {ErrorKind::Modulus, "modulus of the chain of " + recording.stem.id, {}, u, 0.0});
    if (const double u = uncertainty_by_inputs(alone, physics::bond_damping); u > 0.0)
        errors->terms.push_back(
            {ErrorKind::Damping, "damping of the chain of " + recording.stem.id, {}, 0.0, u});
    recording.errors = std::move(errors);
}

/// All recordings together, from each one's own fit: the factors keep its Y and β at the start.
Fit fit_together(const std::vector<Fit>& alone, const std::vector<ObservedRecording>& recordings,
                 const FitOptions& options) {
    StartModels start;
    Fit smaller; // for its noise
    smaller.own_weighted_rms = std::numeric_limits<double>::infinity();
    int batches = 0;
    double log_modulus = 0.0;
    for (const Fit& each : alone)
        log_modulus +=
            std::log(each.parts.front().model.spec.stem.bond_youngs_modulus) / double(alone.size());
    for (std::size_t m = 0; m < alone.size(); ++m) {
        StemModel& model =
            start.emplace_back(with_error_terms(alone[m].parts.front().model, recordings[m]));
        for (std::size_t k = model.first_error(); k < model.free_count(); ++k)
            if (const ErrorTerm& term = model.error_term(k); term.kind == ErrorKind::Modulus)
                model.set_value(k, (std::log(model.spec.stem.bond_youngs_modulus) - log_modulus) /
                                       term.log_modulus);
        model.spec.stem.bond_youngs_modulus = std::exp(log_modulus);
        smaller.parts.push_back(alone[m].parts.front());
        batches += alone[m].batches;
    }
    Fit fit = fit_near({start}, {}, smaller, recordings, options);
    fit.batches += batches;
    return fit;
}

/// The baseline from fits of the chain to each recording with its noise.
BaselineFit baseline_of(std::vector<Fit> alone, std::vector<ObservedRecording> recordings,
                        const FitOptions& options) {
    for (std::size_t m = 0; m < recordings.size(); ++m)
        alone[m] = fit_with_terms(std::move(alone[m]), recordings[m], options);
    const auto failed = std::ranges::find_if(alone, &Fit::failed);
    if (failed != alone.end())
        return {std::move(recordings), *failed};
    if (recordings.size() == 1)
        return {std::move(recordings), std::move(alone.front())};
    for (std::size_t m = 0; m < recordings.size(); ++m)
        add_factors(alone[m], recordings[m]);
    Fit fit = fit_together(alone, recordings, options);
    return {std::move(recordings), std::move(fit)};
}

} // namespace

BaselineFit fit_baseline(std::span<const measure::Measurement> measurements,
                         const FitOptions& options) {
    std::vector<ObservedRecording> recordings = observed(measurements);
    std::vector<Fit> alone;
    FitOptions first = options; // the terms are computed about the fit with the noise in motion
    first.with_inputs = false;
    for (ObservedRecording& recording : recordings) {
        Fit own = fit_model({}, {}, {&recording, 1}, first);
        if (own.failed() || !own.moves()) {
            if (recordings.size() > 1)
                own = fit_model({}, {}, recordings, options);
            return {observed(measurements), std::move(own)};
        }
        recording = with_noise_in_motion(own.parts.front(), recording);
        own = fit_again(own, {}, {&recording, 1}, options);
        if (own.failed())
            return {observed(measurements), std::move(own)};
        alone.push_back(std::move(own));
    }
    return baseline_of(std::move(alone), std::move(recordings), options);
}

StartModels with_chain(const Fit& numbers, std::span<const ObservedRecording> from,
                       const FitOptions& from_options,
                       std::span<const ObservedRecording> recordings, const FitOptions& options) {
    StartModels models = models_of(numbers, from, from_options);
    for (std::size_t m = 0; m < models.size(); ++m) {
        const StemChain chain = chain_of(recordings[m], options.chain);
        models[m] = with_error_terms(
            with_spheres(std::move(models[m]), chain.spec.stem.sphere_count), recordings[m]);
    }
    return models;
}

BaselineFit baseline_with_chain(const BaselineFit& other, const FitOptions& from,
                                std::span<const measure::Measurement> measurements,
                                const FitOptions& options) {
    if (!other.fit.moves()) // there is no fit to start from
        return fit_baseline(measurements, options);
    std::vector<ObservedRecording> recordings = observed(measurements);
    std::vector<Fit> alone;
    for (std::size_t m = 0; m < recordings.size(); ++m) {
        recordings[m].noise_model = other.recordings[m].noise_model;
        Fit numbers;
        numbers.parameters = other.fit.parts[m].parameters;
        alone.push_back(fit_near(
            {with_chain(numbers, {&other.recordings[m], 1}, from, {&recordings[m], 1}, options)},
            {}, {}, {&recordings[m], 1}, options));
        if (alone.back().failed())
            return {std::move(recordings), std::move(alone.back())};
    }
    return baseline_of(std::move(alone), std::move(recordings), options);
}

std::optional<BaselineFit>
baseline_with_noise_about(const Fit& larger, const BaselineFit& baseline,
                          std::span<const measure::Measurement> measurements,
                          const FitOptions& options) {
    if (larger.failed() || !larger.moves())
        return std::nullopt;
    const std::vector<ObservedRecording> recordings = observed(measurements);
    BaselineFit out{baseline.recordings, {}};
    bool is_other = false;
    for (std::size_t m = 0; m < recordings.size(); ++m) {
        RecordingFit own = larger.parts[m]; // with the noise that was stated or measured at rest
        if (ReadingNoise noise = reading_noise(recordings[m]); !noise.by_row.empty()) {
            own.noise = std::move(noise.by_row);
            own.noise_source = std::move(noise.source);
        }
        const ObservedRecording known = with_noise_in_motion(own, recordings[m]);
        is_other = is_other || !has_same_noise(known, baseline.recordings[m]);
        out.recordings[m].noise_model = known.noise_model;
    }
    if (!is_other)
        return std::nullopt;
    if (!baseline.fit.moves()) {
        out.fit = fit_model({}, {}, out.recordings, options);
        return out;
    }
    out.fit = fit_again(baseline.fit, {}, out.recordings, options);
    out.fit.batches -= baseline.fit.batches;
    return out;
}

} // namespace culm::fit
