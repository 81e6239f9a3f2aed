// SPDX-License-Identifier: BSD-3-Clause
#include "fit/errors/terms.hpp"
#include "run/modes.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace culm::fit {
namespace {

constexpr double likely_order = 4.0 / 3.0; ///< α: errors of order 2, bonds of half the length
constexpr double order_doubt = 1.0 / 3.0;
constexpr double negligible_shift = 0.3; ///< of a frequency's standard deviation

/// Standard deviation of the frequency of a decaying mode, Hz (Montgomery & O'Donoghue 1999).
/// Frames after a decay by e add almost no information.
double frequency_uncertainty(const RecordingFit& fit, const NoiseModel* model,
                             const integrate::VibrationMode& mode, double amplitude) {
    const double recorded = fit.times.back();
    const double duration =
        mode.decay_rate < 0.0 ? std::min(recorded, -1.0 / mode.decay_rate) : recorded;
    const double readings = static_cast<double>(fit.readings) * duration / recorded;
    double noise = std::ranges::min(fit.noise);
    // Slow noise has less power at a mode's frequency than white noise of its size.
    if (model != nullptr)
        noise *= std::sqrt((1.0 - model->correlation) / (1.0 + model->correlation));
    return std::sqrt(6.0 / std::max(readings, 1.0)) * noise /
           (std::numbers::pi * amplitude * duration);
}

/// The chain with twice the number of bonds and the same first mode; empty if it makes no
/// difference.
std::optional<StemModel> finer_chain(const RecordingFit& fit, const NoiseModel* noise_model) {
    StemModel model = fixed_model(fit.model);
    const run::CaseSpec coarse = model.spec;
    const auto modes = run::chain_modes(coarse, 2);
    if (modes.size() < 2 || coarse.tip_deflection == 0.0)
        return std::nullopt;
    model = with_spheres(std::move(model), 2 * coarse.stem.sphere_count - 1);
    const auto finer_modes = run::chain_modes(model.spec, 2);
    if (finer_modes.size() < 2)
        return std::nullopt;
    // If a stem is pulled at its tip, the second mode has (f₁/f₂)² of the first mode's amplitude.
    const double amplitude =
        std::abs(coarse.tip_deflection) * std::pow(modes[0].frequency / modes[1].frequency, 2);
    if (!(std::abs(finer_modes[1].frequency - modes[1].frequency) >
          negligible_shift * frequency_uncertainty(fit, noise_model, modes[1], amplitude)))
        return std::nullopt;
    return model;
}

} // namespace

Division division_of(const RecordingFit& fit, const NoiseModel* noise_model,
                     const run::Heartbeat& heartbeat) {
    Division out;
    const std::optional<StemModel> finer = finer_chain(fit, noise_model);
    if (!finer)
        return out;
    const ChainPrediction then = predict_readings(*finer, fit.times, heartbeat);
    out.batches = then.batches;
    out.doubt = {ErrorKind::Division, "division of the chain", {}};
    for (std::size_t at = 0; at < then.readings.size(); ++at) {
        double change = then.readings[at] - fit.prediction.readings[at];
        change = std::isfinite(change) ? change : 0.0;
        out.known.push_back(likely_order * change);
        out.doubt->readings.push_back(order_doubt * change);
    }
    return out;
}

} // namespace culm::fit
