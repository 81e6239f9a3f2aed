// SPDX-License-Identifier: BSD-3-Clause
// Every number of the decision which model a recording calls for, with its reason.
#pragma once

#include <cstddef>

namespace culm::diagnose {

/// The rules that use these numbers are in adequacy.hpp (is a model adequate?), judge.hpp (is a
/// larger model accepted by compare?) and posterior.hpp (which effects act?).
struct Policy {
    // --- The posterior (model_search.hpp, posterior.hpp, diagnosis.cpp)

    /// Prior probability of each effect of the library to act.
    double effect_probability = 0.05;
    /// T: log evidences are divided by it, because no law, noise and input of a model is exact.
    double temperature = 2.0;
    /// Log evidence below the best from which a prediction is not worth a fit: odds of 150 to 1.
    double unvisited_margin = 5.0;
    /// Reduced χ² above which only single additions are predicted: the linearisation is rough.
    double rough_misfit = 4.0;
    /// Probability that an answer has to hold.
    double held_probability = 0.95;
    /// Of the noise: what a user can ignore.
    double immaterial_noise = 0.2;
    /// Of what the larger effects explain: the accuracy of the library's laws.
    double immaterial_share = 0.05;
    /// Of the misfit, that a model may leave which fails the tests.
    double unexplained_share = 0.02;

    // --- Is a fitted model adequate? (adequacy.cpp)

    /// Of the tests for lack of fit, together: one recording of noise in a thousand fails.
    double lack_of_fit_level = 1e-3;
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
};

} // namespace culm::diagnose
