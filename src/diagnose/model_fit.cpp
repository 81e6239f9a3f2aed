// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/model_fit.hpp"

#include "diagnose/fit_plan.hpp"
#include "physics/effects/library.hpp"

namespace culm::diagnose {

bool belongs_to_recording(const std::string& parameter) {
    return parameter == "tip_deflection" || parameter == calibrate::release_time_name ||
           physics::belongs_to(parameter) == physics::BelongsTo::Recording;
}

ModelFit fit_model(const SelectedEffects& effects, const ModelFit& smaller,
                   std::span<const measure::Measurement> recordings,
                   const CandidateOptions& options) {
    const FitPlan plan(effects, smaller, recordings, options);
    std::vector<std::string> begun;
    for (std::size_t k = 0; k < plan.start_count(); ++k)
        begun.push_back(plan.begin(k, options));
    return plan.finish(begun, options);
}

} // namespace culm::diagnose
