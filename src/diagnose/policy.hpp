// SPDX-License-Identifier: BSD-3-Clause
// Thresholds of the decision which model a recording requires, with their reasons.
#pragma once

namespace culm::diagnose {

/// Which effects act, and does a fitted model explain its recording?
struct Policy {
    /// Prior probability that an effect of the library acts.
    double effect_probability = 0.05;
    /// Margin below the best log evidence beyond which a model is not fitted: odds of 150 to 1.
    double unvisited_margin = 5.0;
    /// Reduced χ² of a model above which its residual is far from noise.
    double rough_misfit = 4.0;
    /// Probability that an answer must have.
    double held_probability = 0.95;
    /// Share of the noise that a user can ignore.
    double immaterial_noise = 0.2;
    /// Share of the larger effects' explanation: the accuracy of the library's laws.
    double immaterial_share = 0.05;
    /// Largest unexplained share of the misfit of a model that fails the tests.
    double unexplained_share = 0.02;
    /// Level of all tests for lack of fit together: one recording of noise in 1000 fails.
    double lack_of_fit_level = 1e-3;
};

} // namespace culm::diagnose
