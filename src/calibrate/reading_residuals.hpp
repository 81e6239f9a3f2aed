// SPDX-License-Identifier: BSD-3-Clause
// The weighted residuals of a model as a least-squares problem in transformed parameters.
#pragma once

#include "calibrate/chain_prediction.hpp"
#include "measure/measurement.hpp"

#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include <ceres/evaluation_callback.h>

namespace culm::calibrate {

/// Numbers that Ceres works on: parameters as FreeParameter transforms them, the release time in
/// units of its bound. Runs the chain once per point, values and derivatives together, because the
/// derivatives come along in the SIMD lanes.
class ReadingResiduals : public ceres::EvaluationCallback {
  public:
    /// One reading that was seen.
    struct Place {
        std::size_t reading = 0;    ///< in the (frames, rows) table of the prediction
        double measured = 0.0;      ///< m
        double inverse_noise = 0.0; ///< 1/m
    };

    /// Frames up to `last_time`; `noise` per row, m. `model` and `measurement` must outlive this.
    ReadingResiduals(const StemModel& model, const measure::Measurement& measurement,
                     const std::vector<double>& noise, double last_time, run::Heartbeat heartbeat);

    [[nodiscard]] std::size_t parameter_count() const { return internal_.size(); }
    /// Ceres's parameter block: (parameters).
    [[nodiscard]] double* internal() { return internal_.data(); }
    [[nodiscard]] const std::vector<Place>& places() const { return places_; }
    [[nodiscard]] const std::vector<double>& times() const { return times_; }
    [[nodiscard]] int runs() const { return runs_; }
    [[nodiscard]] double lower(std::size_t parameter) const; ///< bounds, internal
    [[nodiscard]] double upper(std::size_t parameter) const;

    /// Computes the chain if the parameters have changed.
    void PrepareForEvaluation(bool evaluate_jacobians, bool new_evaluation_point) override;

    /// Residual and gradient of one place at the prepared point; false if the chain could not be
    /// computed there. `gradient` may be null.
    [[nodiscard]] bool evaluate(const Place& place, double* residual, double* gradient) const;

    /// The model with the current parameters, and its prediction. Throws core::NumericalError if
    /// the chain cannot be computed there.
    [[nodiscard]] StemModel current_model() const;
    [[nodiscard]] const ChainPrediction& prediction();

  private:
    [[nodiscard]] double value(std::size_t parameter) const;                     ///< natural units
    [[nodiscard]] std::pair<double, double> bounds(std::size_t parameter) const; ///< internal
    [[nodiscard]] double natural_per_internal(std::size_t parameter) const;

    const StemModel& model_;
    run::Heartbeat heartbeat_;
    std::vector<double> times_;
    std::vector<Place> places_;
    std::vector<double> internal_;
    std::vector<double> prepared_;              ///< parameters of prediction_
    std::optional<ChainPrediction> prediction_; ///< empty: could not be computed
    std::string failure_;
    int runs_ = 0;
};

} // namespace culm::calibrate
