// SPDX-License-Identifier: BSD-3-Clause
#include "fit/start/starts.hpp"

#include "fit/start/beat.hpp"
#include "fit/start/residual_spectrum.hpp"
#include "physics/effects/library.hpp"
#include "physics/effects/stem_scales.hpp"
#include "run/modes.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>

namespace culm::fit {

namespace {

constexpr std::size_t most_starts = 12;
constexpr std::size_t most_beats = 2;
/// Share of the bonds' damping that remains at least if an effect adds damping.
constexpr double smallest_damping_share = 0.05;

/// The effect's parameter for a free one; empty for parameters of the plain chain.
std::optional<physics::EffectParameter> described(const StemModel& model,
                                                  const FreeParameter& parameter) {
    return physics::parameter_named(model.spec.effects, parameter.access.id);
}

physics::StartScales scales_of(const RecordingFit& fit) {
    physics::StartScales scales = stem_start_scales(fit.model.spec.stem, fit.times.back());
    scales.residual_peaks = [&fit] { return residual_peaks(fit, 2); };
    return scales;
}

} // namespace

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

void keep_first_mode(const integrate::VibrationMode& wanted, StemModel& start) {
    physics::StemParameters<double>& stem = start.spec.stem;
    // A frequency with a relative error of 1/N is a cycle off after N cycles, and no gradient leads
    // back. The start therefore keeps the first mode of the readings.
    for (int pass = 0; pass < 2; ++pass) { // the effect's share of the stiffness depends on Y
        const auto modes = run::chain_modes(start.spec, 1);
        if (modes.empty())
            return;
        stem.bond_youngs_modulus *= std::pow(wanted.frequency / modes.front().frequency, 2);
    }
    const auto modes = run::chain_modes(start.spec, 1);
    run::CaseSpec half = start.spec;
    half.stem.bond_damping *= 0.5;
    const auto half_damped = run::chain_modes(half, 1);
    if (modes.empty() || half_damped.empty())
        return;
    // The decay is linear in β.
    const double from_bonds =
        2.0 * (modes.front().decay_per_cycle - half_damped.front().decay_per_cycle);
    const double excess = modes.front().decay_per_cycle - wanted.decay_per_cycle;
    if (from_bonds < 0.0)
        stem.bond_damping *= std::max(1.0 - excess / from_bonds, smallest_damping_share);
}

double absent_value(const FreeParameter& parameter) {
    return parameter.fitted_as == physics::FittedAs::Inverse
               ? parameter.upper
               : std::clamp(parameter.absent, parameter.lower, parameter.upper);
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
        const bool is_apart = std::ranges::all_of(peaks, [&](double other) {
            return std::abs(frequency - other) > 3.0 * spectrum.resolution;
        });
        if (frequency > 0.0 && is_apart && peaks.size() < count)
            peaks.push_back(frequency);
    }
    return peaks;
}

/// Starts for a stem that leaves the plane, from the beats in its readings. Empty if none.
std::vector<StemModel> beat_starts(const StemModel& first, const RecordingFit& smaller,
                                   const integrate::VibrationMode& mode) {
    std::vector<StemModel> starts;
    const double angular_frequency = 2.0 * std::numbers::pi * mode.frequency;
    if (!(mode.decay_rate < 0.0))
        return starts;
    for (const Beat& beat :
         recorded_beats(smaller, angular_frequency, -mode.decay_rate, most_beats)) {
        StemModel& start = starts.emplace_back(first);
        start.spec.stem.bond_youngs_modulus *=
            std::pow(beat.angular_frequency / angular_frequency, 2);
        start.spec.stem.bond_damping *= beat.decay_rate / -mode.decay_rate;
        start.spec.tip_deflection *= beat.amplitude;
        for (const FreeParameter& parameter : start.parameters) {
            const auto of = described(start, parameter);
            const double value = of && of->start_from_beat != nullptr
                                     ? of->start_from_beat({beat.split, beat.angle})
                                     : parameter.access.get(start.spec);
            parameter.access.set(start.spec, std::clamp(value, parameter.lower, parameter.upper));
        }
    }
    return starts;
}

std::vector<StemModel> fit_starts(const StemModel& model, const RecordingFit& smaller,
                                  StartSize size) {
    StemModel first = started_from(model, smaller);
    if (size == StartSize::Absent)
        for (const FreeParameter& parameter : first.parameters)
            if (!parameter.is_place && smaller.find(parameter.access.id) == nullptr)
                parameter.access.set(first.spec, absent_value(parameter));
    const auto modes = run::chain_modes(smaller.model.spec, 1);
    if (size != StartSize::Absent && !modes.empty() &&
        std::ranges::any_of(first.parameters, [&](const FreeParameter& parameter) {
            const auto of = described(first, parameter);
            return of && !of->is_place && of->start_from_beat != nullptr &&
                   smaller.find(parameter.access.id) == nullptr;
        }))
        if (auto starts = beat_starts(first, smaller, modes.front()); !starts.empty())
            return starts;
    const physics::StartScales scales = scales_of(smaller);
    std::vector<StemModel> starts{first};
    for (const FreeParameter& parameter : first.parameters) {
        const auto of = described(first, parameter);
        if (!of || of->start_values == nullptr || smaller.find(parameter.access.id) != nullptr ||
            (!of->is_place && size == StartSize::Absent))
            continue;
        std::vector<StemModel> finer;
        for (const StemModel& start : starts)
            for (const double value : of->start_values(scales)) {
                StemModel& added = finer.emplace_back(start);
                parameter.access.set(added.spec,
                                     std::clamp(value, parameter.lower, parameter.upper));
            }
        if (!finer.empty() && finer.size() <= most_starts)
            starts = std::move(finer);
    }
    if (!modes.empty())
        for (StemModel& start : starts)
            keep_first_mode(modes.front(), start);
    return starts;
}

bool has_own_sizes(const StemModel& model, const RecordingFit& smaller) {
    return std::ranges::any_of(model.parameters, [&](const auto& parameter) {
        const auto of = described(model, parameter);
        return of && of->start_values != nullptr && !of->is_place &&
               smaller.find(parameter.access.id) == nullptr;
    });
}

std::vector<StemModel> candidate_starts(const StemModel& model, const RecordingFit& smaller) {
    if (has_own_sizes(model, smaller))
        return fit_starts(model, smaller, StartSize::Default);
    std::vector<StemModel> starts = fit_starts(model, smaller, StartSize::Absent);
    const bool has_new_size = std::ranges::any_of(model.parameters, [&](const auto& parameter) {
        return !parameter.is_place && smaller.find(parameter.access.id) == nullptr;
    });
    if (starts.size() == 1 && has_new_size)
        starts.push_back(fit_starts(model, smaller, StartSize::Default).front());
    return starts;
}

} // namespace culm::fit
