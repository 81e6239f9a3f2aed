// SPDX-License-Identifier: BSD-3-Clause
// The one policy by which a model is fitted: where a fit starts, when it starts again, when it
// fails.
#pragma once

#include "fit/start/joint_starts.hpp"

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace culm::fit {

/// A larger model may leave this much more than the one that it contains: the runs have noise.
inline constexpr double allowed_excess = 1.001;

/// `effects` beside the published chain (none: the chain itself), fitted to all recordings at once.
/// `smaller`: a fit with some or none of the effects; only the chain itself needs none.
///
/// 1. The chain itself, and a model that sets a stem in motion which stood still without its
/// effects:
///    from each recording's own fit, with windows that grow so that no cycle is skipped. What
///    several recordings share starts from the mean of their own values and, where these would put
///    the recordings out of phase, from each of them.
/// 2. A larger model: from starts() about `smaller`, and for several recordings that disagree from
///    reconciling_starts(). Some iterations from each start; the best goes on to its end, and the
///    next one if it was better then.
/// 3. A fit that has not converged goes on once. One whose steps met a bound starts again from
/// there.
/// 4. A larger model that contains the smaller one and fits worse has skipped a cycle: windows grow
///    from the same starts. If that does not help the fit has failed.
/// 5. A model in which nothing moves the stem leaves the readings as they are
/// (FitStatus::Motionless).
///
/// Never throws for a model that cannot be fitted or combined: FitStatus::Failed with the reason.
/// run::Abandoned if the heartbeat says so.
[[nodiscard]] Fit fit_model(const SelectedEffects& effects, const Fit& smaller,
                            std::span<const ObservedRecording> recordings,
                            const FitOptions& options = {});

/// A model fitted twice: with every input as stated, and together with the error terms of the
/// readings.
struct ModelFit {
    Fit stated; ///< printed and drawn; intervals include the uncertainty of the inputs
    Fit judged; ///< tested and compared; the stated one where the inputs wander without an end
};

/// Of `stated`, a fit to with_inputs_as_stated(): linearises the error terms about it, fits the
/// model together with them, and adds their contribution to the intervals of `stated`.
[[nodiscard]] ModelFit judged_model(Fit stated, std::span<const ObservedRecording> recordings,
                                    const FitOptions& options = {});

/// `judged`, a fit with the error terms of `recordings`, fitted again with every input as stated;
/// intervals as judged_model()'s. `smaller` is the published chain, as stated.
[[nodiscard]] Fit as_stated(const Fit& judged, const Fit& smaller,
                            std::span<const ObservedRecording> recordings,
                            const FitOptions& options = {});

/// The published chain, and the recordings with their noise in motion and their error terms: every
/// other model is fitted to these.
struct BaselineFit {
    std::vector<ObservedRecording> recordings;
    Fit fit;                           ///< ModelFit::judged
    Fit stated;                        ///< ModelFit::stated
    std::vector<RecordingFit> alone{}; ///< (recordings) without errors; empty: nothing moves
};
/// with_reading_errors() about each recording's own fit of the chain, and the fits of all from
/// there. Where nothing moves in the chain the recordings have no errors. As fit_model().
[[nodiscard]] BaselineFit fit_baseline(std::span<const measure::Measurement> measurements,
                                       const FitOptions& options = {});

/// The baseline of `measurements` with the noise in motion about `larger`, a model that explains
/// more than the chain. None if the noise is the same about either.
[[nodiscard]] std::optional<BaselineFit>
baseline_beside_noise_of(const Fit& larger, const BaselineFit& baseline,
                         std::span<const measure::Measurement> measurements,
                         const FitOptions& options = {});

/// The models of `effect_sets`, each of which contains the one before it, by fit_with_parts() with
/// every input as stated and then by judged_model(). The published chain is the first. If the noise
/// in motion is another about the last model, all are fitted with that noise. Throws as
/// baseline_model() and candidate_model() for a model that cannot be, before it runs a chain.
struct NestedFits {
    std::vector<ObservedRecording> recordings; ///< BaselineFit::recordings
    std::vector<ModelFit> models;
};
[[nodiscard]] NestedFits fit_nested(std::span<const measure::Measurement> measurements,
                                    const std::vector<SelectedEffects>& effect_sets,
                                    const FitOptions& options = {});

/// fit_model() for a model that may add several effects at once: it cannot fit worse than a part of
/// it, a model with one of these effects less. Where the fit fails, or one of the effects stands at
/// a bound or is no different from absent, the parts are fitted too. If one fits better, the fit
/// starts again from that solution; what then is still worse has failed.
[[nodiscard]] Fit fit_with_parts(const SelectedEffects& effects, const Fit& smaller,
                                 std::span<const ObservedRecording> recordings,
                                 const FitOptions& options = {});

/// fit_model() from given models, which lie near the end: all the way from there.
[[nodiscard]] Fit refined(const StartModels& start, const SelectedEffects& effects,
                          const Fit& smaller, std::span<const ObservedRecording> recordings,
                          const FitOptions& options);

/// fit_model() of one model, and its fits from other solutions.
class FitPlan {
  public:
    /// `smaller` and the recordings must outlive this.
    FitPlan(const SelectedEffects& effects, const Fit& smaller,
            std::span<const ObservedRecording> recordings, const FitOptions& options);

    /// As fit_model().
    [[nodiscard]] Fit fit(const FitOptions& options) const;

    /// One recording with the errors of its readings from its fit without them.
    [[nodiscard]] Fit fit_beside_errors(const RecordingFit& alone, const FitOptions& options) const;
    /// All recordings together from each one's own fit of the same model.
    [[nodiscard]] Fit fit_from_alone(std::span<const RecordingFit> alone,
                                     const FitOptions& options) const;

  private:
    [[nodiscard]] Fit fitted(const FitOptions& options) const;
    [[nodiscard]] bool moves() const;
    [[nodiscard]] bool moves_more() const;
    [[nodiscard]] std::vector<StartModels> larger_starts() const;
    [[nodiscard]] Fit fit_alone(std::size_t recording, const FitOptions& options) const;
    [[nodiscard]] Fit fit_from_own(const FitOptions& options) const;
    [[nodiscard]] Fit fit_from_starts(const FitOptions& options) const;

    std::string failure_; ///< why there is no plan
    SelectedEffects effects_;
    const Fit& smaller_;
    std::span<const ObservedRecording> recordings_;
    StartModels models_;
    std::vector<RecordedSwing> swings_; ///< of several recordings
    std::vector<StartModels> starts_;   ///< from `smaller`, if it has a fit and moves as much
};

/// Of a run with these effects, against one of the published chain: spatial chains take six times
/// as long.
[[nodiscard]] double relative_cost(const SelectedEffects& effects);

} // namespace culm::fit
