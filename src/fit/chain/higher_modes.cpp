// SPDX-License-Identifier: BSD-3-Clause
#include "fit/chain/higher_modes.hpp"

#include "fit/chain/first_motion.hpp"
#include "run/modes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <numbers>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include <fmt/core.h>

namespace culm::fit {
namespace {

using Complex = std::complex<double>;

constexpr double visible_share = 0.4; ///< of the frame rate
constexpr double first_cycles = 8.0;
constexpr double loss_uncertainty = std::numbers::ln2;
constexpr double softening_uncertainty = 0.01;
constexpr double share_uncertainty = 0.5;
constexpr double small_change = 1e-5; ///< for derivatives of the chain's modes

/// A mode of a chain with this frequency, Hz.
class Motion {
  public:
    Motion(const run::HigherMode& mode, double chain_frequency)
        : mode_(mode), loss_(mode.recorded_decay * std::exp(mode.log_loss)),
          frequency_(2.0 * std::numbers::pi * chain_frequency * std::exp(mode.log_frequency)) {
        const Complex rate = rate_at(0.0);
        amplitude_ = {mode.deflection, (rate.real() * mode.deflection - mode.speed) / rate.imag()};
    }

    /// Deflection of the tip at a time ≥ 0, or its derivative of this order.
    [[nodiscard]] double at(double time, int order) const {
        // ∫ e^(−γt) dt
        const double swing = mode_.first_decay > 0.0
                                 ? -std::expm1(-mode_.first_decay * time) / mode_.first_decay
                                 : time;
        Complex motion =
            amplitude_ * std::exp(Complex(-loss_ * (time + mode_.loss_share * (swing - time)),
                                          frequency_ * (time - mode_.softening * swing)));
        for (int k = 0; k < order; ++k)
            motion *= rate_at(time);
        return motion.real();
    }

  private:
    [[nodiscard]] Complex rate_at(double time) const {
        const double swing = std::exp(-mode_.first_decay * time);
        return {-loss_ * (1.0 + mode_.loss_share * (swing - 1.0)),
                frequency_ * (1.0 - mode_.softening * swing)};
    }

