// SPDX-License-Identifier: BSD-3-Clause
#include "beam_generator/hidden_effect.hpp"

#include "beam_generator/constant_loss.hpp"
#include "core/error.hpp"
#include "core/nearest_name.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string_view>

#include <fmt/core.h>

namespace culm::beam {
namespace {

constexpr double air_density = 1.2;    // kg/m³
constexpr double segment_share = 0.03; // length of a weak segment over that of the stem

struct Target {
    const BeamStem& stem;
    const LawErrors& errors;
    HiddenPhysics& physics;

    [[nodiscard]] BeamTerms& terms() const { return physics.terms; }
};

using Add = void (*)(const HiddenEffect&, const Target&);

struct KnownEffect {
    std::string_view name;
    Add add;
};

void add_relaxation(const HiddenEffect& effect, const Target& to) {
    std::vector<RelaxationPart> parts = to.errors.relaxation;
    if (parts.empty())
        parts.emplace_back();
    for (const RelaxationPart& part : parts) {
        const double time = part.time_ratio * effect.value("time_s");
        to.terms().branches.push_back({part.share * effect.value("fraction"), time,
                                       std::exp(-effect.value("hold_time_s") / time)});
    }
}

void add_hysteretic_damping(const HiddenEffect& effect, const Target& to) {
    for (const RelaxingBranch& branch :
         constant_loss(effect.value("loss_factor"), to.stem.first_frequency()))
        to.terms().branches.push_back(branch);
}

double angular_frequency(const Target& to) {
    return 2.0 * std::numbers::pi * to.stem.first_frequency();
}

/// A clamp of this stiffness, N m/rad.
TurningClamp soft_clamp(double stiffness, const Target& to) {
    return {.stiffness = stiffness,
            .damping = to.errors.clamp_loss_factor * stiffness / angular_frequency(to)};
}

void add_clamp_friction(const HiddenEffect& effect, const Target& to) {
    TurningClamp clamp = soft_clamp(effect.value("stiffness_nm_rad"), to);
    clamp.friction_moment = effect.value("moment_nm");
    clamp.friction_rate = effect.value("rate_rad_s");
    to.terms().clamp = clamp;
}

void add_quadratic_drag(const HiddenEffect& effect, const Target& to) {
    const double coefficient =
        0.5 * air_density * effect.value("drag_coefficient") * to.stem.diameter;
    const double exponent = to.errors.drag_exponent;
    if (exponent == 2.0)
        to.terms().quadratic_drag = coefficient;
    else
        to.terms().power_drag = {coefficient * std::pow(to.errors.drag_speed, 2.0 - exponent),
                                 exponent};
}

/// Curvature that strains the outermost fibre by 0.001.
double reference_curvature(const Target& to) {
    return 1e-3 / (0.5 * to.stem.diameter);
}

AirAround& air_around(const Target& to) {
    if (!to.terms().air)
        to.terms().air.emplace();
    AirAround& air = *to.terms().air;
    air.width = to.stem.width > 0.0 ? to.stem.width : to.stem.diameter;
    air.angular_frequency = angular_frequency(to);
    return air;
}

void add_plate_air(const HiddenEffect& effect, const Target& to) {
    AirAround& air = air_around(to);
    air.drag = effect.value("drag_amplitude");
    air.mass = effect.value("mass_amplitude");
}

/// Stokes' boundary layer of the thickness δ on a cylinder of the radius R, to (δ/R)².
void add_still_air(const HiddenEffect& effect, const Target& to) {
    AirAround& air = air_around(to);
    const double share =
        std::sqrt(2.0 * effect.value("viscosity_m2_s") / air.angular_frequency) / (0.5 * air.width);
    air.still_mass = 1.0 + 2.0 * share;
    to.terms().linear_drag += 0.25 * std::numbers::pi * effect.value("density_kg_m3") * air.width *
                              air.width * air.angular_frequency * share * (2.0 + share);
}

void add_amplitude_damping(const HiddenEffect& effect, const Target& to) {
    const double power = effect.value("exponent");
    // A cycle loses π η E I κ² with the mean ∮ |sin|^p cos².
    const double mean = std::sqrt(std::numbers::pi) * std::tgamma(0.5 * (power + 1.0)) /
                        std::tgamma(0.5 * power + 2.0);
    to.terms().strain_loss =
        StrainLoss{std::numbers::pi * effect.value("loss_factor") / (angular_frequency(to) * mean),
                   power, reference_curvature(to)};
}

void add_clamp_slip(const HiddenEffect& effect, const Target& to) {
    to.terms().clamp = soft_clamp(effect.value("stiffness_nm_rad"), to);
    const double power = effect.value("exponent");
    to.terms().slip = SlippingSpring{
        effect.value("slip_share") * std::pow(to.stem.rigidity() * reference_curvature(to), -power),
        power};
}

void add_out_of_plane(const HiddenEffect& effect, const Target& to) {
    to.terms().is_spatial = true;
    to.terms().stiffness_split = effect.value("stiffness_split");
    to.terms().split_angle = effect.value("angle_deg") * std::numbers::pi / 180.0;
}

constexpr std::array further{
    KnownEffect{"plate_air", add_plate_air},
    KnownEffect{"still_air", add_still_air},
    KnownEffect{"amplitude_damping", add_amplitude_damping},
    KnownEffect{"clamp_slip", add_clamp_slip},
};

constexpr std::array library{
    KnownEffect{"taper",
                [](const HiddenEffect& effect, const Target& to) {
                    to.terms().taper = effect.value("relative_change");
                }},
    KnownEffect{"stiffness_gradient",
                [](const HiddenEffect& effect, const Target& to) {
                    to.terms().stiffness_gradient = effect.value("relative_change");
                }},
    KnownEffect{"local_defect",
                [](const HiddenEffect& effect, const Target& to) {
                    to.terms().segment =
                        WeakSegment{effect.value("position_m"), segment_share * to.stem.length,
                                    effect.value("stiffness_factor")};
                }},
    KnownEffect{"precurvature",
                [](const HiddenEffect& effect, const Target& to) {
                    to.terms().base_curvature = effect.value("base_curvature_1_m");
                    to.terms().tip_curvature = effect.value("tip_curvature_1_m");
                }},
    KnownEffect{"out_of_plane", add_out_of_plane},
    KnownEffect{"bending_nonlinearity",
                [](const HiddenEffect& effect, const Target& to) {
                    to.terms().cubic_bending = effect.value("gamma_m2");
                }},
    KnownEffect{"hysteretic_damping", add_hysteretic_damping},
    KnownEffect{"relaxation", add_relaxation},
    KnownEffect{"clamp_compliance",
                [](const HiddenEffect& effect, const Target& to) {
                    to.terms().clamp = soft_clamp(effect.value("stiffness_nm_rad"), to);
                }},
    KnownEffect{"clamp_friction", add_clamp_friction},
    KnownEffect{"base_motion",
                [](const HiddenEffect& effect, const Target& to) {
                    to.terms().support =
                        SupportVibration{effect.value("amplitude_m"), effect.value("frequency_hz"),
                                         effect.value("phase_rad")};
                }},
    KnownEffect{"gravity",
                [](const HiddenEffect& effect, const Target& to) {
                    to.terms().axial_gravity = effect.value("axial_m_s2");
                    to.terms().transverse_gravity = effect.value("transverse_m_s2");
                }},
    KnownEffect{"tip_mass",
                [](const HiddenEffect& effect, const Target& to) {
                    to.terms().tip_mass = effect.value("mass_kg");
                }},
    KnownEffect{"quadratic_drag", add_quadratic_drag},
    KnownEffect{"viscous_drag",
                [](const HiddenEffect& effect, const Target& to) {
                    to.terms().linear_drag = effect.value("coefficient_n_s_m2");
                }},
    KnownEffect{"finite_release",
                [](const HiddenEffect& effect, const Target& to) {
                    to.terms().release_duration = effect.value("duration_s");
                }},
    KnownEffect{"rolling_shutter",
                [](const HiddenEffect& effect, const Target& to) {
                    to.physics.camera.readout_time = effect.value("readout_s");
                }},
    KnownEffect{"camera_tilt",
                [](const HiddenEffect& effect, const Target& to) {
                    to.physics.camera.scale_change = effect.value("scale_change");
                }},
};

constexpr std::array outside{
    KnownEffect{"tip_magnet",
                [](const HiddenEffect& effect, const Target& to) {
                    to.terms().magnet = TipMagnet{effect.value("force_n"), effect.value("reach_m")};
                }},
    KnownEffect{
        "lossy_cable",
        [](const HiddenEffect& effect, const Target& to) {
            to.terms().cable = LossyCable{effect.value("force_n"), effect.value("speed_m_s")};
        }},
    KnownEffect{"impact_stop",
                [](const HiddenEffect& effect, const Target& to) {
                    to.terms().stop =
                        ImpactStop{effect.value("height_m"), effect.value("gap_m"),
                                   effect.value("stiffness_n_m"), effect.value("damping_n_s_m")};
                }},
    KnownEffect{"cubic_drag",
                [](const HiddenEffect& effect, const Target& to) {
                    to.terms().cubic_drag = effect.value("coefficient_n_s3_m4");
                }},
    KnownEffect{"curvature_damping",
                [](const HiddenEffect& effect, const Target& to) {
                    to.terms().curvature_damping = effect.value("coefficient_m2_s");
                }},
};

template <std::size_t Count>
std::vector<std::string> names_of(const std::array<KnownEffect, Count>& effects) {
    std::vector<std::string> names;
    names.reserve(Count);
    for (const KnownEffect& effect : effects)
        names.emplace_back(effect.name);
    return names;
}

Add adder_of(const std::string& name) {
    if (const auto* const found = std::ranges::find(library, name, &KnownEffect::name);
        found != library.end())
        return found->add;
    if (const auto* const found = std::ranges::find(outside, name, &KnownEffect::name);
        found != outside.end())
        return found->add;
    if (const auto* const found = std::ranges::find(further, name, &KnownEffect::name);
        found != further.end())
        return found->add;
    std::vector<std::string> names = library_effects();
    std::ranges::copy(outside_effects(), std::back_inserter(names));
    std::ranges::copy(names_of(further), std::back_inserter(names));
    throw core::InputError(
        fmt::format("no effect \"{}\" for a made-up recording; the nearest is \"{}\"", name,
                    core::nearest_name(name, names)));
}

} // namespace

double HiddenEffect::value(std::string_view parameter) const {
    for (const auto& [given, number] : parameters)
        if (given == parameter)
            return number;
    throw core::InputError(fmt::format("{} needs the parameter {}", name, parameter));
}

std::vector<std::string> library_effects() {
    return names_of(library);
}

std::vector<std::string> further_effects() {
    return names_of(further);
}

std::vector<std::string> outside_effects() {
    return names_of(outside);
}

HiddenPhysics hidden_physics(const BeamStem& stem, const std::vector<HiddenEffect>& effects,
                             const LawErrors& errors) {
    HiddenPhysics physics;
    if (errors.second_frequency_share != 0.0 || errors.second_loss_ratio != 1.0)
        physics.terms.second_mode =
            SecondMode{errors.second_frequency_share, errors.second_loss_ratio};
    for (const HiddenEffect& effect : effects)
        adder_of(effect.name)(effect, {stem, errors, physics});
    return physics;
}

} // namespace culm::beam
