// SPDX-License-Identifier: BSD-3-Clause
// A loss per cycle that does not depend on the frequency.
#include "physics/effects/effect.hpp"
#include "physics/effects/stem_scales.hpp"

#include <cmath>
#include <numbers>

#include <Eigen/Dense>

namespace culm::physics {

namespace {

/// Frequencies, Hz (or over the first natural frequency).
struct FrequencyBand {
    double lowest = 0.0;
    double highest = 0.0;
};

/// Band of constant hysteretic damping, relative to the first natural frequency: modes 1 to 3 of a
/// cantilever lie at 1, 6.27 and 17.5, and a mass at the tip lowers them.
constexpr FrequencyBand hysteretic_band{1.0 / 3.0, 40.0};

constexpr int branch_count = 6;
constexpr int frequencies_a_branch = 8;
/// Factor by which the branches extend beyond the band at both ends. With 2 the loss factor stays
/// within 0.8 % of its value from half the first frequency to 20 times it, and no branch becomes
/// negative up to a loss factor of 0.5. Without it the outer branches must replace those beyond.
constexpr double reach = 2.0;

double angular(double frequency) {
    return 2.0 * std::numbers::pi * frequency;
}

/// `count` numbers from `first` to `last`, even in the logarithm.
double evenly_spaced(double first, double last, int count, int k) {
    return first * std::pow(last / first, static_cast<double>(k) / static_cast<double>(count - 1));
}

/// Six branches with relaxation times spread evenly over the logarithm of the band's periods. The
/// condition E'' = η E' at frequencies of the band is linear in their stiffnesses, which are its
/// least-squares solution (Emmerich & Korn 1987). They carry no load while the stem is held.
/// `loss_factor` from 0 to 0.5.
std::vector<MaxwellBranch<double>> constant_loss_branches(double loss_factor,
                                                          const FrequencyBand& band) {
    std::vector<MaxwellBranch<double>> branches;
    branches.reserve(branch_count);
    for (int b = 0; b < branch_count; ++b)
        branches.push_back(
            {.relative_stiffness = 0.0,
             .relaxation_time = 1.0 / angular(evenly_spaced(band.lowest / reach,
                                                            reach * band.highest, branch_count, b)),
             .held_share = 0.0});
    constexpr int rows = branch_count * frequencies_a_branch;
    Eigen::Matrix<double, rows, branch_count> lost;
    for (int k = 0; k < rows; ++k) {
        const double omega = angular(evenly_spaced(band.lowest, band.highest, rows, k));
        for (int b = 0; b < branch_count; ++b) {
            // Stiffness over the spring's, in phase with the strain and a quarter cycle ahead.
            const double x = omega * branches[static_cast<std::size_t>(b)].relaxation_time;
            const double storage = x * x / (1.0 + x * x);
            const double loss = x / (1.0 + x * x);
            lost(k, b) = loss - loss_factor * storage;
        }
    }
    const Eigen::Vector<double, branch_count> stiffness =
        lost.colPivHouseholderQr().solve(Eigen::Vector<double, rows>::Constant(loss_factor));
    for (int b = 0; b < branch_count; ++b)
        branches[static_cast<std::size_t>(b)].relative_stiffness = stiffness[b];
    return branches;
}

} // namespace

EffectPointer hysteretic_damping() {
    return make_effect(
        {.name = "hysteretic_damping",
         .family = Family::MaterialDamping,
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
         .parameters = {size_parameter(
             "loss_factor", "", "η: twice the damping ratio",
             {.default_value = 0.02, .lower = 0.0, .upper = 0.5, .scale = 0.01})}},
        [](std::span<const double> values, EffectTarget& target) {
            const double first = first_frequency(target.stem);
            for (const MaxwellBranch<double>& branch : constant_loss_branches(
                     values[0], {first * hysteretic_band.lowest, first * hysteretic_band.highest}))
                target.model.branches.push_back(branch);
        });
}

} // namespace culm::physics
