// SPDX-License-Identifier: BSD-3-Clause
// When a larger model counts as found: the conditions for naming an effect.
#pragma once

#include "diagnose/held_out.hpp"
#include "diagnose/model_score.hpp"
#include "diagnose/score_test.hpp"
#include "diagnose/verdict.hpp"
#include "fit/work_map.hpp"

#include <span>
#include <string>
#include <vector>

namespace culm::diagnose {

inline constexpr double naming_gain = 10.0; ///< of BIC, that an effect must bring
inline constexpr double tie_gap = 6.0;      ///< of BIC, within which two models count as equal
/// Within which one that leaves nothing but noise stays possible: a chain is no beam, and a law of
/// culm's not the stem's, to some χ².
inline constexpr double clear_gap = 12.0;
inline constexpr double naming_level = 0.01; ///< of significance, for all candidates together

/// Of the misfit, that effects which leave structure must explain to be named: what is missing is
/// then small beside them. A force of another form leaves more (docs/diagnosis.md).
inline constexpr double nearly_all = 0.98;
inline constexpr double all_but_a_trace = 0.99; ///< of two that are one law

/// Of the tests for lack of fit, from which a model that nothing improves counts as failing: of a
/// hundred recordings of noise one fails at the tests' own level.
inline constexpr double clear_failure_level = 1e-4;

/// Why `larger` is no step forward from `smaller` where `tried` candidates were looked at; empty if
/// it is: its gain is small or not significant, or it leaves a glaring misfit hardly touched.
[[nodiscard]] std::string step_obstacle(const fit::Fit& smaller, const fit::Fit& larger,
                                        const Yardstick& by, std::size_t tried);

/// Has `larger` no number to fit that `smaller` has not, and takes it away nearly all of the
/// misfit?
[[nodiscard]] bool acts_for_certain(const fit::Fit& smaller, const fit::Fit& larger);

/// Before anything is named: does a candidate promise more than noise would, for as many as there
/// are? The tests for lack of fit look at everything and so miss a weak trace of one effect.
[[nodiscard]] bool promises_significant_gain(const std::vector<EffectScore>& scores,
                                             const fit::Fit& fit);

/// Has the larger model, fitted to its end, taken away this share of the misfit above the noise?
[[nodiscard]] bool explains(const fit::Fit& smaller, const fit::Fit& larger, double share);

/// χ² above which a step that adds so many effects leaves a glaring misfit hardly touched.
[[nodiscard]] double step_limit(const fit::Fit& smaller, std::size_t added);

/// The tests for lack of fit of every recording, adjusted for their number.
struct SetVerdict {
    Finding finding = Finding::Undecided;
    double p_value = 1.0;
    std::string reason;
};
[[nodiscard]] SetVerdict judge(const fit::Fit& fit,
                               std::span<const measure::Measurement> recordings);

/// Root mean squares of the readings that were held out, over the noise, by both models.
struct HeldOutGain {
    double larger = 0.0;
    double smaller = 0.0;
    std::string obstacle; ///< why the larger model does not predict better; empty if it does
};

/// Both models refitted without the last third of the time and without one height, in every
/// recording.
[[nodiscard]] HeldOutGain held_out_gain(const fit::Fit& smaller, const fit::Fit& larger,
                                        std::span<const measure::Measurement> recordings,
                                        const fit::FitOptions& options, const fit::WorkMap& map);

} // namespace culm::diagnose
