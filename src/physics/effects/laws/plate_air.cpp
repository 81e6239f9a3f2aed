// SPDX-License-Identifier: BSD-3-Clause
// The air at the sharp edges of a plate: drag and added mass that depend on the amplitude.
#include "core/error.hpp"
#include "physics/effects/air.hpp"
#include "physics/effects/stem_scales.hpp"

#include <cmath>
#include <numbers>

namespace culm::physics {

namespace {

using std::numbers::pi;

/// KC below which the added mass does not fall further, so that its slope is finite at rest.
constexpr double smallest_number = 0.01;

/// ∮ |cos θ|^(8/3) dθ.
double mean_of_cosine() {
    return 2.0 * std::sqrt(pi) * std::tgamma(11.0 / 6.0) / std::tgamma(7.0 / 3.0);
}

/// Both laws are stated for a steady amplitude A = V/ω. In terms of the speed, the force of the
/// same loss in a cycle is K |v|^(2/3) v,
///     K V^(8/3) ∮|cos|^(8/3) = ½ρ W C_d V³ 8/3,
/// and the mass of the same mean momentum over a cycle grows as |v|^(2/3):
///     3/5 g V^(2/3) ∮|cos|^(8/3)/π = ¼πρW² k KC^(2/3).
void apply_plate_air(std::span<const double> values, EffectTarget& target) {
    if (!target.stem.rectangle_depth)
        throw core::InputError("plate_air describes the edges of a rectangular section, and this "
                               "stem has another one; quadratic_drag and still_air are for it");
    const double width = target.stem.width_in_air();
    const double number = 2.0 * pi / (loaded_angular_frequency(target) * width); // KC at 1 m/s
    target.model.air.push_back({.law = &resistance_law<PowerLaw>,
                                .coefficient = 0.5 * air_density * width * values[0] *
                                               std::pow(number, -1.0 / 3.0) * (8.0 / 3.0) /
                                               mean_of_cosine(),
                                .shape = {5.0 / 3.0}});
    AirMass<double>& air = moving_air(target);
    air.growing += 5.0 / 3.0 * 0.25 * pi * air_density * width * width * values[1] *
                   std::pow(number, 2.0 / 3.0) * pi / mean_of_cosine();
    air.smallest_speed = smallest_number / number;
}

/// A literature value, known to 30 %.
EffectParameter amplitude(const char* name, const char* meaning, double value) {
    EffectParameter parameter = size_parameter(
        name, "", meaning,
        {.default_value = value, .lower = 0.0, .upper = 10.0 * value, .scale = value});
    parameter.known_within = 0.3 * value;
    return parameter;
}

} // namespace

EffectPointer plate_air() {
    return make_effect(
        {.name = "plate_air",
         .family = Family::Air,
         .summary = "the air at the edges of a plate: drag and added mass of the amplitude",
         .law = "a swing of the amplitude A has the drag coefficient C_d = D KC^(-1/3) and the "
                "added mass ¼πρW² k KC^(2/3) per length, KC = 2πA/W, with the width W of a "
                "rectangular section across the motion and ρ = 1.2 kg/m³. In the chain both "
                "depend on the speed, with the frequency of mode 1: force per length -K |v|^(2/3) "
                "v, mass per length g |v|^(2/3) sideways",
         .source = "drag: Graham (1980), J. Fluid Mech. 97:331-346; added mass: Keulegan & "
                   "Carpenter (1958), J. Res. NBS 60:423-440, with k of Luhar & Nepf (2016), J. "
                   "Fluids Struct. 61:20-41",
         .signature = "damping ratio and frequency follow the same power A^(2/3): the decay is "
                      "faster and the frequency lower at large amplitude",
         .remedy = "release from amplitudes 10:1 apart, or in vacuum; a narrower strip of the same "
                   "thickness has less of both",
         .energy = "takes out K |v|^(8/3) per length and second and stores g (3/8) |v|^(8/3)",
         .parameters = {amplitude("drag_amplitude", "D: drag coefficient at KC = 1", 8.0),
                        amplitude("mass_amplitude",
                                  "k: added mass at KC = 1 over ¼πρW², beyond that of "
                                  "small swings, which still_air adds",
                                  0.35)},
         .excludes = {"quadratic_drag", "power_drag"},
         .belongs_to = BelongsTo::Rig,
         .revealed_by = {{"release in a vacuum", {0.0, 0.0}}},
         .needs_edges = true},
        apply_plate_air);
}

} // namespace culm::physics
