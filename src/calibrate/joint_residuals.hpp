// SPDX-License-Identifier: BSD-3-Clause
// The residuals of several recordings as one least-squares problem in transformed parameters.
#pragma once

#include "calibrate/joint_layout.hpp"
#include "calibrate/reading_residuals.hpp"

#include <cstddef>
#include <utility>
#include <vector>

#include <ceres/evaluation_callback.h>

namespace culm::calibrate {

/// Numbers that Ceres works on: joint parameters as FreeParameter transforms them, release times in
/// units of their bounds.
class JointResiduals : public ceres::EvaluationCallback {
  public:
    /// Both must outlive this; the parts are those of the models, in their order.
    JointResiduals(const std::vector<StemModel>& models, const JointLayout& layout,
                   std::vector<ReadingResiduals> parts);

    [[nodiscard]] std::size_t parameter_count() const { return internal_.size(); }
    /// Ceres's parameter block: (parameters).
    [[nodiscard]] double* internal() { return internal_.data(); }
    [[nodiscard]] const double* internal() const { return internal_.data(); }
    [[nodiscard]] double lower(std::size_t parameter) const; ///< bounds, internal
    [[nodiscard]] double upper(std::size_t parameter) const;
    [[nodiscard]] const std::vector<ReadingResiduals>& parts() const { return parts_; }

    /// The first recording's case at other internal parameters, within their bounds.
    [[nodiscard]] run::CaseSpec case_at(const double* internal) const;

    /// Computes the chains if the parameters have changed.
    void PrepareForEvaluation(bool evaluate_jacobians, bool new_evaluation_point) override;

    /// Residual and gradient of one place of a part at the prepared point; false if its chain could
    /// not be computed there. `gradient` may be null.
    [[nodiscard]] bool evaluate(std::size_t part, const ReadingResiduals::Place& place,
                                double* residual, double* gradient) const;

  private:
    /// The owner's parameter; null for a release time.
    [[nodiscard]] const FreeParameter* owner(std::size_t parameter) const;
    [[nodiscard]] const StemModel& start(std::size_t parameter) const;
    [[nodiscard]] double value(std::size_t parameter) const; ///< natural units
    [[nodiscard]] double value_of(std::size_t parameter, double internal) const;
    [[nodiscard]] double natural_per_internal(std::size_t parameter) const;
    [[nodiscard]] std::pair<double, double> bounds(std::size_t parameter) const; ///< internal

    const std::vector<StemModel>& models_;
    const JointLayout& layout_;
    std::vector<ReadingResiduals> parts_;
    std::vector<double> internal_;
    std::vector<double> per_internal_; ///< natural_per_internal at the prepared point
};

} // namespace culm::calibrate
