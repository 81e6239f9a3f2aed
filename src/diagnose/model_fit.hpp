// SPDX-License-Identifier: BSD-3-Clause
// One model fitted to one or several recordings at once.
#pragma once

#include "diagnose/candidate_fit.hpp"

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace culm::diagnose {

/// Recordings share the material and all that acts on the stem; what belongs to one release or one
/// recording (belongs_to_recording) has a value for each.
struct ModelFit {
    std::vector<std::string> names;         ///< "baseline" and the effects, in the library's order
    std::vector<calibrate::ChainFit> parts; ///< (recordings); empty: there is no fit
    /// Every number that was fitted, once. What has a value for each recording is called
    /// "name@id" where there are several recordings.
    std::vector<calibrate::FittedParameter> parameters;
    /// (recordings)(parameters of the part): their places in `parameters`.
    std::vector<std::vector<std::size_t>> places;
    double chi_squared = 0.0;
    std::size_t readings = 0;
    double reduced_chi_squared = 0.0;
    double rmse = 0.0;                  ///< m, over all readings
    std::optional<double> out_of_reach; ///< as calibrate::JointFit's
    std::string failure;                ///< why there is no fit
    int runs = 0;                       ///< of the chain with all its derivatives
    bool moves = true;                  ///< as CandidateFit's; false only if no recording moves

    [[nodiscard]] bool is_fitted() const { return !parts.empty(); }
};

/// Has the parameter a value for each recording: tip deflection, release time, and those of
/// tip_mass, finite_release and base_motion?
[[nodiscard]] bool belongs_to_recording(const std::string& parameter);

/// `effects` beside the published chain (none: the chain itself), from `smaller`, a fit with some
/// or none of them; empty only for the chain itself. Never throws for a model that cannot be fitted
/// or combined: `failure` says why. run::Abandoned if the heartbeat says so.
[[nodiscard]] ModelFit fit_model(const SelectedEffects& effects, const ModelFit& smaller,
                                 std::span<const measure::Measurement> recordings,
                                 const CandidateOptions& options = {});

} // namespace culm::diagnose
