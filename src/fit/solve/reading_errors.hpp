// SPDX-License-Identifier: BSD-3-Clause
// Errors of the readings in addition to their noise (the stated inputs, the division of the chain,
// the release): terms of every fit, each with a constraint.
#pragma once

#include "fit/solve/fit.hpp"

#include <span>
#include <string>
#include <vector>

namespace culm::fit {

/// The object that a stated input changes.
enum class InputActs {
    OnChain,   ///< the chain or what is on it, by StatedInput::access
    OnRows,    ///< the heights of all rows alike
    OnPicture, ///< heights and deflections by the same share
    OnSensor,  ///< the readings of one sensor by a share
    OnClock
};

/// A measured quantity that the model takes as a number. SI units.
struct StatedInput {
    InputActs acts = InputActs::OnChain;
    run::CaseParameter access; ///< the number in the fitted case, of one that acts on the chain
    std::string name;          ///< "length", "mass at 156 mm"
    std::string unit;          ///< "m"; empty: a share
    double value = 0.0;
    double standard_uncertainty = 0.0; ///< one standard deviation (JCGM 100)
    bool is_default = false;           ///< the file states none
    bool is_of_rig = false;            ///< recordings on one rig share it; else those of a specimen
    std::size_t row = 0;               ///< of one that acts on a sensor
};

/// Length, section, density, added masses, scale and clamp height of the picture, frame rate. The
/// defaults of the uncertainties are: length 0.3 mm, clamp height 0.2 mm, scale 0.5 %, every other
/// quantity 1 % (docs/uncertainty.md); a frame rate is exact. Inputs of uncertainty 0 are omitted.
[[nodiscard]] std::vector<StatedInput> stated_inputs(const measure::Measurement& measurement);

/// A shift of all rows of a measurement's case, m; 0 is the stated position.
[[nodiscard]] run::CaseParameter height_of_rows(const measure::Measurement& measurement);

/// The recording with the noise of its readings while the stem moves. The noise is estimated from
/// the residuals without the parts at the modes and in a drift, at the Fourier frequencies that
/// these do not affect: Student's t of outliers, which are then down-weighted (Lange et al. 1989),
/// the correlation in time by Whittle's likelihood, and that of the rows. Each is used if noise
/// without it shows as much in one recording of a thousand. A recording with less than 64 frames or
/// 20 such frequencies is returned unchanged.
[[nodiscard]] ObservedRecording with_noise_in_motion(const RecordingFit& fit,
                                                     const ObservedRecording& measurement);

/// Do two estimates for one recording agree on its noise in motion, with its size to 1 %?
[[nodiscard]] bool has_same_noise(const ObservedRecording& one, const ObservedRecording& other);

/// The recordings with their noise in motion and the error terms of their readings, linearised
/// about `fits` (without terms), one for each. The first terms are the stated inputs, in their
/// order: a term is the change of the readings by one standard uncertainty. Y and β take the part
/// that they can absorb, so that phases stay in the linear range. Recordings of one rig, or of one
/// specimen with the same stated value, share a term.
///
/// The next term, if it matters, is the division of the chain: y = y_N + α (y_2N − y_N) with
/// α = 4/3 ± 1/3, order 2 in the bond length and its uncertainty. The finer chain has the first
/// mode of the first recording, whose Y refers to the chain that was asked for. It is not run if
/// the second frequency changes by less than 0.3 standard deviations, σ_f = √(6/n) σ/(π A T)
/// (Montgomery & O'Donoghue 1999).
///
/// The next terms are the release by hand (release_errors()), position errors of rows, the
/// constant error and the drift of sensors, and the second mode (second_mode_errors.hpp).
///
/// Each group costs one run per recording. If recordings have terms already, the noise and the
/// division are kept, and the other terms are linearised again. A recording without motion, or one
/// that cannot be computed with an input changed a little, has no terms.
[[nodiscard]] std::vector<ObservedRecording>
with_reading_errors(std::span<const ObservedRecording> recordings,
                    std::span<const RecordingFit> fits, const run::Heartbeat& heartbeat = {});

/// The terms of the release in addition to `others`. Empty unless an exact release shows departures
/// as large as those in the first two periods in at most one case of a thousand.
[[nodiscard]] std::vector<ReadingErrors::Term>
release_errors(const RecordingFit& fit, const measure::Measurement& measurement,
               const std::vector<ReadingErrors::Term>& others);

/// The recordings without error terms: every input is as stated. The known effect of the division
/// of the chain and the terms of every model remain.
[[nodiscard]] std::vector<ObservedRecording>
with_inputs_as_stated(std::span<const ObservedRecording> recordings);

/// The model for a recording with error terms: those that it has keep their values, the others are
/// at their stated ones.
[[nodiscard]] StemModel beside_errors(StemModel model, const ObservedRecording& measurement);

/// The published chain of the recording with these effects, from beside_errors().
[[nodiscard]] StemModel observed_model(const SelectedEffects& effects,
                                       const ObservedRecording& recording,
                                       const ChainOptions& options = {});

} // namespace culm::fit
