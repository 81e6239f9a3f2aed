// SPDX-License-Identifier: BSD-3-Clause
// Every number of the decision which model a recording calls for, with its reason.
#pragma once

#include <cstddef>

namespace culm::diagnose {

/// Used by model_search.hpp, posterior.hpp, diagnosis.hpp, ladder.hpp (which effects act?) and
/// adequacy.hpp (does a fitted model explain its recording?).
struct Policy {
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
    /// Of the tests for lack of fit, together: one recording of noise in a thousand fails.
    double lack_of_fit_level = 1e-3;
};

} // namespace culm::diagnose
