// SPDX-License-Identifier: BSD-3-Clause
#include "fit/solve/reading_errors.hpp"

#include "core/error.hpp"
#include "fit/solve/residual_statistics.hpp"
#include "fit/solve/second_mode_errors.hpp"
#include "fit/start/starts.hpp"
#include "run/modes.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <memory>
#include <numbers>
#include <optional>
#include <tuple>
#include <utility>

#include <Eigen/Core>
#include <fmt/core.h>

namespace culm::fit {
namespace {

double finite(double derivative) {
    return std::isfinite(derivative) ? derivative : 0.0;
}

/// Recordings whose inputs have the same name share their term.
std::string term_name(const StatedInput& input, const measure::Measurement& measurement) {
    const std::string& specimen = measurement.specimen_name();
    // Each specimen is clamped anew, at another height of the picture.
    if (input.is_of_rig && input.acts == InputActs::OnRows && !measurement.rig.empty())
        return fmt::format("{} of {} on rig {}", input.name, specimen, measurement.rig);
    if (input.is_of_rig)
        return fmt::format("{} of {}", input.name,
                           measurement.rig.empty() ? measurement.stem.id
                                                   : "rig " + measurement.rig);
    // A specimen that is clamped again has a new length, which was measured again.
    return fmt::format("{} ({:.6g} {}) of {}", input.name, input.value, input.unit, specimen);
}

/// The model without the errors of its readings.
StemModel exact_model(const RecordingFit& fit) {
    StemModel model = fit.model;
    model.errors.reset();
    model.error_values.clear();
    return model;
}

/// Derivatives of the predicted readings at all times of a recording, per standard uncertainty.
class InputErrors {
  public:
    InputErrors(const RecordingFit& fit, const measure::Measurement& measurement,
                const std::vector<StatedInput>& inputs, const run::Heartbeat& heartbeat)
        : fit_(fit), measurement_(measurement), inputs_(inputs), jacobian_(whitened_jacobian(fit)) {
        StemModel model = exact_model(fit);
        // A fit to all times already has the derivatives by its own parameters.
        own_ = !fit.model.errors && fit.times == measurement.times
                   ? fit.prediction
                   : predict_readings(model, measurement.times, heartbeat);
        model.parameters.clear();
        model.release_time_bound = 0.0;
        for (const StatedInput& input : inputs) {
            columns_.push_back(model.parameters.size());
            if (input.acts == InputActs::OnChain)
                model.parameters.push_back({input.access, input.unit});
        }
        rows_column_ = model.parameters.size();
        if (std::ranges::any_of(inputs, [](const StatedInput& input) {
                return input.acts == InputActs::OnRows || input.acts == InputActs::OnPicture;
            }))
            model.parameters.push_back({height_of_rows(measurement), "m"});
        if (!model.parameters.empty())
            changed_ = predict_readings(model, measurement.times, heartbeat);
    }

    /// (inputs)
    [[nodiscard]] std::vector<ReadingErrors::Term> terms() const {
        std::vector<ReadingErrors::Term> terms;
        for (std::size_t k = 0; k < inputs_.size(); ++k) {
            ReadingErrors::Term& term = terms.emplace_back();
            term.name = term_name(inputs_[k], measurement_);
            for (std::size_t at = 0; at < own_.readings.size(); ++at)
                term.readings.push_back(derivative(at, k));
            // The change of the fit's parameters that is most similar to the term.
            const Eigen::VectorXd follow =
                linear_step(jacobian_, whitened_term(term, fit_, jacobian_), jacobian_.cols(), 0)
                    .change;
            for (std::size_t p = 0; p < fit_.model.parameters.size(); ++p) {
                const physics::ParameterId& id = fit_.model.parameters[p].access.id;
                if (id != physics::bond_youngs_modulus && id != physics::bond_damping)
                    continue;
                const double change = follow(static_cast<Eigen::Index>(p));
                (id == physics::bond_damping ? term.log_damping : term.log_modulus) =
                    change / fit_.model.value(p);
                for (std::size_t at = 0; at < own_.readings.size(); ++at)
                    term.readings[at] -= change * by(own_, at, p);
            }
        }
        return terms;
    }

  private:
    /// Derivative of a reading by one of the prediction's parameters.
    [[nodiscard]] static double by(const ChainPrediction& prediction, std::size_t at,
                                   std::size_t parameter) {
        return finite(prediction.jacobian[at * prediction.parameters + parameter]);
    }

