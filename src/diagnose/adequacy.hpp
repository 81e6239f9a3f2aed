// SPDX-License-Identifier: BSD-3-Clause
// Whether a fitted chain explains its recordings, and how certain that is. `calibrate`, `compare`
// and `diagnose` share this verdict.
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
    Undecided   ///< the recording does not determine it
};

/// "adequate", "inadequate", "undecided".
[[nodiscard]] std::string_view to_string(Finding finding);

struct Verdict : residuals::LackOfFit {
    Finding finding = Finding::Undecided;
    double p_value = 1.0;                  ///< the smallest adjusted one
    std::vector<std::string> failed_tests; ///< at the level of the policy
    std::string reason;                    ///< which tests fail, or why there is no verdict
    bool is_noise_known = false;
    double reduced_chi_squared = 0.0;
};

/// The tests for lack of fit of one recording, combined by Holm's adjustment. The verdict is
/// undecided if there are too few cycles or frames, or if the swing hardly exceeds its noise.
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

/// Does the fit fail the tests with a residual above the noise that a user can ignore?
[[nodiscard]] bool has_structure(const fit::Fit& fit, const SetVerdict& verdict,
                                 const Policy& policy);

/// Share of the misfit of `first` (χ² above the noise) that `fit` explains, from 0 to 1. A chain
/// that does not move, or is cycles away, leaves the motion itself, which says nothing about laws:
/// its misfit counts as that of a chain that follows the motion (fit::small_remainder).
[[nodiscard]] double explained_share(const fit::Fit& fit, const fit::Fit& first);

/// Does `fit` have structure and leave more of the misfit of `first` than an answer may?
[[nodiscard]] bool leaves_too_much(const fit::Fit& fit, const SetVerdict& verdict,
                                   const fit::Fit& first, const Policy& policy);

/// Throws core::InputError if the readings after the release, up to `window` seconds if given, are
/// consistent with noise alone: their χ² is hardly above its mean n. A fit to them would not
/// converge. Does nothing if the noise is not known.
void refuse_without_motion(const measure::Measurement& measurement, std::optional<double> window);

} // namespace culm::diagnose
