// SPDX-License-Identifier: BSD-3-Clause
// The force that is missing when no known effect explains a recording.
#pragma once

#include "fit/fit_numbers.hpp"

#include <span>
#include <string>
#include <vector>

namespace culm::diagnose {

struct ForceTerm {
    std::string term;         ///< as an expression of x, v, kappa, kappa_rate: "v*abs(v)"
    double coefficient = 0.0; ///< N/m (N m for a moment) per unit of the term
    double standard_error = 0.0;
    double probability = 0.0; ///< that it is one of the terms, among the sets that were tried
};

struct ForceSample {
    double displacement = 0.0; ///< m
    double velocity = 0.0;     ///< m/s
    double force = 0.0;        ///< N/m
};

struct MissingForce {
    std::string kind; ///< "force_per_length" or "bending_moment"
    std::string form; ///< the expression with its numbers; empty: nothing stable was found
    std::vector<ForceTerm> terms;
    double explained = 0.0; ///< share of the misfit above the noise that it removes
    std::string character;  ///< "dissipative, grows faster than the speed, …"
    std::vector<ForceSample> against_displacement; ///< at the tip, at rest
    std::vector<ForceSample> against_velocity;     ///< at the tip, undeflected
    std::string as_effect_file;                    ///< TOML of a user's effect with these terms
    fit::Fit fit;                                  ///< of the model with this force
};

/// Explains the residual of `base` by sums of at most three simple forces, as a search explains it
/// by effects: each term's signature is computed through the chain, without the part that the
/// model's own parameters can imitate, and the likeliest set is taken. A term needs a probability
/// of 80 %. The terms are then fitted through the chain as a user's effect.
[[nodiscard]] MissingForce
reconstruct_missing_force(const fit::Fit& base, const fit::SelectedEffects& effects,
                          std::span<const fit::ObservedRecording> recordings,
                          const fit::FitOptions& options = {});

} // namespace culm::diagnose
