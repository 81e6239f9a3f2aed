// SPDX-License-Identifier: BSD-3-Clause
#include "fit/chain/prediction.hpp"

#include "core/error.hpp"
#include "core/lanes.hpp"
#include "fit/chain/higher_modes.hpp"
#include "fit/chain/superposition.hpp"
#include "measure/folder/observation.hpp"
#include "physics/chain_model.hpp"
#include "physics/effects/stem_scales.hpp"
#include "run/case_lanes.hpp"
#include "run/case_model.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include <boost/math/quadrature/gauss.hpp>

namespace culm::fit {

namespace {

/// Most steps per period of the first mode. Stems need 20 steps, 60 with β = 1 and 170 without
/// damping; with friction in the clamp 46, 220 and 3200. A fit in which friction replaces all
/// damping would wait minutes for the ringing of the highest modes.
constexpr double most_steps_per_period = 400.0;
constexpr double most_steps_per_sample = 1.0; ///< added to these for fast visible motion

/// The case with the duration that the readings need for any release within its bounds, because the
/// duration must not depend on the fitted parameters.
run::CaseSpec case_until(const StemModel& model, double last_time) {
    run::CaseSpec spec = computed_case(model);
    const double earliest =
        std::min(model.release_time, model.expected_release - model.release_time_bound);
    const double needed =
        std::max(last_time + 0.5 * model.exposure - earliest, 4.0 * spec.sample_interval);
    spec.duration = std::ceil(needed / spec.sample_interval) * spec.sample_interval;
    if (spec.integrator.method == run::IntegrationMethod::Implicit)
        spec.integrator.step_limit = static_cast<std::int64_t>(
            most_steps_per_period * (1.0 + spec.duration * physics::first_frequency(spec.stem)) +
            most_steps_per_sample * static_cast<double>(spec.sample_count()));
    return spec;
}

template <class Outcome>
auto result_or_throw(Outcome outcome) {
    if (const auto* failure = std::get_if<run::CaseFailure>(&outcome))
        throw core::NumericalError(failure->kind, failure->reason);
    return std::get<0>(std::move(outcome));
}

/// Uses SIMD lanes for derivatives only. Throws core::NumericalError.
run::CaseWithSensitivities simulate(const run::CaseSpec& spec,
                                    std::span<const run::CaseParameter> parameters,
                                    const run::Heartbeat& heartbeat) {
    if (parameters.empty())
        return {result_or_throw(run::simulate(spec, heartbeat)), {}};
    return result_or_throw(run::simulate_with_sensitivities(spec, parameters, heartbeat));
}

int batches_for(std::size_t derivatives) {
    constexpr std::size_t in_each = core::lane_count - 1; // next to the case itself
    return static_cast<int>(std::max<std::size_t>((derivatives + in_each - 1) / in_each, 1));
}

/// The samples that predict a frame, with weights: the mean over its exposure, by Gauss's rule of
/// four points. The error is a thousandth of a swing if the exposure covers nine tenths of a
/// period. The release excites such fast modes, which an exposure of a millisecond blurs.
std::vector<std::pair<measure::TimeStencil, double>>
stencils_of(std::span<const double> sample_times, double time, double exposure) {
    if (exposure <= 0.0)
        return {{measure::time_stencil(sample_times, time), 1.0}};
    std::vector<std::pair<measure::TimeStencil, double>> stencils;
    using Rule = boost::math::quadrature::gauss<double, 4>; // its points x and −x, in [−1, 1]
    for (std::size_t k = 0; k < Rule::abscissa().size(); ++k)
        for (const double side : {-0.5, 0.5})
            stencils.emplace_back(
                measure::time_stencil(sample_times, time + side * Rule::abscissa()[k] * exposure),
                0.5 * Rule::weights()[k]);
    return stencils;
}

void add_frame(const StemModel& model, std::span<const double> values,
               const run::CaseWithSensitivities& simulated, std::span<const double> sample_times,
               double since_release, ChainPrediction& prediction) {
    const auto stencils = stencils_of(sample_times, since_release, model.exposure);
    const auto& heights = simulated.result.height_deflection;
    const auto value = [&](const auto& table, std::size_t row) {
        double sum = 0.0;
        for (const auto& [stencil, weight] : stencils)
            sum += weight * stencil.value(table, prediction.rows, row);
        return sum;
    };
    for (std::size_t j = 0; j < prediction.rows; ++j) {
        prediction.readings.push_back(value(heights, j));
        for (std::size_t k = 0; k < values.size(); ++k) {
            const std::vector<double>& derivative = simulated.height_derivatives[k];
            prediction.jacobian.push_back(
                derivative.empty() ? 0.0
                                   : derivative_by_coordinate(model.parameters[k], values[k],
                                                              value(derivative, j)));
        }
        if (model.release_time_bound > 0.0) {
            double rate = 0.0;
            for (const auto& [stencil, weight] : stencils)
                rate += weight * stencil.rate(heights, prediction.rows, j);
            prediction.jacobian.push_back(-rate);
        }
        prediction.jacobian.resize(prediction.readings.size() * prediction.parameters);
    }
}

/// Shift of a height in the picture relative to its position at the release, m, while the stem is
/// held and its support moves. `time` counts from the release, s.
double held_shift(const run::CaseModel& held, double free_length, double time, double height) {
    const physics::BaseMotion<double>& base = *held.chain.base_motion;
    return (physics::base_position(base, time) - physics::base_position(base, 0.0)) *
           (1.0 + held.camera.scale_change * height / free_length);
}

/// The held stem and its holder are fixed to the support and move with it as one body. (A finger on
/// firm ground would bend the stem in time with the support. The lower heights, which show the
/// motion of the support best, hardly distinguish the two cases.)
void move_held_frames(const StemModel& model, std::span<const double> times,
                      ChainPrediction& prediction) {
    const double length = model.spec.stem.free_length();
    const run::CaseModel held = run::case_model(model.spec);
    if (!held.chain.base_motion)
        return;
    struct Neighbours {
        run::CaseModel below, above;
        double distance; ///< as in SteppedCases
    };
    std::vector<Neighbours> neighbours; // by parameter
    for (const FreeParameter& parameter : model.parameters) {
        const SteppedCases cases = stepped(model.spec, parameter);
        neighbours.push_back(
            {run::case_model(cases.below), run::case_model(cases.above), cases.distance});
    }
    const double step = relative_step / held.chain.base_motion->angular_frequency;
    for (std::size_t i = 0; i < times.size() && times[i] < model.release_time; ++i)
        for (std::size_t j = 0; j < prediction.rows; ++j) {
            const double time = times[i] - model.release_time;
            const double height = model.spec.heights[j];
            const std::size_t at = i * prediction.rows + j;
            prediction.readings[at] += held_shift(held, length, time, height);
            double* const derivatives = prediction.jacobian.data() + at * prediction.parameters;
            for (std::size_t k = 0; k < neighbours.size(); ++k)
                derivatives[k] += (held_shift(neighbours[k].above, length, time, height) -
                                   held_shift(neighbours[k].below, length, time, height)) /
                                  neighbours[k].distance;
            if (model.release_time_bound > 0.0)
                derivatives[neighbours.size()] -= (held_shift(held, length, time + step, height) -
                                                   held_shift(held, length, time - step, height)) /
                                                  (2.0 * step);
        }
}

/// Index of the frame at this time in the errors; empty if they have none.
std::optional<std::size_t> frame_at(const ReadingErrors& errors, double time) {
    const auto found = std::ranges::lower_bound(errors.times, time);
    if (found == errors.times.end() || *found != time)
        return std::nullopt;
    return static_cast<std::size_t>(found - errors.times.begin());
}

/// Adds the contributions of the error terms to the readings, and the derivatives by these terms.
void add_errors(const StemModel& model, std::span<const double> times,
                ChainPrediction& prediction) {
    const ReadingErrors& errors = *model.errors;
    const std::size_t modulus = model.place_of(physics::bond_youngs_modulus);
    const std::size_t damping = model.place_of(physics::bond_damping);
    const std::size_t count = model.parameters.size();
    for (std::size_t i = 0; i < times.size(); ++i) {
        const std::optional<std::size_t> frame = frame_at(errors, times[i]);
        for (std::size_t j = 0; j < prediction.rows; ++j) {
            const std::size_t at = i * prediction.rows + j;
            double* const derivatives = prediction.jacobian.data() + at * prediction.parameters;
            const auto reading_of = [&](const std::vector<double>& readings) {
                return frame && !readings.empty() ? readings[*frame * prediction.rows + j] : 0.0;
            };
            prediction.readings[at] += reading_of(errors.known);
            for (std::size_t k = 0; k < model.error_values.size(); ++k) {
                const ErrorTerm& term = errors.terms[k];
                double& derivative = derivatives[model.first_error() + k];
                derivative = reading_of(term.readings);
                prediction.readings[at] += model.error_values[k] * derivative;
                if (modulus < count) // the coordinate of Y is ln Y
                    derivative += derivatives[modulus] * term.log_modulus;
                if (damping < count)
                    derivative +=
                        derivatives[damping] * term.log_damping * model.spec.stem.bond_damping;
            }
        }
    }
}

/// The readings of a simulated case; `values` are those of the model's parameters.
ChainPrediction readings_of(const StemModel& model, const run::CaseSpec& spec,
                            std::span<const double> values,
                            const run::CaseWithSensitivities& simulated,
                            std::span<const double> times) {
    ChainPrediction prediction;
    prediction.spheres = spec.stem.sphere_count;
    prediction.frames = times.size();
    prediction.rows = spec.heights.size();
    prediction.parameters = model.free_count();
    prediction.readings.reserve(prediction.frames * prediction.rows);
    prediction.jacobian.reserve(prediction.frames * prediction.rows * prediction.parameters);
    std::vector<double> sample_times(spec.sample_count());
    for (std::size_t k = 0; k < sample_times.size(); ++k)
        sample_times[k] = static_cast<double>(k) * spec.sample_interval;
    for (const double time : times)
        add_frame(model, values, simulated, sample_times, time - model.release_time, prediction);
    if (!times.empty() && times.front() < model.release_time)
        move_held_frames(model, times, prediction);
    if (model.spec.release == run::Release::FirstMode)
        superpose_higher_modes(model, times, prediction);
    if (model.errors)
        add_errors(model, times, prediction);
    return prediction;
}

/// The readings of superposed models that differ only in their numbers; empty for other models.
/// `predict` gives the predictions of planar models.
template <class Predict>
std::vector<ChainPrediction> predict_superposed(std::span<const StemModel> models,
                                                const Predict& predict) {
    std::vector<std::vector<PlanarModel>> parts; // (models)(parts)
    parts.reserve(models.size());
    for (const StemModel& model : models)
        parts.push_back(planar_models(model));
    if (parts.empty() || parts.front().empty())
        return {};
    std::vector<std::vector<ChainPrediction>> predictions(models.size()); // (models)(parts)
    for (std::size_t k = 0; k < parts.front().size(); ++k) {
        std::vector<StemModel> planar;
        planar.reserve(models.size());
        for (const std::vector<PlanarModel>& of_model : parts)
            planar.push_back(of_model[k].model);
        std::vector<ChainPrediction> of_part = predict(planar);
        for (std::size_t m = 0; m < models.size(); ++m)
            predictions[m].push_back(std::move(of_part[m]));
    }
    std::vector<ChainPrediction> out;
    out.reserve(models.size());
    for (std::size_t m = 0; m < models.size(); ++m)
        out.push_back(superposed(models[m], parts[m], predictions[m]));
    return out;
}

} // namespace

ChainPrediction predict_readings(const StemModel& model, std::span<const double> times,
                                 const run::Heartbeat& heartbeat) {
    const auto predict_one = [&](std::span<const StemModel> planar) {
        return std::vector{predict_readings(planar.front(), times, heartbeat)};
    };
    if (auto sums = predict_superposed({&model, 1}, predict_one); !sums.empty())
        return std::move(sums.front());
    const run::CaseSpec spec = case_until(model, times.empty() ? 0.0 : times.back());
    std::vector<run::CaseParameter> accesses;
    std::vector<double> values;
    for (const FreeParameter& parameter : model.parameters) {
        if (!physics::is_of_higher_mode(parameter.access.id))
            accesses.push_back(differentiated_by(parameter));
        values.push_back(parameter.access.get(spec));
    }
    run::CaseWithSensitivities simulated = simulate(spec, accesses, heartbeat);
    for (std::size_t k = 0; k < model.parameters.size(); ++k)
        if (physics::is_of_higher_mode(model.parameters[k].access.id))
            simulated.height_derivatives.emplace(simulated.height_derivatives.begin() +
                                                 static_cast<std::ptrdiff_t>(k));
    ChainPrediction prediction = readings_of(model, spec, values, simulated, times);
    prediction.batches = batches_for(accesses.size());
    return prediction;
}

std::vector<ChainPrediction> predict_together(std::span<const StemModel> models,
                                              std::span<const double> times,
                                              const run::Heartbeat& heartbeat) {
    const auto predict_all = [&](std::span<const StemModel> planar) {
        return predict_together(planar, times, heartbeat);
    };
    if (auto sums = predict_superposed(models, predict_all); !sums.empty())
        return sums;
    const double last_time = times.empty() ? 0.0 : times.back();
    std::vector<ChainPrediction> predictions;
    while (predictions.size() < models.size()) {
        // Every batch begins with the first model, because all models take its steps.
        const std::size_t done = predictions.size();
        const std::size_t repeated = done == 0 ? 0 : 1;
        std::vector<run::CaseSpec> specs;
        if (repeated > 0)
            specs.push_back(case_until(models.front(), last_time));
        for (std::size_t k = done; k < models.size() && specs.size() < core::lane_count; ++k)
            specs.push_back(case_until(models[k], last_time));
        std::vector<run::CaseOutcome> outcomes = run::simulate_on_common_steps(specs, heartbeat);
        for (std::size_t lane = repeated; lane < specs.size(); ++lane) {
            StemModel model = models[done + lane - repeated];
            model.parameters.clear(); // no derivatives
            predictions.push_back(readings_of(
                model, specs[lane], {}, {result_or_throw(std::move(outcomes[lane])), {}}, times));
            predictions.back().batches = lane == repeated ? 1 : 0;
        }
    }
    return predictions;
}

} // namespace culm::fit
