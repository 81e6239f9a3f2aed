// SPDX-License-Identifier: BSD-3-Clause
#include "reduce/backbone/backbone.hpp"

#include "reduce/ring_down/ring_down_model.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Core>

namespace culm::reduce {
namespace {

constexpr double cycles_of_window = 8.0;
constexpr double least_amplitude = 4.0; ///< standard errors
constexpr double farthest_other = 0.03; ///< from the frequency of the whole record

/// Mode `k` in a window: with the others free, else with their rates of the whole record.
std::optional<DampedMode> mode_in(const HeightHistories& window, std::vector<ModeRate> rates,
                                  std::size_t k) {
    if (const auto all = fit_damped_modes(window, rates)) {
        bool is_plausible = true;
        for (std::size_t m = 0; m < rates.size(); ++m) {
            const ModeRate& found = all->modes[m].rate;
            if (m != k)
                is_plausible =
                    is_plausible && found.decay_rate < 0.0 &&
                    std::abs(found.frequency / rates[m].frequency - 1.0) < farthest_other;
        }
        if (is_plausible)
            return all->modes[k];
    }
    for (std::size_t m = 0; m < rates.size(); ++m)
        rates[m].is_free = m == k;
    if (const auto alone = fit_damped_modes(window, rates))
        return alone->modes[k];
    return std::nullopt;
}

/// Share of its first amplitude to which the numbers of a window belong. Least squares weighs ln
/// A(t) by A², so b is the mean of the local rates with the weight of a regression's slope; the
/// mean of A = e^(bt) with this weight is the slope of ∫A dt.
double seen_share(double decay_rate, double duration) {
    const Eigen::ArrayXd time = Eigen::ArrayXd::LinSpaced(200, 0.0, duration);
    const Eigen::ArrayXd weight = (2.0 * decay_rate * time).exp();
    const Eigen::ArrayXd centred = weight * (time - (weight * time).sum() / weight.sum());
    const Eigen::ArrayXd integral = (decay_rate * time).expm1() / decay_rate;
    return (centred * integral).sum() / (centred * time).sum();
}

std::optional<BackbonePoint> point_of(const DampedMode& mode, std::size_t height, int derivatives,
                                      const HeightHistories& window) {
    const double middle = 0.5 * (window.times.back() - window.times.front());
    const double size = std::abs(mode.amplitudes[height]);
    if (!(size > least_amplitude * mode.amplitude_errors[height]) ||
        !(mode.frequency_error < 0.05 * mode.rate.frequency))
        return std::nullopt;
    const double omega = two_pi * mode.rate.frequency;
    return BackbonePoint{.amplitude = size * seen_share(mode.rate.decay_rate, 2.0 * middle) /
                                      std::pow(omega, derivatives),
                         .damping_ratio = mode.damping_ratio(),
                         .damping_error = mode.damping_ratio_error(),
                         .frequency = mode.rate.frequency,
                         .frequency_error = mode.frequency_error,
                         .time = window.times.front() + middle};
}

/// A cantilever's large swing shifts the frequency by about this times (A/L)².
constexpr double geometric_shift = 0.05;
constexpr double least_shift = 2e-4;

ModeBackbone backbone_of(const BackboneInput& input, const HeightHistories& all,
                         const std::vector<ModeRate>& rates, std::size_t k,
                         const DampedMode& whole) {
    const std::size_t height = whole.largest_height();
    ModeBackbone out;
    out.mode = k + 1;
    out.height = input.heights[height];
    out.is_strain = !input.has_deflections;
    const double length = cycles_of_window / rates[k].frequency;
    for (double begin = all.times.front(); begin + length <= all.times.back() + 1e-9;
         begin += 0.5 * length) {
        const HeightHistories window = part_of(all, begin, begin + length);
        const auto found = mode_in(window, rates, k);
        if (!found)
            continue;
        if (const auto point = point_of(*found, height, input.derivatives[height], window))
            out.points.push_back(*point);
        else if (!out.points.empty())
            break; // the mode has decayed
    }
    out.laws = amplitude_laws(out.points);
    if (!out.laws) {
        out.reason = out.points.size() < 5 ? "fewer than five windows of eight cycles show it"
                                           : "its amplitude changes too little";
        return out;
    }
    const double swing =
        input.has_deflections ? out.laws->reference / std::max(input.heights[height], 1e-9) : 0.1;
    if (k == 0)
        out.signature = amplitude_class(out.points, *out.laws,
                                        std::max(least_shift, geometric_shift * swing * swing));
    return out;
}

} // namespace

HeightHistories free_part(const BackboneInput& input) {
    const HeightHistories& all = input.histories;
    return all.times.empty() ? all
                             : part_of(all, std::max(0.0, all.times.front()),
                                       input.last > 0.0 ? input.last : all.times.back());
}

std::vector<ModeBackbone> backbones(const BackboneInput& input, std::size_t count) {
    std::vector<ModeBackbone> out;
    const HeightHistories all = free_part(input);
    if (all.times.size() < 12)
        return out;
    const std::vector<ModeRate> rates = visible_modes(all, count);
    if (rates.empty())
        return out;
    std::vector<ModeRate> fixed = rates;
    for (ModeRate& rate : fixed)
        rate.is_free = false;
    const auto whole = fit_damped_modes(all, fixed);
    for (std::size_t k = 0; whole && k < rates.size(); ++k)
        out.push_back(backbone_of(input, all, rates, k, whole->modes[k]));
    return out;
}

} // namespace culm::reduce
