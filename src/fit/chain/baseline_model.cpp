// SPDX-License-Identifier: BSD-3-Clause
#include "fit/chain/baseline_model.hpp"

#include "core/error.hpp"
#include "fit/chain/first_motion.hpp"
#include "fit/chain/higher_modes.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <string>
#include <utility>

#include <fmt/core.h>

namespace culm::fit {
namespace {

/// Samples per cycle of the first mode. The second mode then has 19 samples per cycle, and its
/// interpolation error is 3e-4 of its amplitude.
constexpr double samples_per_cycle = 120.0;
constexpr double largest_release_shift = 1.5; // frames
constexpr double release_coverage = 3.0;      // standard uncertainties of the release
/// Rates and strains show higher modes, which need denser samples.
constexpr double share_for_sensors = 0.5;

} // namespace

StemModel baseline_model(const measure::Measurement& measurement, const ChainOptions& options) {
    if (const std::string doubt = measure::doubt_of_zero(measurement, true); !doubt.empty())
        throw core::InputError(fmt::format("{}: {}", measurement.stem.id, doubt));
    StemChain chain = chain_of(measurement, options);
    StemModel model{chain.spec, baseline_free_parameters(), 0.0, 0.0, std::move(chain.remarks), {},
                    {}};
    model.exposure = measurement.exposure.value_or(0.0);
    model.release_time_bound =
        std::max(largest_release_shift * frame_period(measurement),
                 release_coverage * measurement.release_uncertainty.value_or(0.0));

    const RowRingDown ring_down = measured_ring_down(measurement);
    // b2 is the damped frequency and b1/b2 = −2π ζ/√(1 − ζ²).
    const double decay =
        std::max(-ring_down.fit.decay_per_cycle.value, 0.0) / (2.0 * std::numbers::pi);
    const double frequency = ring_down.fit.frequency.value * std::hypot(1.0, decay); // undamped, Hz
    run::CaseSpec& spec = model.spec;
    const double damping_ratio = decay / std::hypot(1.0, decay);
    set_first_mode(frequency, ring_down.fit.decay_rate.value, model);
    spec.stem.bond_damping = 1.0;
    // M = E I (κ + τ κ̇) damps a mode of angular frequency ω by ζ = ωτ/2.
    const double wanted = damping_ratio / (std::numbers::pi * frequency);
    spec.stem.bond_damping = std::max(wanted / damping_time(spec), 1e-3);
    set_first_mode(frequency, ring_down.fit.decay_rate.value, model);
    spec.sample_interval = 1.0 / (samples_per_cycle * frequency);
    if (!measurement.sensors.empty())
        spec.sample_interval *= share_for_sensors;
    if (measurement.release == measure::ReleaseKind::HeldStraight) {
        model.parameters.pop_back(); // the tip's deflection before the release
        spec.tip_deflection = 0.0;
        return model;
    }
    if (measurement.sensors.empty()) {
        spec.tip_deflection = released_deflection(measurement);
    } else {
        const std::complex<double> motion = tip_motion(measurement, ring_down);
        spec.tip_deflection = std::abs(motion) * std::cos(std::arg(motion));
    }
    if (measurement.release == measure::ReleaseKind::Moving)
        release_before(measurement, ring_down, model);
    FreeParameter& deflection = model.parameters.back();
    deflection.upper = 0.95 * measurement.stem.length;
    deflection.lower = -deflection.upper;
    if (measurement.release == measure::ReleaseKind::Moving)
        add_higher_modes(measurement, 2.0 * damping_ratio, model);
    return model;
}

} // namespace culm::fit
