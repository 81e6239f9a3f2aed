// SPDX-License-Identifier: BSD-3-Clause
// Where the fit of a model with effects, or of one model to several recordings, begins.
#pragma once

#include "fit/solve/fit.hpp"
#include "fit/solve/layout.hpp"
#include "integrate/linearised.hpp"
#include "integrate/modes.hpp"

#include <cstddef>
#include <span>
#include <vector>

namespace culm::fit {

/// Frequencies (Hz) at which the residuals of a fit are strongest, at most `count`.
[[nodiscard]] std::vector<double> residual_peaks(const RecordingFit& fit, std::size_t count);

/// The value of a size at which its effect is absent, within the bounds.
[[nodiscard]] double absent_value(const FreeParameter& parameter);

/// The scales of a stem in a recording of this duration (s), without peaks of residuals.
[[nodiscard]] physics::StartScales stem_start_scales(const physics::StemParameters<double>& stem,
                                                     double duration);

/// Changes Y and β until the first mode of `start` has the frequency and decay of `wanted`.
void keep_first_mode(const integrate::VibrationMode& wanted, StemModel& start);

enum class StartSize {
    Absent, ///< the fit of the smaller model is the start; its derivatives vanish for
            ///< effects whose first order vanishes
    Default
};

/// Starts for a fit of `model`, which contains the model of `smaller`. Common parameters start from
/// their values in `smaller`. Places, angles and time scales of the others start from several
/// values each, sizes as `size` states. In every start Y and β are changed so that the first
/// mode keeps its frequency and decay: an effect on the frequency would otherwise start cycles
/// away. A stem that leaves the plane starts from the beats in the readings (recorded_beats()), if
/// there are any.
[[nodiscard]] std::vector<StemModel> fit_starts(const StemModel& model, const RecordingFit& smaller,
                                                StartSize size);

/// Must the fit of `model` start with nonzero sizes, because no derivative leads away from the
/// start with its effects absent?
[[nodiscard]] bool has_own_sizes(const StemModel& model, const RecordingFit& smaller);

/// Starts with the effects absent. If there are no places to choose from, also one with the default
/// sizes.
[[nodiscard]] std::vector<StemModel> candidate_starts(const StemModel& model,
                                                      const RecordingFit& smaller);

/// A e^{−δt} (cos²α cos ω₁t + sin²α cos ω₂t), ω₁,₂ = ω √(1 ± ε/2): what is seen from one side of a
/// stem with two planes of bending.
struct Beat {
    double angular_frequency = 0.0; ///< ω, 1/s
    double decay_rate = 0.0;        ///< δ, 1/s
    double split = 0.0;             ///< ε
    double angle = 0.0;             ///< α, rad, between 0 and π/2
    double amplitude = 0.0;         ///< A over that of the fitted chain at the release
};

/// The beats that explain the readings of `fit` best, the best first, at most `count`; none unless
/// the best explains a tenth of the fitted chain's residual swing. Frequency and decay are searched
/// about those of `fit`, whose first mode has `angular_frequency` and `decay_rate`.
[[nodiscard]] std::vector<Beat> recorded_beats(const RecordingFit& fit, double angular_frequency,
                                               double decay_rate, std::size_t count);

/// The swing of a recording from a fit of Eq. 1, independent of a model.
struct RecordedSwing {
    integrate::VibrationMode mode{}; ///< damped
    double cycles = 0.0;             ///< until its end
    double tip_deflection = 0.0;     ///< of its baseline model's start, m
};

[[nodiscard]] RecordedSwing recorded_swing(const measure::Measurement& measurement,
                                           const FitOptions& options);

/// Models at the point where the posteriors of the recordings' own fits, `alone`, meet. If their
/// first modes differ from the recorded swings by different shares, or a fit has no covariance,
/// models with the shared values of each recording are added.
[[nodiscard]] std::vector<StartModels> shared_starts(const StartModels& models,
                                                     std::span<const RecordingFit> alone,
                                                     std::span<const RecordedSwing> swings,
                                                     const JointLayout& layout);

/// If one material does not give all recordings their frequencies, a size that `smaller` does not
/// have may do so: a mass for each recording with the modulus of the stiffest one, or a compliance
/// that makes their moduli equal. Returns such starts, made from `models` by the linearised chain;
/// none if the recordings agree already, or no new size reconciles them.
[[nodiscard]] std::vector<StartModels> reconciling_starts(const StartModels& models,
                                                          std::span<const RecordingFit> smaller,
                                                          std::span<const RecordedSwing> swings);

} // namespace culm::fit
