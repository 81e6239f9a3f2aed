// SPDX-License-Identifier: BSD-3-Clause
// Motion out of the plane as a sum of planar motions.
#pragma once

#include "fit/chain/stem_model.hpp"

#include <vector>

namespace culm::fit {

/// A planar model whose readings are a part of those of a spatial model.
struct PlanarModel {
    double weight = 1.0;
    double modulus_factor = 1.0; ///< of its Y to that of the spatial model
    StemModel model;             ///< without the effect that leaves the plane
};

/// By physics::Effect::planar_parts() of the model's effects; empty if none has such parts.
[[nodiscard]] std::vector<PlanarModel> planar_models(const StemModel& model);

/// The readings of the model: the weighted sum of the predictions for its planar_models(), with
/// derivatives if these have them. Exact to first order in the deflection.
[[nodiscard]] ChainPrediction superposed(const StemModel& model,
                                         const std::vector<PlanarModel>& parts,
                                         const std::vector<ChainPrediction>& predictions);

} // namespace culm::fit
