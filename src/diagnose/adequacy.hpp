// SPDX-License-Identifier: BSD-3-Clause
// Whether a fitted chain explains its recordings, and how sure that is. The one verdict, for
// `calibrate`, `compare` and `diagnose`.
#pragma once

#include "diagnose/policy.hpp"
#include "residuals/lack_of_fit.hpp"
#include "residuals/swing.hpp"

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace culm::diagnose {

enum class Finding {
    Adequate,   ///< the residuals are noise
    Inadequate, ///< the model lacks something
    Undecided   ///< the recording cannot tell
};

/// "adequate", "inadequate", "undecided".
[[nodiscard]] std::string_view to_string(Finding finding);

struct Verdict {
    Finding finding = Finding::Undecided;
    double p_value = 1.0; ///< the smallest adjusted one
    std::vector<residuals::LackOfFitTest> tests;
    std::vector<std::string> failed_tests; ///< at the level of the policy
    std::string reason;                    ///< which tests object, or why nothing can be said
    bool is_noise_known = false;
    double reduced_chi_squared = 0.0;
    double effective_degrees_of_freedom = 0.0;
    double spatial_share = 0.0;          ///< of the residuals' power in one pattern over the rows
    std::vector<double> spatial_pattern; ///< (rows), m, root mean square over the frames
};

/// The tests for lack of fit of one recording, together by Holm's adjustment. Undecided: too few
/// cycles or frames, or a swing that hardly stands out of its noise.
[[nodiscard]] Verdict verdict_on(const fit::RecordingFit& fit, const residuals::Swing& swing,
                                 const Policy& policy = {});

/// The tests of every recording, adjusted for their number (Bonferroni).
struct SetVerdict {
    Finding finding = Finding::Undecided;
    double p_value = 1.0;
    std::string reason;
};
[[nodiscard]] SetVerdict verdict_on(const fit::Fit& fit,
                                    std::span<const fit::ObservedRecording> recordings,
                                    const Policy& policy = {});

/// Throws core::InputError if the readings after the release, up to `window` seconds if given, are
/// what their noise alone would give: their χ² is hardly above its mean n. A fit to them would
/// wander without an end. Where no noise is known nothing is said.
void refuse_without_motion(const measure::Measurement& measurement, std::optional<double> window);

} // namespace culm::diagnose
