// SPDX-License-Identifier: BSD-3-Clause
// Errors of the readings in addition to their noise (the stated inputs, the division of the chain,
// the release): terms of every fit, each with a constraint.
#pragma once

#include "fit/solve/fit.hpp"

#include <span>
#include <string>
#include <vector>

namespace culm::fit {

/// On what a stated input acts.
enum class InputActs {
    OnChain,   ///< the chain or what is on it, by StatedInput::access
    OnRows,    ///< the heights of all rows alike
    OnPicture, ///< heights and deflections by the same share
    OnClock
};

/// A quantity that enters the model as a number, although it was measured. SI units.
struct StatedInput {
    InputActs acts = InputActs::OnChain;
    run::CaseParameter access; ///< the number in the fitted case, of one that acts on the chain
    std::string name;          ///< "length", "mass at 156 mm"
    std::string unit;          ///< "m"; empty: a share
    double value = 0.0;
    double standard_uncertainty = 0.0; ///< one standard deviation (JCGM 100)
    bool is_default = false;           ///< the file states none
    bool is_of_rig = false;            ///< recordings on one rig share it; else those of a specimen
};

/// Length, section, density, added masses, scale and clamp height of the picture, frame rate. Where
/// the file states no uncertainty that of a careful laboratory counts: length 0.3 mm, clamp height
/// 0.2 mm, scale 0.5 %, every other quantity 1 % (docs/uncertainty.md); a frame rate is exact.
/// Inputs of uncertainty 0 are left out.
[[nodiscard]] std::vector<StatedInput> stated_inputs(const measure::Measurement& measurement);

/// A shift of all rows of a measurement's case, m; 0 is what was stated.
[[nodiscard]] run::CaseParameter height_of_rows(const measure::Measurement& measurement);

/// The recording with the noise that its readings have while the stem moves, estimated from the
/// residuals without what lies at the modes and a drift, at the Fourier frequencies that these
/// leave free: Student's t of outliers, which then weigh less (Lange et al. 1989), the correlation
/// in time by Whittle's likelihood, and that of the rows. Each counts if noise without it shows as
/// much in one recording of a thousand. Below 64 frames or 20 such frequencies the recording stays
/// as it is.
[[nodiscard]] ObservedRecording with_noise_in_motion(const RecordingFit& fit,
                                                     const ObservedRecording& measurement);

/// Is the noise in motion of two estimates for one recording the same, its size to 1 %?
[[nodiscard]] bool has_same_noise(const ObservedRecording& one, const ObservedRecording& other);

/// The recordings with their noise in motion and the error terms of their readings, linearised
/// about `fits` (without terms), one for each. The first terms are the stated inputs, in their
/// order: a term is the change of the readings by one standard uncertainty. The part that Y and β
/// can absorb goes into these, so that no phase runs away from the linear rest. Recordings of one
/// rig, or of one specimen with the same stated value, share a term.
///
/// The next term, where it matters, is the division of the chain: y = y_N + α (y_2N − y_N) with
/// α = 4/3 ± 1/3, order 2 in the bond length and its uncertainty. The finer chain keeps the first
/// mode of the first recording, whose Y is that of the chain that was asked for. It is not run
/// below 0.3 standard deviations of the second frequency, σ_f = √(6/n) σ/(π A T) (Montgomery &
/// O'Donoghue 1999).
///
/// Then the release by hand (release_errors()), and position errors of rows of a picture.
///
/// Each costs one run per recording. If recordings have terms already, the noise and the
/// division are kept, and the rest is linearised anew. A recording without motion, or that cannot
/// be computed with an input changed a little, has no terms.
[[nodiscard]] std::vector<ObservedRecording>
with_reading_errors(std::span<const ObservedRecording> recordings,
                    std::span<const RecordingFit> fits, const run::Heartbeat& heartbeat = {});

/// The terms of the release in addition to `others`; none unless the departures in the first two
/// periods together are as large in one release of a thousand that has none.
[[nodiscard]] std::vector<ReadingErrors::Term>
release_errors(const RecordingFit& fit, const measure::Measurement& measurement,
               const std::vector<ReadingErrors::Term>& others);

/// The recordings without error terms: every input is as stated. What is known of the division of
/// the chain remains.
[[nodiscard]] std::vector<ObservedRecording>
with_inputs_as_stated(std::span<const ObservedRecording> recordings);

/// The model as one of the recording with its errors, each at its stated value.
[[nodiscard]] StemModel beside_errors(StemModel model, const ObservedRecording& measurement);

/// The published chain of the recording with these effects, beside_errors().
[[nodiscard]] StemModel observed_model(const SelectedEffects& effects,
                                       const ObservedRecording& recording,
                                       const ChainOptions& options = {});

} // namespace culm::fit