    /// Derivative of predicted − measured by input `k`, times its uncertainty u.
    [[nodiscard]] double derivative(std::size_t at, std::size_t k) const {
        const StatedInput& input = inputs_[k];
        const double height = measurement_.heights[at % own_.rows];
        double change = 0.0;
        switch (input.acts) {
        case InputActs::OnChain:
            change = by(changed_, at, columns_[k]);
            break;
        case InputActs::OnRows:
            change = by(changed_, at, rows_column_);
            break;
        case InputActs::OnPicture:
            change = height * by(changed_, at, rows_column_) - finite(own_.readings[at]);
            break;
        case InputActs::OnSensor:
            if (at % own_.rows == input.row)
                change = -finite(own_.readings[at]);
            break;
        case InputActs::OnClock:
            // If the rate is larger by the share c, the reading was taken at t/(1 + c), where the
            // prediction is smaller by c t dy/dt. The last derivative is −dy/dt.
            if (fit_.model.release_time_bound > 0.0)
                change = measurement_.times[at / own_.rows] * by(own_, at, own_.parameters - 1);
            break;
        }
        return change * input.standard_uncertainty;
    }

    const RecordingFit& fit_;
    const measure::Measurement& measurement_;
    const std::vector<StatedInput>& inputs_;
    Eigen::MatrixXd jacobian_;         ///< whitened_jacobian() of the fit
    ChainPrediction own_;              ///< by the fit's parameters, at all times
    ChainPrediction changed_;          ///< by the inputs that change the chain, and by the rows
    std::vector<std::size_t> columns_; ///< (inputs) their columns in changed_
    std::size_t rows_column_ = 0;      ///< of a common shift of the rows
};

constexpr double likely_order = 4.0 / 3.0; ///< α: errors of order 2, bonds of half the length
constexpr double order_doubt = 1.0 / 3.0;
constexpr double negligible_shift = 0.3; ///< of a frequency's standard deviation

/// The chain with twice the number of bonds and the same first mode.
struct FinerChain {
    StemModel model;
    double log_modulus = 0.0; ///< ln of its Y over that of the chain
    double log_damping = 0.0; ///< likewise of its β over that of the same damping time
    bool matters = false;
};

/// Standard deviation of the frequency of a decaying mode, Hz (Montgomery & O'Donoghue 1999).
/// Frames after a decay by e add almost no information.
double frequency_uncertainty(const RecordingFit& fit, const NoiseModel* model,
                             const integrate::VibrationMode& mode, double amplitude) {
    const double recorded = fit.times.back();
    const double duration =
        mode.decay_rate < 0.0 ? std::min(recorded, -1.0 / mode.decay_rate) : recorded;
    const double readings = static_cast<double>(fit.readings) * duration / recorded;
    double noise = 0.0;
    for (const double each : fit.noise)
        noise = noise == 0.0 ? each : std::min(noise, each);
    // Slow noise has less power at a mode's frequency than white noise of its size.
    if (model != nullptr)
        noise *= std::sqrt((1.0 - model->correlation) / (1.0 + model->correlation));
    return std::sqrt(6.0 / std::max(readings, 1.0)) * noise /
           (std::numbers::pi * amplitude * duration);
}

FinerChain finer_chain(const RecordingFit& fit, const NoiseModel* noise_model) {
    FinerChain finer{exact_model(fit)};
    StemModel& model = finer.model;
    model.parameters.clear();
    model.release_time_bound = 0.0;
    const run::CaseSpec& coarse = fit.model.spec;
    const auto modes = run::chain_modes(coarse, 2);
    if (modes.size() < 2 || coarse.tip_deflection == 0.0)
        return finer;
    model.spec = with_spheres(std::move(model.spec), 2 * coarse.stem.sphere_count - 1);
    const double same_time = model.spec.stem.bond_damping;
    keep_first_mode(modes.front(), model);
    const auto finer_modes = run::chain_modes(model.spec, 2);
    if (finer_modes.size() < 2)
        return finer;
    finer.log_modulus =
        std::log(model.spec.stem.bond_youngs_modulus / coarse.stem.bond_youngs_modulus);
    finer.log_damping = same_time > 0.0 ? std::log(model.spec.stem.bond_damping / same_time) : 0.0;
    // If a stem is pulled at its tip, the second mode has (f₁/f₂)² of the first mode's amplitude.
    const double amplitude =
        std::abs(coarse.tip_deflection) * std::pow(modes[0].frequency / modes[1].frequency, 2);
    finer.matters = std::abs(finer_modes[1].frequency - modes[1].frequency) >
                    negligible_shift * frequency_uncertainty(fit, noise_model, modes[1], amplitude);
    return finer;
}

/// The chain's readings at all times of the recording, from the fit itself if it has all times.
std::vector<double> predicted(const RecordingFit& fit, const std::vector<double>& times,
                              const run::Heartbeat& heartbeat) {
    if (fit.times == times)
        return fit.prediction.readings;
    StemModel chain = exact_model(fit);
    chain.parameters.clear();
    chain.release_time_bound = 0.0;
    return predict_readings(chain, times, heartbeat).readings;
}

constexpr const char* division_name = "division of the chain";

/// Adds the known effect of the division of the chain, and a term for its uncertainty.
void add_division(const RecordingFit& fit, const FinerChain& finer, const FinerChain& first,
                  const run::Heartbeat& heartbeat, ReadingErrors& errors) {
    const double modulus = first.log_modulus - finer.log_modulus;
    const double damping = first.log_damping - finer.log_damping;
    ReadingErrors::Term doubt{division_name, {}, order_doubt * modulus, order_doubt * damping};
    errors.known.log_modulus = likely_order * modulus;
    errors.known.log_damping = likely_order * damping;
    if (finer.matters) {
        const std::vector<double> now = predicted(fit, errors.times, heartbeat);
        const ChainPrediction then = predict_readings(finer.model, errors.times, heartbeat);
        for (std::size_t at = 0; at < now.size(); ++at) {
            const double change = finite(then.readings[at] - now[at]);
            errors.known.readings.push_back(likely_order * change);
            doubt.readings.push_back(order_doubt * change);
        }
    }
    if (finer.matters || modulus != 0.0)
        errors.terms.push_back(std::move(doubt));
}

/// Position errors are modelled by Legendre polynomials of degree 0 to 3. Only the cubic one scales
/// the first mode by a factor that depends on the amplitude, and so changes the damping.
constexpr unsigned row_polynomials = 4;

/// A lens or uneven light causes an error that depends on the position in the picture. Each row has
/// its own polynomials of the predicted deflection, and all rows together have those of degree 2
/// and 3 (0 and 1 are the rest position and the scale), each with the stated uncertainty. Near the
/// clamp, where the swing is small, the measured deflection would explain its own noise.
void add_errors_of_place(const RecordingFit& fit, const measure::Measurement& measurement,
                         const run::Heartbeat& heartbeat, ReadingErrors& errors) {
    if (measurement.uncertainties.row.value_or(0.0) == 0.0)
        return;
    const std::size_t rows = fit.prediction.rows;
    const std::vector<double> places = predicted(fit, errors.times, heartbeat);
    // Uses every `step`-th reading, starting with `first`.
    const auto add = [&](const std::string& of, std::size_t first, std::size_t step,
                         unsigned lowest_degree) {
        double largest = 0.0;
        for (std::size_t at = first; at < places.size(); at += step)
            largest = std::max(largest, std::abs(finite(places[at])));
        for (unsigned degree = lowest_degree; degree < row_polynomials && largest > 0.0; ++degree) {
            ReadingErrors::Term& term = errors.terms.emplace_back();
            term.name = fmt::format("{} of {}, degree {}", of, measurement.stem.id, degree);
            term.is_of_row = true;
            term.readings.assign(places.size(), 0.0);
            for (std::size_t at = first; at < places.size(); at += step)
                term.readings[at] = *measurement.uncertainties.row *
                                    std::legendre(degree, finite(places[at]) / largest);
        }
    };
    for (std::size_t j = 0; j < rows; ++j)
        add(fmt::format("row at {:.6g} mm", 1e3 * measurement.heights[j]), j, rows, 0);
    add("all rows", 0, 1, 2);
}

constexpr double drift_share = 0.1; ///< of the rms reading, over the record

/// A constant error of each sensor, and one that grows linearly in time. By default the constant is
/// about as large as the readings, so that the readings alone determine it.
void add_errors_of_sensors(const measure::Measurement& measurement, ReadingErrors& errors) {
    const std::vector<double>& times = measurement.times;
    const double middle = 0.5 * (times.front() + times.back());
    const double duration = std::max(times.back() - times.front(), 1e-12);
    const std::size_t rows = measurement.heights.size();
    for (std::size_t j = 0; j < measurement.sensors.size(); ++j) {
        const measure::Sensor& sensor = measurement.sensors[j];
        if (sensor.is_camera())
            continue;
        const double usual = measurement.rms_reading(j);
        const double offset = sensor.offset_uncertainty.value_or(usual);
        const double drift = sensor.drift_uncertainty.value_or(drift_share * usual / duration);
        for (const auto& [kind, constant, rate] :
             {std::tuple("offset", offset, 0.0), std::tuple("drift", 0.0, drift)}) {
            if (constant == 0.0 && rate == 0.0)
                continue;
            ReadingErrors::Term& term = errors.terms.emplace_back();
            term.name = fmt::format("{} of {} of {}", kind, sensor.column, measurement.stem.id);
            term.is_of_row = true;
            term.is_in_every_model = true;
            term.readings.assign(times.size() * rows, 0.0);
            for (std::size_t i = 0; i < times.size(); ++i)
                term.readings[i * rows + j] = constant + rate * (times[i] - middle);
        }
    }
}

} // namespace

std::vector<ObservedRecording> with_reading_errors(std::span<const ObservedRecording> recordings,
                                                   std::span<const RecordingFit> fits,
                                                   const run::Heartbeat& heartbeat) {
    std::vector<ObservedRecording> out(recordings.begin(), recordings.end());
    std::optional<FinerChain> first;
    for (std::size_t m = 0; m < fits.size(); ++m) {
        if (!can_move(fits[m].model, recordings[m]))
            continue;
        const ReadingErrors* const before = recordings[m].errors.get();
        if (before == nullptr)
            out[m] = with_noise_in_motion(fits[m], recordings[m]);
        try {
            const std::vector<StatedInput> inputs = stated_inputs(recordings[m]);
            auto errors = std::make_shared<ReadingErrors>();
            errors->times = recordings[m].times;
            errors->terms = InputErrors(fits[m], recordings[m], inputs, heartbeat).terms();
            if (before != nullptr) {
                errors->known = before->known;
                std::ranges::copy_if(before->terms, std::back_inserter(errors->terms),
                                     [](const auto& term) { return term.name == division_name; });
            } else {
                const FinerChain finer = finer_chain(fits[m], out[m].noise_model.get());
                if (!first)
                    first = finer;
                add_division(fits[m], finer, *first, heartbeat, *errors);
            }
            std::vector<ReadingErrors::Term> of_release = release_errors(
                fits[m], recordings[m],
                std::vector(errors->terms.begin(),
                            errors->terms.begin() + static_cast<std::ptrdiff_t>(inputs.size())));
            std::ranges::move(of_release, std::back_inserter(errors->terms));
            add_errors_of_place(fits[m], recordings[m], heartbeat, *errors);
            add_errors_of_sensors(recordings[m], *errors);
            std::ranges::move(second_mode_terms(fits[m].model, fits[m].noise, recordings[m]),
                              std::back_inserter(errors->terms));
            out[m].errors = std::move(errors);
        } catch (const core::NumericalError&) {
            // The fit continues without terms; the chain itself can be computed.
        }
    }
    return out;
}

std::vector<ObservedRecording>
with_inputs_as_stated(std::span<const ObservedRecording> recordings) {
    std::vector<ObservedRecording> out(recordings.begin(), recordings.end());
    for (ObservedRecording& recording : out) {
        if (!recording.errors)
            continue;
        const ReadingErrors::Term& known = recording.errors->known;
        ReadingErrors remaining{recording.errors->times, known, {}};
        std::ranges::copy_if(recording.errors->terms, std::back_inserter(remaining.terms),
                             &ReadingErrors::Term::is_in_every_model);
        const bool is_exact = remaining.terms.empty() && known.readings.empty() &&
                              known.log_modulus == 0.0 && known.log_damping == 0.0;
        recording.errors =
            is_exact ? nullptr : std::make_shared<const ReadingErrors>(std::move(remaining));
    }
    return out;
}

StemModel beside_errors(StemModel model, const ObservedRecording& measurement) {
    const StemModel before = model;
    model.errors = measurement.errors;
    model.error_values.assign(model.errors ? model.errors->terms.size() : 0, 0.0);
    for (std::size_t k = 0; k < before.error_values.size(); ++k)
        for (std::size_t now = 0; now < model.error_values.size(); ++now)
            if (model.errors->terms[now].name == before.errors->terms[k].name)
                model.error_values[now] = before.error_values[k];
    return model;
}

StemModel observed_model(const SelectedEffects& effects, const ObservedRecording& recording,
                         const ChainOptions& options) {
    return candidate_model(beside_errors(baseline_model(recording, options), recording), effects,
                           recording);
}

} // namespace culm::fit
