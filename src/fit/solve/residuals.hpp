// SPDX-License-Identifier: BSD-3-Clause
// The weighted residuals of one or several recordings as one least-squares problem, and its steps.
#pragma once

#include "fit/model/observed_recording.hpp"
#include "fit/model/prediction.hpp"
#include "fit/model/reading_noise.hpp"
#include "fit/solve/layout.hpp"

#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <ceres/evaluation_callback.h>
#include <ceres/manifold.h>

namespace culm::fit {

/// Runs the chain once per point for values and derivatives, which the SIMD lanes compute together.
class ReadingResiduals {
  public:
    /// One reading that was seen.
    struct Place {
        std::size_t reading = 0;    ///< in the (frames, rows) table of the prediction
        double measured = 0.0;      ///< m
        double inverse_noise = 0.0; ///< 1/m
    };

    /// Frames up to `last_time`; `noise` per row, m. `model` must outlive this.
    ReadingResiduals(const StemModel& model, const ObservedRecording& measurement,
                     const std::vector<double>& noise, double last_time, run::Heartbeat heartbeat);

    [[nodiscard]] const std::vector<Place>& places() const { return places_; }
    [[nodiscard]] const std::vector<double>& times() const { return times_; }
    [[nodiscard]] int runs() const { return runs_; }

    /// Computes the chain at these values of the free parameters if they have changed. If it cannot
    /// be computed, evaluate() returns false.
    void prepare(const std::vector<double>& values);

    /// Predicted − measured over the noise at the prepared point; false if the chain could not be
    /// computed there.
    [[nodiscard]] bool evaluate(const Place& place, double* residual) const;
    /// Derivative of that residual by a free parameter, per unit; 0 where it is not seen.
    [[nodiscard]] double derivative(const Place& place, std::size_t parameter) const;

    [[nodiscard]] StemModel current_model() const; ///< with the prepared values
    /// Throws core::NumericalError if the chain cannot be computed there.
    [[nodiscard]] const ChainPrediction& prediction() const;

  private:
    void whiten();

    const StemModel& model_;
    run::Heartbeat heartbeat_;
    std::optional<Whitening> whitening_;  ///< empty: readings are independent
    std::vector<double> white_residuals_; ///< (frames, rows)
    std::vector<double> white_jacobian_;  ///< (parameters, frames, rows)
    std::vector<double> times_;
    std::vector<Place> places_;
    std::vector<double> values_;                ///< of prediction_
    std::optional<ChainPrediction> prediction_; ///< empty: could not be computed
    std::string failure_;
    bool is_prepared_ = false;
    int runs_ = 0;
};

/// The numbers that Ceres changes: joint parameters in the transformation of FreeParameter, release
/// times in units of their bounds, error terms unchanged.
class JointResiduals : public ceres::EvaluationCallback {
  public:
    /// Both must outlive this; the parts are those of the models, in their order.
    JointResiduals(const std::vector<StemModel>& models, const JointLayout& layout,
                   std::vector<ReadingResiduals> parts);

    [[nodiscard]] std::size_t parameter_count() const { return internal_.size(); }
    /// Ceres's parameter block: (parameters).
    [[nodiscard]] double* internal() { return internal_.data(); }
    [[nodiscard]] const double* internal() const { return internal_.data(); }
    [[nodiscard]] std::pair<double, double> bounds(std::size_t parameter) const; ///< internal
    [[nodiscard]] const std::vector<ReadingResiduals>& parts() const { return parts_; }
    /// Is it an error term? Its constraint adds its own value as a residual.
    [[nodiscard]] bool is_error(std::size_t parameter) const;

    /// The first recording's case at other internal parameters, within their bounds.
    [[nodiscard]] run::CaseSpec case_at(const double* internal) const;

    /// Computes the chains if the parameters have changed.
    void PrepareForEvaluation(bool evaluate_jacobians, bool new_evaluation_point) override;

    /// Residual and gradient of one place of a part at the prepared point; false if its chain could
    /// not be computed there. `gradient` may be null.
    [[nodiscard]] bool evaluate(std::size_t part, const ReadingResiduals::Place& place,
                                double* residual, double* gradient) const;

  private:
    /// The owner's parameter; null for a release time and an error term.
    [[nodiscard]] const FreeParameter* owner(std::size_t parameter) const;
    [[nodiscard]] double plain_scale(std::size_t parameter) const; ///< of those without an owner
    [[nodiscard]] double plain_centre(std::size_t parameter) const;
    [[nodiscard]] const StemModel& start(std::size_t parameter) const;
    [[nodiscard]] double value_of(std::size_t parameter, double internal) const; ///< natural units

    const std::vector<StemModel>& models_;
    const JointLayout& layout_;
    std::vector<ReadingResiduals> parts_;
    std::vector<double> internal_;
    std::vector<double> per_internal_; ///< natural units per internal one at the prepared point
};

/// A ring-down determines the stem's frequency to 1e-4, and many parameters change it: a mass at
/// the tip, a soft clamp, a taper. The valley in which Y compensates for them is narrow and curved,
/// and straight steps along it are a hundredth of its length. Here a step keeps its direction,
/// except that Y takes the value at which the linearised chain has the frequency of the straight
/// step to first order. Derivatives at the point are those of straight steps.
class ValleySteps : public ceres::Manifold {
  public:
    /// `residuals` must outlive this; `is_held` parameters do not move.
    ValleySteps(const JointResiduals& residuals, const JointLayout& layout,
                const std::vector<bool>& is_held);

    [[nodiscard]] int AmbientSize() const override { return static_cast<int>(size_); }
    [[nodiscard]] int TangentSize() const override { return static_cast<int>(free_.size()); }
    bool Plus(const double* point, const double* step, double* moved) const override;
    bool PlusJacobian(const double* point, double* jacobian) const override;
    /// Exact to first order.
    bool Minus(const double* moved, const double* point, double* step) const override;
    bool MinusJacobian(const double* point, double* jacobian) const override;

  private:
    /// ln f² of the first recording's chain.
    [[nodiscard]] double log_square(const std::vector<double>& internal) const;
    void follow_frequency(const std::vector<double>& point, std::vector<double>& moved) const;

    const JointResiduals& residuals_;
    std::size_t size_;
    std::vector<std::size_t> free_;
    std::optional<std::size_t> modulus_; ///< place of Y, whose internal value is its logarithm
};

} // namespace culm::fit
