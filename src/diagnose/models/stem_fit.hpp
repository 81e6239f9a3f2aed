// SPDX-License-Identifier: BSD-3-Clause
// The fit of one stem with the effects of a model: an item that any rank can compute.
#pragma once

#include "diagnose/evidence/effect_view.hpp"
#include "diagnose/models/model.hpp"

#include <functional>
#include <span>
#include <vector>

#include <Eigen/Core>

namespace culm::diagnose {

/// Adds the effects to `smaller`, which has its parts, from the linear estimate about it. If
/// nothing moves in `smaller`, as fit::fit_model(). Never throws for a model that cannot be fitted
/// or combined, but returns FitStatus::Failed with the reason.
[[nodiscard]] fit::Fit fit_larger(const fit::SelectedEffects& effects, const fit::Fit& smaller,
                                  std::span<const fit::ObservedRecording> recordings,
                                  const fit::FitOptions& options = {});

/// Where the fit of a stem begins.
struct StemStart {
    /// Numbers of a fit with some of the effects; null: the fit begins at one point.
    const fit::Fit* smaller = nullptr;
    /// As fit::fit_near() takes them, about `smaller` with its parts (null: it is null); empty: as
    /// fit_larger(), or the stem's numbers in the model.
    std::function<std::vector<fit::StartModels>(const fit::Fit* smaller, const fit::FitOptions&)>
        starts;
};

[[nodiscard]] StemFit fit_stem(const Stems& stems, std::size_t stem, const StemEffects& effects,
                               const StemStart& start, const fit::FitOptions& options);

/// Fits the stem's own numbers at the values that its rig's effects have in `model`. The fit begins
/// at `start` or, if that is empty, at the stem's numbers in the model after `change` (as
/// SharedBlock::follow; empty: none).
[[nodiscard]] StemFit fit_at_shared(const Stems& stems, std::size_t stem, const Model& model,
                                    const Eigen::VectorXd& change, const StemStart& start,
                                    const fit::FitOptions& options);

/// The stem's fit in the model as the base of others: parts and system are complete, χ² and pulls
/// are those of the linear solution.
[[nodiscard]] fit::Fit base_fit(const Stems& stems, std::size_t stem, const Model& model,
                                const fit::FitOptions& options);

/// Why a candidate has no columns.
inline constexpr const char* combination_failure = "it cannot be combined with the model";

/// Changes of a stem's readings by the candidates number `first` … `last` − 1 about its base_fit().
[[nodiscard]] std::vector<EffectColumns> columns_about(const Stems& stems, std::size_t stem,
                                                       const fit::Fit& base, std::size_t first,
                                                       std::size_t last,
                                                       const fit::FitOptions& options);

} // namespace culm::diagnose
