// SPDX-License-Identifier: BSD-3-Clause
// Every number of the decision which model a recording calls for, with its reason.
#pragma once

#include <cstddef>

namespace culm::diagnose {

/// The rules that use these numbers are in adequacy.hpp (is a model adequate?), judge.hpp (is a
/// larger model accepted?), search.cpp (the search) and answer.cpp (what is reported).
struct Policy {
    // --- Is a fitted model adequate? (adequacy.cpp)

    /// Of the tests for lack of fit, together: one recording of noise in a hundred fails.
    double lack_of_fit_level = 0.01;
    /// Below it a model fails clearly. A model that fails at lack_of_fit_level only, and that no
    /// effect improves, counts as adequate: among a hundred recordings one is expected.
    double clear_failure_level = 1e-4;
    /// With less than two cycles the damping and the second mode cannot be told apart.
    double fewest_cycles = 2.0;
    /// Below three times its noise the motion determines neither frequency nor damping.
    double smallest_swing_over_noise = 3.0;
    /// The tests' distributions are asymptotic: good to a few per cent from 30 readings on.
    std::size_t fewest_frames = 30;
    /// Excess of χ² over its mean, in standard deviations √(2n), that readings with motion have.
    double motion_over_noise = 5.0;

    // --- Is a larger model accepted in place of a smaller one? (judge.cpp)

    /// Fall of the information criterion: odds of e⁵ = 150 to 1 (Kass & Raftery 1995: "very
    /// strong").
    double naming_gain = 10.0;
    /// Probability, for all candidates together (Bonferroni), of such a gain by noise.
    double naming_level = 0.01;
    /// Reduced χ² that neither noise nor the imperfections of a chain of spheres make.
    double glaring_misfit = 4.0;
    /// Of a misfit that stays glaring, that each effect of a step has to explain. An answer has at
    /// most three effects, and the largest explains a third unless they cancel. What explains less
    /// bends a wrong model to fit.
    double least_share_of_glaring = 0.2;
    /// An effect without a number to fit (gravity) goes first where it leaves less of χ² than this.
    double certain_share = 0.1;

    // --- Are readings that were held out predicted better? (held_out.cpp)

    /// Length of a block of time, in periods: beyond it residuals are hardly correlated.
    double block_periods = 3.0;
    /// The scatter of the blocks is known from four on; with fewer, the mean square has to fall
    /// clearly.
    std::size_t fewest_blocks = 4;
    double clear_fall = 0.9;
    /// Fall of χ² in readings that neither fit has seen: odds of 150 to 1.
    double held_out_gain = 10.0;
    /// Allowed rise at the height that was left out; both fits have seen its neighbours.
    double allowed_rise = 1.02;

    // --- Which models cannot be told apart? (search.cpp)

    /// Of the criterion: odds of 20 to 1 (Kass & Raftery 1995: "strong"). An effect whose removal
    /// costs less goes.
    double tie_gap = 6.0;
    /// The same for a rival that leaves nothing but noise: a chain is no beam, and a law of the
    /// library is not the stem's, to some χ².
    double clear_gap = 12.0;
    /// Two effects each of which alone explains this share of the misfit are one law, not two.
    double share_of_one_law = 0.99;

    // --- When are effects named although structure is left? (answer.cpp)

    /// Minimum share of the misfit that an effect must explain before it is named when the
    /// residuals are still structured. A force of another form leaves more (docs/diagnosis.md).
    double share_beside_structure = 0.98;
    /// By how many standard deviations, of the noise in the misfit, it has to be more than that.
    double share_certainty = 2.0;
    /// Three effects that together still leave structure have bent to fit.
    std::size_t most_effects_beside_structure = 2;

    // --- How far does the search go? None of these decides between models that were fitted.

    /// Of χ², that the score test promises, from which a fit is worth its runs.
    double promising_gain = 8.0;
    /// Of what an effect gains, that another has to promise to be tried in its place.
    double promised_share = 0.3;
    /// Of the best promise, below which a candidate is not fitted at first. A linear promise may be
    /// far off, but a rival in a tie keeps this much. Fits of spatial chains take six times as
    /// long: they have to promise more unless nothing else is left.
    double least_promised_share = 0.05;
    double least_promised_share_spatial = 0.6;
    /// Of what another model gains, that the score of a spatial candidate has to promise: it is one
    /// linear step from the beats in the readings, and near what a fit brings if there are any.
    double overtaking_share = 0.9;
    /// Of χ², in units of the best model's reduced χ²: where so little decides, a step says too
    /// little.
    double overtaking_slack = 50.0;
    std::size_t pairs_of_best = 3; ///< single effects that are tried in pairs
    int most_exchanges = 3;

    // --- What is reported beside the answer? (answer.cpp)

    /// |cos| of two signatures above which two effects are hard to distinguish.
    double similar_signature = 0.8;
    std::size_t most_pairs_to_separate = 2; ///< for which experiments are sought
};

} // namespace culm::diagnose
