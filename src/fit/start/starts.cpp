// SPDX-License-Identifier: BSD-3-Clause
#include "fit/start/starts.hpp"

#include "core/error.hpp"
#include "fit/chain/baseline_model.hpp"
#include "fit/chain/prediction.hpp"
#include "fit/linear/layout.hpp"
#include "fit/linear/scaled_solve.hpp"
#include "fit/linear/weighted_system.hpp"
#include "fit/noise/reading_noise.hpp"
#include "fit/start/residual_spectrum.hpp"
#include "physics/effects/library.hpp"
#include "physics/effects/stem_scales.hpp"
#include "reduce/backbone/damped_modes.hpp"
#include "run/modes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>

#include <boost/math/tools/roots.hpp>

namespace culm::fit {

namespace {

constexpr std::size_t most_starts = 12;
constexpr std::size_t most_beats = 2;

/// Amplitude at which the effect vanishes, clamped to the bounds.
double absent_value(const FreeParameter& parameter) {
    return parameter.fitted_as == physics::FittedAs::Inverse
               ? parameter.upper
               : std::clamp(parameter.absent, parameter.lower, parameter.upper);
}

/// Starts for a stem that leaves the plane, from the beats in its readings. Empty if none.
std::vector<StemModel> beat_starts(const StemModel& first, const RecordingFit& smaller) {
    std::vector<StemModel> starts;
    const auto modes = run::chain_modes(computed_case(smaller.model), 1);
    if (modes.empty() || !(modes.front().decay_rate < 0.0))
        return starts;
    const integrate::VibrationMode& mode = modes.front();
    const double angular_frequency = 2.0 * std::numbers::pi * mode.frequency;
    for (const Beat& beat :
         recorded_beats(smaller, angular_frequency, -mode.decay_rate, most_beats)) {
        StemModel& start = starts.emplace_back(first);
        start.spec.stem.bond_youngs_modulus *=
            std::pow(beat.angular_frequency / angular_frequency, 2);
        start.spec.stem.bond_damping *= beat.decay_rate / -mode.decay_rate;
        start.spec.tip_deflection *= beat.amplitude;
        for (const FreeParameter& parameter : start.parameters) {
            const double value = parameter.start_from_beat != nullptr
                                     ? parameter.start_from_beat({beat.split, beat.angle})
                                     : parameter.access.get(start.spec);
            parameter.access.set(start.spec, std::clamp(value, parameter.lower, parameter.upper));
        }
    }
    return starts;
}

constexpr std::array<double, 6> first_splits{0.01, 0.03, 0.07, 0.12, 0.2, 0.35};
/// ε = 0.8: one principal stiffness is (1 + 0.4)/(1 − 0.4) = 2.3 times the other.
constexpr double largest_split = 0.8;
constexpr double needed_beat_gain = 0.1; ///< of the fit's residual sum of squares
constexpr double same_split = 0.05;      ///< relative: two solutions are the same
constexpr std::size_t fewest_beat_frames = 10;

/// The readings from the release on over the fitted chain's at the release, in every row that
/// swings.
reduce::HeightHistories relative_swing(const RecordingFit& fit) {
    const std::size_t rows = fit.prediction.rows;
    const auto after = std::ranges::lower_bound(fit.times, 0.0);
    const auto first = static_cast<std::size_t>(after - fit.times.begin());
    reduce::HeightHistories swing{{after, fit.times.end()}, {}, {}};
    for (std::size_t j = 0; j < rows && first < fit.times.size(); ++j) {
        const double shape = fit.prediction.readings[first * rows + j];
        if (std::isnan(shape) || shape == 0.0)
            continue;
        swing.weights.push_back(std::abs(shape));
        std::vector<double>& history = swing.histories.emplace_back();
        for (std::size_t at = first * rows + j; at < fit.residuals.size(); at += rows)
            history.push_back((fit.prediction.readings[at] + fit.residuals[at]) / shape);
    }
    return swing;
}

/// A stem that is pulled at an angle α to its principal planes swings in both: seen from the side,
/// x = e^(−δt) (a cos ω₁t + b cos ω₂t) with a = A cos²α, b = A sin²α and ω₁,₂² = ω² (1 ± ε/2).
/// Fitting it to the swing is hundreds of times cheaper than a fit of the spatial chain.
struct Candidate {
    Beat beat;
    double left = std::numeric_limits<double>::infinity(); ///< of the squares; infinite: no beat
};

/// From two modes whose squared frequencies are `split` apart, the stronger one at `frequency`, Hz.
Candidate solved(const reduce::HeightHistories& swing, double frequency, double decay_rate,
                 double split, double stronger) {
    const double square = std::pow(frequency, 2) / stronger;
    const std::array starts{reduce::ModeRate{-decay_rate, std::sqrt(square * (1.0 + 0.5 * split))},
                            reduce::ModeRate{-decay_rate, std::sqrt(square * (1.0 - 0.5 * split))}};
    const auto fit = reduce::fit_damped_modes(swing, starts);
    if (!fit)
        return {};
    const auto [slow, fast] = std::ranges::minmax(
        fit->modes, {}, [](const reduce::DampedMode& mode) { return mode.rate.frequency; });
    const auto squared = [](const reduce::DampedMode& mode) {
        return std::pow(2.0 * std::numbers::pi * mode.rate.frequency, 2);
    };
    const double mean = 0.5 * (squared(fast) + squared(slow));
    const double found = (squared(fast) - squared(slow)) / mean;
    const std::size_t height = fit->modes.front().largest_height();
    const double along = fast.amplitudes[height].real();
    const double across = slow.amplitudes[height].real();
    const double decay =
        -(along * fast.rate.decay_rate + across * slow.rate.decay_rate) / (along + across);
    if (!(std::min({along, across, decay}) > 0.0 && found < largest_split))
        return {};
    double left = 0.0;
    for (std::size_t j = 0; j < fit->residuals.size(); ++j)
        for (const double each : fit->residuals[j])
            left += std::isnan(each) ? 0.0 : std::pow(swing.weights[j] * each, 2);
    return {{std::sqrt(mean), decay, found, std::atan2(std::sqrt(across), std::sqrt(along)),
             along + across},
            left};
}

/// The size of an effect that belongs to recordings; null: it has none.
const FreeParameter* own_size(const StemModel& model, const std::string& effect) {
    const auto size = std::ranges::find_if(model.parameters, [&](const FreeParameter& each) {
        return each.access.id.effect == effect && !each.is_place &&
               belongs_to_recording(each.access.id);
    });
    return size == model.parameters.end() ? nullptr : &*size;
}

/// The model with the numbers of `guess`, no errors of inputs, and the first mode of `guess` by
/// this size alone; none: no size gives it. `size`: of the model.
std::optional<StemModel> with_mode_of(const StemModel& guess, const FreeParameter& size,
                                      StemModel model) {
    const double wanted = run::lightly_damped_mode(guess.spec).frequency;
    const auto missed = [&](double share) {
        size.access.set(model.spec, std::lerp(absent_value(size), size.upper, share));
        return run::lightly_damped_mode(model.spec).frequency - wanted;
    };
    if (!(missed(0.0) * missed(1.0) < 0.0))
        return std::nullopt;
    const boost::math::tools::eps_tolerance<double> is_close(30); // bits
    (void)missed(boost::math::tools::bisect(missed, 0.0, 1.0, is_close).first);
    return model;
}

constexpr std::array numbers_of_spheres{14, 20, 28};
constexpr double likely_error = 1.0 / 3.0; ///< of y₂ − y₁
constexpr double small_error = 0.2;        ///< of the noise

/// Rms over the readings of the error that remains, over the noise.
double remaining_error(const StemModel& coarse, const measure::Measurement& recording,
                       const std::vector<double>& noise, const run::Heartbeat& heartbeat) {
    StemModel fine = with_spheres(coarse, 2 * coarse.spec.stem.sphere_count - 1);
    fine.parameters.clear();
    fine.release_time_bound = 0.0;
    ObservedRecording finer(recording);
    finer.deflections = predict_readings(fine, recording.times, heartbeat).readings;
    const ChainPrediction own = predict_readings(coarse, recording.times, heartbeat);
    const std::vector<ErrorTerm> none;
    const SystemPart part{coarse, finer, own, noise, none};
    const WeightedSystem system =
        weighted_system(joint_layout({&coarse, 1}, {&finer, 1}), {&part, 1});
    const Eigen::VectorXd left = Projector(system.jacobian).remainder(system.residual);
    return likely_error * std::sqrt(left.squaredNorm() / std::max(1.0, double(left.size())));
}

bool suffices(int spheres, std::span<const measure::Measurement> recordings,
              const FitOptions& options) {
    ChainOptions chain = options.chain;
    chain.spheres = spheres;
    for (const measure::Measurement& recording : recordings) {
        const std::vector<double> noise = reading_noise(ObservedRecording(recording)).by_row;
        if (noise.empty())
            return false;
        try {
            if (!(remaining_error(baseline_model(recording, chain), recording, noise,
                                  options.heartbeat) < small_error))
                return false;
        } catch (const core::NumericalError&) {
            return false;
        }
    }
    return true;
}

} // namespace

std::vector<StartModels> starts_by_frequency(StartModels models, const std::string& effect,
                                             std::span<const ObservedRecording> recordings) {
    std::vector<StartModels> starts;
    if (models.size() < 2 || own_size(models.front(), effect) == nullptr)
        return starts;
    StartModels guesses;
    for (std::size_t m = 0; m < models.size(); ++m) {
        const StemModel& guess = guesses.emplace_back(baseline_model(recordings[m]));
        const std::vector<physics::ParameterId> ids = guess.free_ids();
        for (std::size_t k = 0; k < models[m].first_error(); ++k)
            if (const auto own = std::ranges::find(ids, models[m].free_ids()[k]); own != ids.end())
                models[m].set_value(k, guess.value(static_cast<std::size_t>(own - ids.begin())));
        std::ranges::fill(models[m].error_values, 0.0);
        const FreeParameter& size = *own_size(models[m], effect);
        size.access.set(models[m].spec, absent_value(size));
    }
    for (std::size_t reference = 0; reference < models.size(); ++reference) {
        StemModel own = models[reference];
        keep_first_mode(guesses[reference].spec, own);
        StartModels start;
        for (std::size_t m = 0; m < models.size(); ++m) {
            StemModel model = models[m];
            model.spec.stem.bond_youngs_modulus = own.spec.stem.bond_youngs_modulus;
            model.spec.stem.bond_damping = own.spec.stem.bond_damping;
            if (const auto with =
                    m == reference
                        ? own
                        : with_mode_of(guesses[m], *own_size(models[m], effect), std::move(model)))
                start.push_back(*with);
        }
        if (start.size() == models.size())
            starts.push_back(std::move(start));
    }
    return starts;
}

physics::StartScales stem_start_scales(const physics::StemParameters<double>& stem,
                                       double duration) {
    physics::StartScales scales;
    scales.length = stem.free_length();
    scales.duration = duration;
    scales.first_frequency = physics::first_frequency(stem);
    scales.mass = physics::mass_per_length(stem) * scales.length;
    scales.stiffness = physics::stiffness_scale(stem);
    scales.residual_peaks = [] { return std::vector<double>(); };
    return scales;
}

// The strongest lines of the periodogram, at least three resolutions apart, because closer ones are
// side lobes of the same line.
std::vector<double> residual_peaks(const RecordingFit& fit, std::size_t count) {
    const ResidualSpectrum spectrum = residual_spectrum(fit);
    std::vector<std::size_t> order(spectrum.frequencies.size());
    for (std::size_t k = 0; k < order.size(); ++k)
        order[k] = k;
    std::ranges::stable_sort(order, std::greater{},
                             [&](std::size_t k) { return spectrum.power[k]; });
    std::vector<double> peaks;
    for (const std::size_t k : order) {
        const double frequency = spectrum.frequencies[k];
        const bool is_apart =
            std::ranges::all_of(peaks,
                                [&](double other) {
                                    return std::abs(frequency - other) > 3.0 * spectrum.resolution;
                                }) &&
            std::ranges::none_of(spectrum.mode_frequencies, [&](double mode) {
                return std::abs(frequency / mode - 1.0) < physics::near_resonance;
            });
        if (frequency > 0.0 && is_apart && peaks.size() < count)
            peaks.push_back(frequency);
    }
    return peaks;
}

std::vector<StemModel> fit_starts(const StemModel& model, const RecordingFit& smaller,
                                  StartSize size) {
    StemModel first = model;
    if (size == StartSize::Absent)
        for (const FreeParameter& parameter : first.parameters)
            if (!parameter.is_place && smaller.find(parameter.access.id) == nullptr)
                parameter.access.set(first.spec, absent_value(parameter));
    if (size != StartSize::Absent &&
        std::ranges::any_of(first.parameters, [&](const FreeParameter& parameter) {
            return !parameter.is_place && parameter.start_from_beat != nullptr &&
                   smaller.find(parameter.access.id) == nullptr;
        }))
        if (auto starts = beat_starts(first, smaller); !starts.empty())
            return starts;
    physics::StartScales scales = stem_start_scales(smaller.model.spec.stem, smaller.times.back());
    scales.residual_peaks = [&smaller] { return residual_peaks(smaller, 2); };
    std::vector<StemModel> starts{first};
    for (const FreeParameter& parameter : first.parameters) {
        if (parameter.start_values == nullptr || smaller.find(parameter.access.id) != nullptr ||
            (!parameter.is_place && size == StartSize::Absent))
            continue;
        std::vector<StemModel> finer;
        for (const StemModel& start : starts)
            for (const double value : parameter.start_values(scales)) {
                StemModel& added = finer.emplace_back(start);
                parameter.access.set(added.spec,
                                     std::clamp(value, parameter.lower, parameter.upper));
            }
        if (!finer.empty() && finer.size() <= most_starts)
            starts = std::move(finer);
    }
    for (StemModel& start : starts)
        keep_first_mode(smaller.model.spec, start);
    return starts;
}

bool has_own_sizes(const StemModel& model, const RecordingFit& smaller) {
    return std::ranges::any_of(model.parameters, [&](const auto& parameter) {
        return parameter.start_values != nullptr && !parameter.is_place &&
               smaller.find(parameter.access.id) == nullptr;
    });
}

std::vector<Beat> recorded_beats(const RecordingFit& fit, double angular_frequency,
                                 double decay_rate, std::size_t count) {
    const reduce::HeightHistories swing = relative_swing(fit);
    if (swing.times.size() < fewest_beat_frames || swing.histories.empty()) // or held straight
        return {};
    double left = 0.0;
    for (std::size_t at = fit.residuals.size() - swing.times.size() * fit.prediction.rows;
         at < fit.residuals.size(); ++at)
        left += std::isnan(fit.residuals[at]) ? 0.0 : fit.residuals[at] * fit.residuals[at];
    std::vector<Candidate> candidates;
    for (const double split : first_splits)
        for (const double stronger : {1.0 + 0.5 * split, 1.0 - 0.5 * split})
            candidates.push_back(solved(swing, angular_frequency / (2.0 * std::numbers::pi),
                                        decay_rate, split, stronger));
    std::ranges::stable_sort(candidates, {}, &Candidate::left);
    std::vector<Beat> beats;
    for (const auto& [beat, rest] : candidates) {
        if (!(rest < (1.0 - needed_beat_gain) * left) || beats.size() == count)
            break;
        if (std::ranges::none_of(beats, [&own = beat](const Beat& other) {
                return std::abs(other.split / own.split - 1.0) < same_split &&
                       std::abs(other.angle - own.angle) < same_split;
            }))
            beats.push_back(beat);
    }
    return beats;
}

int coarsest_chain(std::span<const measure::Measurement> recordings, const FitOptions& options) {
    int stated = std::numeric_limits<int>::max();
    for (const measure::Measurement& recording : recordings)
        stated = std::min(stated, chain_of(recording, options.chain).spec.stem.sphere_count);
    for (const int spheres : numbers_of_spheres)
        if (spheres < stated && suffices(spheres, recordings, options))
            return spheres;
    return stated;
}

} // namespace culm::fit