    run::HigherMode mode_;
    double loss_;      ///< 1/s
    double frequency_; ///< 1/s
    Complex amplitude_;
};

/// Parameter of a mode: a member with its unit and the deviation within which it is known to be 0.
FreeParameter parameter_of(std::size_t mode, const char* name, const char* unit, double within,
                           double run::HigherMode::*member) {
    FreeParameter parameter = chain_parameter(
        {{{}, fmt::format("mode_{}_{}", mode + 1, name), {}},
         [mode, member](const run::CaseSpec& spec) { return spec.higher_modes[mode - 1].*member; },
         [mode, member](run::CaseSpec& spec, double value) {
             spec.higher_modes[mode - 1].*member = value;
         },
         within},
        unit, -20.0 * within, 20.0 * within);
    parameter.known_within = within;
    return parameter;
}

/// The start of a mode from a damped mode of the readings, at the row where it is largest.
void set_start(const reduce::DampedMode& shown, const run::ShapedMode& shaped, double first_time,
               const measure::Measurement& measurement, run::HigherMode& mode) {
    const std::size_t row = shown.largest_height();
    const Complex rate(shown.rate.decay_rate, 2.0 * std::numbers::pi * shown.rate.frequency);
    const Complex per_tip =
        shaped.reading[row] * std::pow(rate, measurement.time_derivatives_at(row));
    if (std::abs(per_tip) == 0.0)
        return;
    const Complex at_start = shown.amplitudes[row] / per_tip * std::exp(-rate * first_time);
    mode.deflection = at_start.real();
    mode.speed = (rate * at_start).real();
    mode.log_frequency = std::log(shown.rate.frequency / shaped.mode.frequency);
    mode.recorded_decay = -rate.real();
}

} // namespace

double log_frequency_uncertainty(double loss_factor, double frequency_ratio, int spheres) {
    // Error of f_k/f₁ of a chain of N bonds, times N²: a quarter of that of bending at spheres.
    constexpr double chain_error = 0.5;
    const double bonds = spheres - 1;
    return std::max(2.0 / std::numbers::pi * loss_factor * std::log(frequency_ratio),
                    chain_error / (bonds * bonds));
}

void add_higher_modes(const measure::Measurement& measurement, double loss_factor,
                      StemModel& model) {
    model.spec.release = run::Release::FirstMode;
    const std::vector<run::ShapedMode> chain =
        run::shaped_modes(model.spec, model.spec.higher_modes.size() + 1);
    const double first = chain.front().mode.frequency;
    const reduce::HeightHistories early =
        reduce::part_of(height_histories(measurement), 0.0, first_cycles / first);
    const auto shown = reduce::fit_damped_modes(early, reduce::visible_modes(early, chain.size()));
    const double pull = std::abs(model.spec.tip_deflection);
    for (std::size_t mode = 1; mode < chain.size(); ++mode) {
        const double frequency = chain[mode].mode.frequency;
        if (frequency * frame_period(measurement) > visible_share)
            continue;
        const double within =
            log_frequency_uncertainty(loss_factor, frequency / first, model.spec.stem.sphere_count);
        using Mode = run::HigherMode;
        const double speed = 2.0 * std::numbers::pi * frequency * pull;
        for (const auto& [name, unit, size, member] :
             {std::tuple{"deflection", "m", pull, &Mode::deflection},
              {"speed", "m/s", speed, &Mode::speed},
              {"log_frequency", "", within, &Mode::log_frequency},
              {"softening", "", softening_uncertainty, &Mode::softening},
              {"log_loss", "", loss_uncertainty, &Mode::log_loss},
              {"loss_share", "", share_uncertainty, &Mode::loss_share}})
            model.parameters.push_back(parameter_of(mode, name, unit, size, member));
        model.parameters.back().lower = 0.0;
        model.parameters.back().upper = 1.0;
        Mode& own = model.spec.higher_modes[mode - 1];
        own.recorded_decay = -chain[mode].mode.decay_rate;
        own.first_decay = -chain.front().mode.decay_rate;
        // The shown mode that is nearest.
        const reduce::DampedMode* nearest = nullptr;
        for (std::size_t k = 1; shown && k < shown->modes.size(); ++k)
            if (std::abs(std::log(shown->modes[k].rate.frequency / frequency)) < 0.2)
                nearest = &shown->modes[k];
        if (nearest != nullptr)
            set_start(*nearest, chain[mode], early.times.front(), measurement, own);
    }
    for (FreeParameter& parameter : model.parameters)
        if (physics::is_of_higher_mode(parameter.access.id))
            parameter.access.set(model.spec, std::clamp(parameter.access.get(model.spec),
                                                        parameter.lower, parameter.upper));
}

void superpose_higher_modes(const StemModel& model, std::span<const double> times,
                            ChainPrediction& prediction) {
    const run::CaseSpec spec = computed_case(model);
    const std::size_t count = spec.higher_modes.size() + 1;
    const std::vector<run::ShapedMode> chain = run::shaped_modes(spec, count);
    // (times, rows) of a case.
    const auto readings_of = [&](const run::CaseSpec& of) {
        std::vector<double> readings(times.size() * prediction.rows, 0.0);
        for (std::size_t k = 1; k < chain.size(); ++k) {
            const Motion motion(of.higher_modes[k - 1], chain[k].mode.frequency);
            for (std::size_t at = 0; at < readings.size(); ++at) {
                const std::size_t j = at % prediction.rows;
                const int order = of.sensors.empty() ? 0 : of.sensors[j].time_derivatives();
                readings[at] += chain[k].reading[j] * motion.at(times[at / prediction.rows], order);
            }
        }
        return readings;
    };
    const std::vector<double> here = readings_of(spec);
    for (std::size_t at = 0; at < here.size(); ++at)
        prediction.readings[at] += here[at];
    for (std::size_t p = 0; p < model.parameters.size(); ++p) {
        const FreeParameter& parameter = model.parameters[p];
        if (parameter.access.id == physics::tip_deflection)
            continue;
        const double value = parameter.access.get(spec);
        const double size = parameter.access.scale > 0.0 ? parameter.access.scale : std::abs(value);
        run::CaseSpec moved = spec;
        parameter.access.set(moved, value + small_change * size);
        if (!physics::is_of_higher_mode(parameter.access.id)) {
            const std::vector<integrate::VibrationMode> its = run::chain_modes(moved, count);
            for (std::size_t k = 1; k < chain.size() && k < its.size(); ++k)
                moved.higher_modes[k - 1].log_frequency +=
                    std::log(its[k].frequency / chain[k].mode.frequency);
        }
        const std::vector<double> changed = readings_of(moved);
        const double change = to_coordinate(parameter.fitted_as, value + small_change * size) -
                              to_coordinate(parameter.fitted_as, value);
        for (std::size_t at = 0; at < here.size(); ++at)
            prediction.jacobian[at * prediction.parameters + p] +=
                (changed[at] - here[at]) / change;
    }
}

} // namespace culm::fit
