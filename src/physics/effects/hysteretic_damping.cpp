// SPDX-License-Identifier: BSD-3-Clause
// A loss per cycle that does not depend on the frequency.
#include "physics/effects/effect_card.hpp"
#include "physics/effects/factories.hpp"
#include "physics/effects/loss_spectrum.hpp"
#include "physics/effects/stem_scales.hpp"

namespace culm::physics {

namespace {

void apply(std::span<const double> values, EffectTarget& target) {
    const double first = first_frequency(target.stem);
    for (const MaxwellBranch<double>& branch : constant_loss_branches(
             values[0], {first * hysteretic_band.lowest, first * hysteretic_band.highest}))
        target.model.branches.push_back(branch);
}

} // namespace

EffectPointer hysteretic_damping() {
    return make_effect(
        {.name = "hysteretic_damping",
         .summary = "inner friction whose loss per cycle is the same at every frequency",
         .law = "E''/E' = η from a third of the first natural frequency to 40 times it, by six "
                "Maxwell branches; Y is the static modulus, and E' rises with frequency by (2η/π) "
                "ln(f/f_low), which causality demands",
         .source =
             "Kimball & Lovell (1927), Phys. Rev. 30:948; branches after Liu, Anderson & "
             "Kanamori (1976), Geophys. J. R. Astr. Soc. 47:41-58, and Emmerich & Korn (1987), "
             "Geophysics 52:1252-1264 (least squares)",
         .signature =
             "every mode has the same damping ratio η/2, while a bond's damping grows with "
             "the frequency and the air's falls; with one mode in sight they are one",
         .remedy = "needs at least three frequencies: add a known mass at the tip, change the "
                   "length, and compare; the second mode right after the release helps",
         .energy =
             "each branch k stores q²/(2 g_k E I) per length and takes out q²/(g_k E I τ_k) per "
             "second; together π η E I κ² per length in a cycle of amplitude κ. Gives nothing back",
         .parameters = {{.name = "loss_factor",
                         .unit = "",
                         .meaning = "η: twice the damping ratio",
                         .default_value = 0.02,
                         .lower = 0.0,
                         .upper = 0.5,
                         .scale = 0.01}}},
        apply);
}

} // namespace culm::physics
