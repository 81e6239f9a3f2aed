// SPDX-License-Identifier: BSD-3-Clause
#include "fit/fit.hpp"

#include "core/error.hpp"
#include "fit/errors/stated_inputs.hpp"
#include "fit/errors/terms.hpp"
#include "fit/noise/reading_noise.hpp"
#include "fit/solve/error_solution.hpp"
#include "physics/effects/library.hpp"
#include "run/modes.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string>
#include <tuple>
#include <utility>

#include <fmt/core.h>

namespace culm::fit {
namespace {

/// Used for recordings of unknown noise until their residuals determine it. One value for all rows
/// of a camera: a common factor of the weights changes no least-squares solution.
constexpr double provisional_noise = 1e-3; // m
constexpr double provisional_share = 0.01; ///< of a sensor's rms reading, likewise

std::vector<double> provisional_noises(const measure::Measurement& measurement) {
    const std::size_t rows = measurement.heights.size();
    std::vector<double> noises(rows, provisional_noise);
    for (std::size_t j = 0; j < measurement.sensors.size(); ++j)
        noises[j] = provisional_share * measurement.rms_reading(j);
    return noises;
}

/// A chain that follows no motion from time 0 on, which is long before the record begins.
std::string doubt_of_release(const Fit& fit, std::span<const ObservedRecording> measurements) {
    for (std::size_t m = 0; m < measurements.size(); ++m) {
        const RecordingFit& part = fit.parts[m];
        const double first = measurements[m].times.front();
        if (measurements[m].release == measure::ReleaseKind::Moving || part.readings == 0 ||
            !(first > 1.0 / run::lightly_damped_mode(part.model.spec).frequency))
            continue;
        double squares = 0.0;
        for (std::size_t at = 0; at < part.residuals.size(); ++at)
            if (!std::isnan(part.residuals[at]))
                squares += std::pow(measurements[m].deflections[at], 2);
        if (!(part.rmse < small_remainder * std::sqrt(squares / double(part.readings))))
            return fmt::format("the chain does not follow the motion, and the record begins {:.3g} "
                               "s after time 0: time 0 is not the release (let the fit begin later "
                               "with kind = \"moving\" and start_s)",
                               first);
    }
    return {};
}

/// The noise by which the residuals of each recording are divided.
std::vector<ReadingNoise> noises_of(std::span<const ObservedRecording> measurements,
                                    const JointOptions& options) {
    std::vector<ReadingNoise> noises;
    for (std::size_t m = 0; m < measurements.size(); ++m) {
        noises.push_back(reading_noise(measurements[m]));
        if (!noises.back().by_row.empty())
            continue;
        noises.back() = {m < options.noise.size() ? options.noise[m]
                                                  : provisional_noises(measurements[m]),
                         "residuals", false};
    }
    return noises;
}

RecordingFit part_of(JointSolution& solution, std::size_t m, ReadingNoise noise,
                     const ObservedRecording& measurement) {
    RecordingFit part;
    part.model = std::move(solution.models[m]);
    part.prediction = std::move(solution.predictions[m]);
    part.times = std::move(solution.times[m]);
    part.noise = std::move(noise.by_row);
    part.noise_source = std::move(noise.source);
    part.is_noise_known = noise.is_known;
    part.noise_model = measurement.noise_model;
    return part;
}

/// (joint parameters) that keep their values.
std::vector<bool> held_numbers(const JointLayout& layout, const JointOptions& options) {
    std::vector<bool> is_held;
    for (const physics::ParameterId& id : layout.ids)
        is_held.push_back(options.is_held || (id.is_of_effect() &&
                                              std::ranges::find(options.held_effects, id.effect) !=
                                                  options.held_effects.end()));
    return is_held;
}

/// The terms of a part in the linear solution. A chain that cannot be computed with an input
/// changed a little has none of the inputs, and says so.
void add_terms(const ObservedRecording& recording, const JointOptions& options,
               std::vector<ErrorTerm> inputs, RecordingFit& part, int& batches) {
    if (!can_move(part.model, recording))
        return;
    part.missing_terms = recording.missing_terms;
    if (options.with_inputs) {
        try {
            part.terms = inputs.empty() ? input_terms(part, recording, options.heartbeat, batches)
                                        : std::move(inputs);
        } catch (const core::NumericalError& error) {
            part.missing_terms.push_back(fmt::format(
                "The stated inputs count as exact: a chain with a changed one fails ({})",
                error.what()));
        }
        try {
            std::ranges::move(second_mode_terms(part, recording), std::back_inserter(part.terms));
        } catch (const core::NumericalError& error) {
            part.missing_terms.push_back(
                fmt::format("The second mode counts as exact: it fails ({})", error.what()));
        }
    }
    if (recording.terms)
        part.terms.insert(part.terms.end(), recording.terms->begin(), recording.terms->end());
}

/// A parameter is at a bound within this share of its value.
constexpr double nearness = 1e-6;
constexpr double rounding = 1e-12; ///< likewise of its range, which may span many decades

bool is_near(const FittedParameter& parameter, double bound) {
    switch (parameter.fitted_as) {
    case physics::FittedAs::Logarithm:
        return std::abs(std::log(parameter.value / bound)) < nearness;
    case physics::FittedAs::Inverse:
        return std::abs(1.0 / parameter.value - 1.0 / bound) < nearness / parameter.lower;
    case physics::FittedAs::Itself:
        break;
    }
    const double range = parameter.upper - parameter.lower;
    const double distance = std::abs(parameter.value - bound);
    return distance < rounding * range ||
           distance <
               nearness * std::min(range, std::max(std::abs(parameter.value), std::abs(bound)));
}

void add_part_parameters(RecordingFit& fit) {
    const std::vector<physics::ParameterId> ids = fit.model.free_ids();
    for (std::size_t k = 0; k < ids.size(); ++k) {
        FittedParameter& out = fit.parameters.emplace_back();
        out.id = ids[k];
        out.value = fit.model.value(k);
        out.fitted_as = fit.model.fitted_as(k);
        std::tie(out.lower, out.upper) = fit.model.bounds(k);
        out.is_error = fit.model.is_error(k);
        out.is_at_bound = !out.is_error && (is_near(out, out.lower) || is_near(out, out.upper));
        if (k < fit.model.parameters.size()) {
            const FreeParameter& described = fit.model.parameters[k];
            // A value that is known may lie at a bound.
            out.is_at_bound = out.is_at_bound && !(described.known_within > 0.0 &&
                                                   is_near(out, described.default_value));
            out.unit = described.unit;
            out.is_place = described.is_place;
            out.absent = described.absent;
        } else if (!out.is_error) {
            out.unit = "s";
        }
    }
}

void say_bounds(const std::vector<FittedParameter>& parameters, const std::vector<bool>& is_held,
                std::string& reason) {
    for (std::size_t k = 0; k < parameters.size(); ++k)
        if (const FittedParameter& parameter = parameters[k]; parameter.is_at_bound && !is_held[k])
            reason += fmt::format("{}{} is at its bound, {:.6g}{}{}{}", reason.empty() ? "" : "; ",
                                  to_string(parameter.id), parameter.value,
                                  parameter.unit.empty() ? "" : " ", parameter.unit,
                                  parameter.id.in_one_model() == physics::release_time
                                      ? " (time 0 is not the release: state its uncertainty, "
                                        "[release] time_uncertainty_ms, or let the fit begin later "
                                        "with kind = \"moving\" and start_s), or the model "
                                        "lacks an effect (culm diagnose)"
                                      : "");
}

/// Residuals, their number and their root mean square.
void add_residuals(std::span<const ObservedRecording> measurements, Fit& fit) {
    double sum_of_squares = 0.0;
    for (std::size_t m = 0; m < fit.parts.size(); ++m) {
        RecordingFit& part = fit.parts[m];
        double squares = 0.0;
        for (std::size_t at = 0; at < part.prediction.readings.size(); ++at) {
            part.residuals.push_back(measurements[m].deflections[at] -
                                     part.prediction.readings[at]);
            if (std::isnan(part.residuals.back()))
                continue;
            ++part.readings;
            squares += part.residuals.back() * part.residuals.back();
        }
        part.rmse = std::sqrt(squares / double(std::max<std::size_t>(part.readings, 1)));
        fit.readings += part.readings;
        sum_of_squares += squares;
    }
    fit.rmse = std::sqrt(sum_of_squares / double(std::max<std::size_t>(fit.readings, 1)));
}

/// The parameters of the parts and of all, without standard errors. Those at a bound that are not
/// held (`is_held`; joint parameters) are the fit's reason.
void add_parameters(const JointLayout& layout, const std::vector<bool>& is_held, Fit& fit) {
    for (RecordingFit& part : fit.parts)
        add_part_parameters(part);
    for (std::size_t k = 0; k < layout.ids.size(); ++k) {
        const auto [model, parameter] = layout.owners[k];
        fit.parameters.push_back(fit.parts[model].parameters[parameter]);
        fit.parameters.back().id = layout.ids[k];
    }
    say_bounds(fit.parameters, is_held, fit.reason);
}

/// Why the fit is not an answer: a load from outside near a natural frequency. Empty: there is
/// none.
std::string resonance_of(const RecordingFit& part) {
    constexpr std::size_t modes = 3;
    for (const FreeParameter& parameter : part.model.parameters) {
        if (!parameter.is_excitation)
            continue;
        const double frequency = parameter.access.get(part.model.spec);
        for (const integrate::VibrationMode& mode : run::chain_modes(part.model.spec, modes))
            if (std::abs(frequency / mode.frequency - 1.0) < physics::near_resonance)
                return fmt::format("{} = {:.4g} Hz is within {:g} % of a natural frequency ({:.4g} "
                                   "Hz), where it cannot be told from a shift of that frequency",
                                   to_string(parameter.access.id), frequency,
                                   100.0 * physics::near_resonance, mode.frequency);
    }
    return {};
}

} // namespace

Fit fit_jointly(std::span<const StemModel> models, std::span<const ObservedRecording> measurements,
                JointOptions options) {
    const JointLayout layout = joint_layout(models, measurements);
    std::vector<StartModels> starts{reconciled(std::vector(models.begin(), models.end()), layout)};
    for (const StartModels& other : options.other_starts)
        starts.push_back(reconciled(other, layout));
    std::vector<ReadingNoise> noises = noises_of(measurements, options);
    std::vector<std::vector<double>> noise;
    std::ranges::transform(noises, std::back_inserter(noise), &ReadingNoise::by_row);
    const std::vector<bool> is_held = held_numbers(layout, options);
    const JointProblem problem{measurements, layout, noise, is_held, options};
    std::vector<ChainPrediction> predictions;
    for (KnownPoint& known : options.known)
        predictions.push_back(std::move(known.prediction));
    JointSolution solution = solve(problem, starts, std::move(predictions));
    if (solution.batches > 0)
        options.known.clear(); // the fit has left the point
    Fit fit;
    fit.status = solution.has_converged ? FitStatus::Fitted : FitStatus::Failed;
    if (!solution.has_converged)
        fit.reason = fmt::format("not converged: {}", solution.message);
    fit.batches = solution.batches;
    for (std::size_t m = 0; m < measurements.size(); ++m) {
        RecordingFit& part =
            fit.parts.emplace_back(part_of(solution, m, std::move(noises[m]), measurements[m]));
        add_terms(measurements[m], options,
                  options.known.empty() ? std::vector<ErrorTerm>()
                                        : std::move(options.known[m].inputs),
                  part, fit.batches);
    }
    add_residuals(measurements, fit);
    if (options.is_first_guess)
        if (std::string doubt = doubt_of_release(fit, measurements); !doubt.empty()) {
            fit.status = FitStatus::Failed;
            fit.reason = std::move(doubt);
        }
    add_parameters(layout, is_held, fit);
    for (const RecordingFit& part : fit.parts)
        if (std::string resonance = resonance_of(part); !resonance.empty()) {
            fit.status = FitStatus::Failed;
            fit.reason = std::move(resonance);
        }
    solve_with_errors(measurements, layout, is_held, options, fit);
    return fit;
}

} // namespace culm::fit
