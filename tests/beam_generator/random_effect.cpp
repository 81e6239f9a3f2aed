// SPDX-License-Identifier: BSD-3-Clause
#include "beam_generator/random_effect.hpp"

#include "core/error.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <fmt/core.h>

namespace culm::beam {
namespace {

double angular_frequency(const Pull& pull) {
    return 2.0 * std::numbers::pi * pull.stem.first_frequency();
}

/// 3 δ/L², the curvature at the root of a cantilever that is held at its tip.
double root_curvature(const Pull& pull) {
    return 3.0 * pull.tip_deflection / (pull.stem.length * pull.stem.length);
}

double root_moment(const Pull& pull) {
    return pull.stem.rigidity() * root_curvature(pull);
}

double holding_force(const Pull& pull) {
    return root_moment(pull) / pull.stem.length;
}

double tip_speed(const Pull& pull) {
    return angular_frequency(pull) * pull.tip_deflection;
}

/// A clamp that adds 1 … 8 % of the stem's own compliance E I/L.
double clamp_stiffness(const Pull& pull, Dice& dice) {
    return pull.stem.rigidity() / pull.stem.length / dice.log_between(0.01, 0.08);
}

using Draw = HiddenEffect (*)(const Pull&, Dice&);

struct Drawn {
    std::string_view name;
    Draw draw;
};

constexpr std::array stem_effects{
    Drawn{"taper",
          [](const Pull&, Dice& dice) -> HiddenEffect {
              return {"taper", {{"relative_change", dice.sign() * dice.log_between(0.02, 0.25)}}};
          }},
    Drawn{"stiffness_gradient",
          [](const Pull&, Dice& dice) -> HiddenEffect {
              return {"stiffness_gradient",
                      {{"relative_change", dice.sign() * dice.log_between(0.05, 0.6)}}};
          }},
    Drawn{"local_defect",
          [](const Pull& pull, Dice& dice) -> HiddenEffect {
              const double place = dice.between(0.08, 0.7) * pull.stem.length;
              // Compliance of the segment beyond its own: 0.1 … 3 times that.
              return {"local_defect",
                      {{"position_m", place},
                       {"stiffness_factor", 1.0 / (1.0 + dice.log_between(0.1, 3.0))}}};
          }},
    Drawn{"precurvature",
          [](const Pull& pull, Dice& dice) -> HiddenEffect {
              const double base = dice.sign() * dice.log_between(1e-3, 0.05) / pull.stem.length;
              return {"precurvature",
                      {{"base_curvature_1_m", base},
                       {"tip_curvature_1_m", base * dice.between(-0.5, 1.5)}}};
          }},
    Drawn{"out_of_plane",
          [](const Pull&, Dice& dice) -> HiddenEffect {
              const double split = dice.log_between(0.01, 0.15);
              return {"out_of_plane",
                      {{"stiffness_split", split}, {"angle_deg", dice.between(15.0, 75.0)}}};
          }},
    Drawn{
        "bending_nonlinearity",
        [](const Pull& pull, Dice& dice) -> HiddenEffect {
            const double share = dice.log_between(0.003, 0.15); // at the root, when pulled
            const double sign = dice.happens(0.75) ? -1.0 : 1.0;
            const double curvature = root_curvature(pull);
            return {"bending_nonlinearity", {{"gamma_m2", sign * share / (curvature * curvature)}}};
        }},
    Drawn{"hysteretic_damping",
          [](const Pull&, Dice& dice) -> HiddenEffect {
              return {"hysteretic_damping", {{"loss_factor", dice.log_between(0.005, 0.08)}}};
          }},
    Drawn{"relaxation",
          [](const Pull& pull, Dice& dice) -> HiddenEffect {
              const double fraction = dice.log_between(0.003, 0.08);
              const double time = dice.log_between(0.002, 1.0);
              return {"relaxation",
                      {{"fraction", fraction}, {"time_s", time}, {"hold_time_s", pull.hold_time}}};
          }},
};

constexpr std::array outer_effects{
    Drawn{"clamp_compliance",
          [](const Pull& pull, Dice& dice) -> HiddenEffect {
              // Its loss is an error of the law (law_errors.hpp).
              return {"clamp_compliance",
                      {{"stiffness_nm_rad", clamp_stiffness(pull, dice)}, {"loss_factor", 0.0}}};
          }},
    Drawn{"clamp_friction",
          [](const Pull& pull, Dice& dice) -> HiddenEffect {
              const double moment = root_moment(pull) * dice.log_between(0.002, 0.05);
              return {"clamp_friction",
                      {{"moment_nm", moment},
                       {"stiffness_nm_rad", clamp_stiffness(pull, dice)},
                       {"rate_rad_s", 0.05}}};
          }},
    Drawn{"base_motion",
          [](const Pull&, Dice& dice) -> HiddenEffect {
              const double amplitude = dice.log_between(1e-5, 3e-4);
              const double frequency = dice.log_between(8.0, 300.0);
              return {"base_motion",
                      {{"amplitude_m", amplitude},
                       {"frequency_hz", frequency},
                       {"phase_rad", dice.between(-std::numbers::pi, std::numbers::pi)}}};
          }},
    Drawn{"gravity",
          [](const Pull& pull, Dice&) -> HiddenEffect {
              constexpr double standard = 9.80665;
              const bool across = pull.gravity == measure::GravityDirection::Transverse;
              return {"gravity",
                      {{"axial_m_s2", across ? 0.0 : -standard},
                       {"transverse_m_s2", across ? standard : 0.0}}};
          }},
    Drawn{"tip_mass",
          [](const Pull& pull, Dice& dice) -> HiddenEffect {
              const double mass = pull.stem.mass_per_length() * pull.stem.length;
              return {"tip_mass", {{"mass_kg", mass * dice.log_between(0.01, 0.4)}}};
          }},
    Drawn{"quadratic_drag",
          [](const Pull&, Dice& dice) -> HiddenEffect {
              return {"quadratic_drag", {{"drag_coefficient", dice.log_between(0.1, 4.0)}}};
          }},
    Drawn{"viscous_drag",
          [](const Pull& pull, Dice& dice) -> HiddenEffect {
              const double critical = 2.0 * pull.stem.mass_per_length() * angular_frequency(pull);
              return {"viscous_drag",
                      {{"coefficient_n_s_m2", critical * dice.log_between(0.001, 0.03)}}};
          }},
    Drawn{"finite_release",
          [](const Pull& pull, Dice& dice) -> HiddenEffect {
              return {"finite_release",
                      {{"duration_s", dice.log_between(0.05, 0.7) / pull.stem.first_frequency()}}};
          }},
    Drawn{
        "rolling_shutter",
        [](const Pull&, Dice& dice) -> HiddenEffect {
            return {"rolling_shutter", {{"readout_s", dice.sign() * dice.log_between(1e-5, 1e-3)}}};
        }},
    Drawn{
        "camera_tilt",
        [](const Pull&, Dice& dice) -> HiddenEffect {
            return {"camera_tilt", {{"scale_change", dice.sign() * dice.log_between(0.003, 0.1)}}};
        }},
};

/// Strain at the root when pulled, over 0.001.
double relative_strain(const Pull& pull) {
    return 0.5 * pull.stem.diameter * root_curvature(pull) / 1e-3;
}

constexpr std::array amplitude_effects{
    Drawn{"plate_air",
          [](const Pull&, Dice& dice) -> HiddenEffect {
              return {"plate_air",
                      {{"drag_amplitude", dice.between(6.0, 10.0)},
                       {"mass_amplitude", dice.between(0.25, 0.45)}}};
          }},
    Drawn{"still_air",
          [](const Pull&, Dice&) -> HiddenEffect {
              return {"still_air", {{"density_kg_m3", 1.2}, {"viscosity_m2_s", 1.5e-5}}};
          }},
    Drawn{"amplitude_damping",
          [](const Pull& pull, Dice& dice) -> HiddenEffect {
              const double power = dice.between(0.7, 2.0);
              return {"amplitude_damping",
                      {{"loss_factor",
                        dice.log_between(0.01, 0.06) * std::pow(relative_strain(pull), -power)},
                       {"exponent", power}}};
          }},
    Drawn{"clamp_slip",
          [](const Pull& pull, Dice& dice) -> HiddenEffect {
              const double power = dice.between(0.7, 1.5);
              return {
                  "clamp_slip",
                  {{"slip_share", dice.between(0.1, 0.5) * std::pow(relative_strain(pull), -power)},
                   {"stiffness_nm_rad", clamp_stiffness(pull, dice)},
                   {"exponent", power}}};
          }},
};

constexpr std::array unknown_effects{
    Drawn{"tip_magnet",
          [](const Pull& pull, Dice& dice) -> HiddenEffect {
              const double force = holding_force(pull) * dice.log_between(0.02, 0.15);
              return {
                  "tip_magnet",
                  {{"force_n", force}, {"reach_m", pull.tip_deflection * dice.between(0.15, 0.4)}}};
          }},
    Drawn{"lossy_cable",
          [](const Pull& pull, Dice& dice) -> HiddenEffect {
              const double force = holding_force(pull) * dice.log_between(0.005, 0.04);
              return {
                  "lossy_cable",
                  {{"force_n", force}, {"speed_m_s", tip_speed(pull) * dice.between(0.1, 0.4)}}};
          }},
    Drawn{"impact_stop",
          [](const Pull& pull, Dice& dice) -> HiddenEffect {
              const double share = dice.between(0.4, 0.8);
              // The static shape of a cantilever under a force at its tip.
              const double swing = pull.tip_deflection * 0.5 * share * share * (3.0 - share);
              const double stiffness =
                  holding_force(pull) / pull.tip_deflection * dice.log_between(3.0, 30.0);
              return {"impact_stop",
                      {{"height_m", share * pull.stem.length},
                       {"gap_m", swing * dice.between(0.2, 0.7)},
                       {"stiffness_n_m", stiffness},
                       {"damping_n_s_m", 0.1 * stiffness / angular_frequency(pull)}}};
          }},
    Drawn{"cubic_drag",
          [](const Pull& pull, Dice& dice) -> HiddenEffect {
              // ¾ c v² is the linear coefficient of the same loss.
              const double linear = 2.0 * pull.stem.mass_per_length() * angular_frequency(pull) *
                                    dice.log_between(0.005, 0.06);
              const double speed = tip_speed(pull);
              return {"cubic_drag", {{"coefficient_n_s3_m4", linear / (0.75 * speed * speed)}}};
          }},
    Drawn{"curvature_damping",
          [](const Pull& pull, Dice& dice) -> HiddenEffect {
              // δ κ²/4 is the linear damping time of the same loss.
              const double time = 2.0 * dice.log_between(0.005, 0.06) / angular_frequency(pull);
              const double curvature = root_curvature(pull);
              return {"curvature_damping",
                      {{"coefficient_m2_s", 4.0 * time / (curvature * curvature)}}};
          }},
};

} // namespace

HiddenEffect random_effect(std::string_view name, const Pull& pull, Dice& dice) {
    const auto in = [name](const auto& list) {
        const auto* const found = std::ranges::find(list, name, &Drawn::name);
        return found == list.end() ? nullptr : found->draw;
    };
    for (const Draw draw :
         {in(stem_effects), in(outer_effects), in(amplitude_effects), in(unknown_effects)})
        if (draw != nullptr)
            return draw(pull, dice);
    throw core::InputError(fmt::format("no random strengths for an effect \"{}\"", name));
}

} // namespace culm::beam
