// SPDX-License-Identifier: BSD-3-Clause
// What an effect would gain, and how large it must be to be seen, from a run or a few.
#pragma once

#include "fit/fit_model.hpp"

#include <span>
#include <string>
#include <vector>

namespace culm::diagnose {

struct EffectScore {
    std::string effect;
    std::string failure; ///< why there is no score; empty if there is
    /// Fall of χ² that the model with the effect promises, linearised about the fit without it;
    /// one-sided where the effect cannot be negative.
    double gain = 0.0;
    int added = 0; ///< numbers that a fit with the effect has more

    std::string
        parameter; ///< the one that gives the effect its size; empty for a user's law of none
    std::string unit;
    double smallest_visible = 0.0; ///< its value at which the effect stands out by 3 σ
    bool is_beyond_bounds = false; ///< no possible size of the effect could be seen
    /// Relative change of Y and β by which the fit would hide an effect of that size.
    double youngs_modulus_bias = 0.0;
    double damping_bias = 0.0;
    /// (readings) of unit length: what of a small effect nothing else in the model can imitate.
    std::vector<double> direction;

    std::vector<double> null_gains; ///< (draws): what the effect gains where only noise is left
};

/// Runs the model with the effect absent (where its place or time scale is not known: at several),
/// and projects off what the model's own parameters can do [Rao's score test]. Effects whose first
/// order vanishes are judged by a finite size. `draws` of noise with the correlation from frame to
/// frame that the residuals of `base` have; the same draws for every effect.
[[nodiscard]] EffectScore score_effect(const fit::Fit& base, const physics::SelectedEffect& effect,
                                       std::span<const fit::ObservedRecording> recordings,
                                       const fit::FitOptions& options, int draws = 0);

template <class Wire>
void fields(Wire& wire, EffectScore& score) {
    wire(score.effect, score.failure, score.gain, score.added, score.parameter, score.unit,
         score.smallest_visible, score.is_beyond_bounds, score.youngs_modulus_bias,
         score.damping_bias, score.direction, score.null_gains);
}

} // namespace culm::diagnose
