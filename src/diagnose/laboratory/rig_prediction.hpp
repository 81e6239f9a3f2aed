// SPDX-License-Identifier: BSD-3-Clause
// Predicted log evidence of effects of a rig, about a fitted model of all stems.
#pragma once

#include "diagnose/evidence/linear_evidence.hpp"
#include "diagnose/laboratory/laboratory_fit.hpp"

#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace culm::diagnose {

/// The candidates' columns, summed over the stems of a rig. Sizes are in common units, the means of
/// the stems' usual sizes.
class RigPrediction {
  public:
    /// `surveys` (stems) about `model`.
    RigPrediction(const LaboratoryStems& stems, std::span<const StemSurvey> surveys,
                  const LaboratoryModel& model, std::string rig);

    /// Why the candidate has no prediction; empty if it has.
    [[nodiscard]] const std::string& failure(std::size_t candidate) const {
        return columns_[candidate].failure;
    }
    /// Change of the log evidence by these candidates together.
    [[nodiscard]] PredictedGain gain(std::span<const std::size_t> candidates) const {
        return linear_.gain(candidates);
    }
    /// Candidate number `place` of those of `gain`, with the values of the linear estimate.
    [[nodiscard]] RigEffect estimated(std::size_t candidate, std::size_t place,
                                      const PredictedGain& gain) const;

  private:
    struct Placement;
    void average(std::size_t candidate, std::span<const StemSurvey> surveys);
    [[nodiscard]] Placement placement_of(const StemSurvey& survey) const;
    [[nodiscard]] LinearEvidence sum(std::span<const StemSurvey> surveys,
                                     const SharedMinimum& shared) const;

    const LaboratoryStems& stems_;
    std::string rig_;
    std::vector<std::size_t> on_rig_;                 ///< stems
    std::vector<EffectColumns> columns_;              ///< (candidates) without readings
    std::vector<std::vector<ParameterPrior>> priors_; ///< (candidates)(free parameters)
    LinearEvidence linear_;
};

} // namespace culm::diagnose
