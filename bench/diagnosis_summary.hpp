// SPDX-License-Identifier: BSD-3-Clause
// A short summary of a diagnosis, for benches with many of them.
#pragma once

#include "diagnose/diagnosis.hpp"

#include <string>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

namespace culm::bench {

/// "effect quadratic_drag+clamp_compliance", "adequate ".
[[nodiscard]] inline std::string answer_of(const diagnose::Diagnosis& found) {
    return fmt::format("{} {}", to_string(found.conclusion), fmt::join(found.effects, "+"));
}

/// Answer and reason, residuals of the baseline and the final model, the tests that reject the
/// baseline, and the noise of the first recording.
[[nodiscard]] inline nlohmann::json diagnosis_summary(const diagnose::Diagnosis& found) {
    return {{"answer", answer_of(found)},
            {"reason", found.reason},
            {"baseline_reduced_chi2", found.baseline.reduced_chi_squared},
            {"final_reduced_chi2", found.final_fit.reduced_chi_squared},
            {"tests", found.ladder.front().verdict.reason},
            {"noise", found.baseline.parts.front().noise_source},
            {"noise_mm", 1e3 * found.baseline.parts.front().noise.front()}};
}

/// How often something happened.
struct Rate {
    int hits = 0;
    int of = 0;
    void add(bool is_hit) {
        hits += is_hit ? 1 : 0;
        ++of;
    }
    [[nodiscard]] std::string text() const {
        return of == 0 ? std::string("none")
                       : fmt::format("{}/{} ({:.1f} %)", hits, of, 100.0 * hits / of);
    }
};

} // namespace culm::bench
