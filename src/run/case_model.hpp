// SPDX-License-Identifier: BSD-3-Clause
// A case's chain with its effects, known masses and camera.
#pragma once

#include "physics/chain_model.hpp"
#include "physics/effects/effect.hpp"
#include "run/case_spec.hpp"

#include <span>

namespace culm::run {

struct CaseModel {
    physics::ChainModel<double> chain;
    physics::CameraView camera;
};

/// The chain that the specification describes. Throws core::InputError if effects cannot be
/// combined or applied to this stem.
[[nodiscard]] CaseModel case_model(const CaseSpec& spec);

/// 3 if the case or one of its effects leaves the plane of the pull.
[[nodiscard]] int dimensions_of(const CaseSpec& spec);

/// Whether two cases have the same effects and kinds of parts, so that their chains can share
/// lanes.
[[nodiscard]] bool same_kind_of_model(const CaseSpec& a, const CaseSpec& b);

/// One chain in every lane. All models have the same kinds of parts; lanes beyond them repeat the
/// first. T is double (the first model) or Lanes.
template <class T>
[[nodiscard]] physics::ChainModel<T> packed_model(std::span<const CaseModel> models);

} // namespace culm::run
