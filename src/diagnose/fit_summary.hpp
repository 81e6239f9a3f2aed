// SPDX-License-Identifier: BSD-3-Clause
// A fit as the few numbers that another rank needs of it.
#pragma once

#include "diagnose/model_fit.hpp"

#include <optional>
#include <span>
#include <string>
#include <vector>

namespace culm::diagnose {

struct FitSummary {
    std::vector<std::string> names; ///< "baseline" and the effects
    std::string failure;            ///< why there is no fit; empty if there is
    bool moves = true;
    std::vector<calibrate::FittedParameter> parameters; ///< as ModelFit's
    double chi_squared = 0.0;
    double reduced_chi_squared = 0.0;
    double rmse = 0.0; ///< m
    std::size_t readings = 0;
    double effective_readings = 0.0; ///< of the residuals, as far as a mean is concerned
    int runs = 0;
    /// χ² to which its pace would not have brought it, so that it was not followed to its end.
    std::optional<double> out_of_reach;

    [[nodiscard]] bool is_fitted() const { return failure.empty() && moves; }
};

[[nodiscard]] FitSummary summary_of(const ModelFit& fit);

/// As text and back; every number returns with all its bits. An empty text is a failed fit.
[[nodiscard]] std::string to_text(const FitSummary& summary);
[[nodiscard]] FitSummary summary_from_text(const std::string& text);

/// The models of the recordings with the numbers of the fit.
[[nodiscard]] std::vector<calibrate::StemModel>
models_of(const FitSummary& summary, const SelectedEffects& effects,
          std::span<const measure::Measurement> recordings, const CandidateOptions& options = {});

/// The fit again, residuals and derivatives too, by one run of each recording: the same on every
/// rank, whichever found it. Throws core::NumericalError if that run fails.
[[nodiscard]] ModelFit restored(const FitSummary& summary, const SelectedEffects& effects,
                                std::span<const measure::Measurement> recordings,
                                const CandidateOptions& options = {});

} // namespace culm::diagnose
