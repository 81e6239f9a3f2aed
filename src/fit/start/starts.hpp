// SPDX-License-Identifier: BSD-3-Clause
// Where the fit of a model with effects begins.
#pragma once

#include "fit/fit.hpp"

#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace culm::fit {

/// Frequencies (Hz) at which the residuals of a fit are strongest, at most `count`, not within
/// physics::near_resonance of the chain's modes.
[[nodiscard]] std::vector<double> residual_peaks(const RecordingFit& fit, std::size_t count);

/// The scales of a stem in a recording of this duration (s), without peaks of residuals.
[[nodiscard]] physics::StartScales stem_start_scales(const physics::StemParameters<double>& stem,
                                                     double duration);

enum class StartSize {
    Absent, ///< the fit of the smaller model is the start; its derivatives vanish for
            ///< effects whose first order vanishes
    Default
};

/// Starts for a fit of `model`: that of `smaller` with more effects. Places, angles and time scales
/// of the others start from several values each, sizes as `size` states. In every start Y and β are
/// changed so that the first mode keeps its frequency and decay: an effect on the frequency would
/// otherwise start cycles away. A stem that leaves the plane starts from the beats in the readings
/// (recorded_beats()), if there are any.
[[nodiscard]] std::vector<StemModel> fit_starts(const StemModel& model, const RecordingFit& smaller,
                                                StartSize size);

/// Starts for recordings of one stem whose first modes differ by more than one material allows: the
/// chain is cycles away from most of them, and no derivative leads back. In each start the effect,
/// which belongs to recordings, is absent from one of them and gives each other one the first mode
/// of its readings, with one Y for all. `models`: with the effect. Empty: no size does it.
[[nodiscard]] std::vector<StartModels>
starts_by_frequency(StartModels models, const std::string& effect,
                    std::span<const ObservedRecording> recordings);

/// Must the fit of `model` start with nonzero sizes, because no derivative leads away from the
/// start with its effects absent?
[[nodiscard]] bool has_own_sizes(const StemModel& model, const RecordingFit& smaller);

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

/// The smallest of 14, 20 and 28 spheres whose remaining error is below a fifth of the noise (rms
/// over the readings) in every recording; the number that the options state if that is smaller, if
/// none suffices, or if a recording states no noise.
///
/// The error of a chain of bonds of length a is of order a². A fit adds α (y₂ − y₁), the difference
/// to the chain of bonds half as long with the same first mode, with α = 4/3 ± 1/3
/// (errors/terms.hpp); what remains is about (y₂ − y₁)/3 without the part that Y, β, the pull and
/// the release imitate. One pair of runs shows it.
[[nodiscard]] int coarsest_chain(std::span<const measure::Measurement> recordings,
                                 const FitOptions& options);

} // namespace culm::fit
