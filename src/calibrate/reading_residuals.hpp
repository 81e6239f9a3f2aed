// SPDX-License-Identifier: BSD-3-Clause
// The weighted residuals of one recording's model.
#pragma once

#include "calibrate/chain_prediction.hpp"
#include "measure/folder/measurement.hpp"

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace culm::calibrate {

/// Runs the chain once per point, values and derivatives together, because the derivatives come
/// along in the SIMD lanes.
class ReadingResiduals {
  public:
    /// One reading that was seen.
    struct Place {
        std::size_t reading = 0;    ///< in the (frames, rows) table of the prediction
        double measured = 0.0;      ///< m
        double inverse_noise = 0.0; ///< 1/m
    };

    /// Frames up to `last_time`; `noise` per row, m. `model` must outlive this.
    ReadingResiduals(const StemModel& model, const measure::Measurement& measurement,
                     const std::vector<double>& noise, double last_time, run::Heartbeat heartbeat);

    [[nodiscard]] const std::vector<Place>& places() const { return places_; }
    [[nodiscard]] const std::vector<double>& times() const { return times_; }
    [[nodiscard]] int runs() const { return runs_; }

    /// Computes the chain at these values of the free parameters if they have changed. Where it
    /// cannot be computed evaluate() says so.
    void prepare(const std::vector<double>& values);

    /// Predicted − measured over the noise at the prepared point; false if the chain could not be
    /// computed there.
    [[nodiscard]] bool evaluate(const Place& place, double* residual) const;
    /// Derivative of the predicted reading by a free parameter, m per unit; 0 where it is not seen.
    [[nodiscard]] double derivative(const Place& place, std::size_t parameter) const;

    [[nodiscard]] StemModel current_model() const; ///< with the prepared values
    /// Throws core::NumericalError if the chain cannot be computed there.
    [[nodiscard]] const ChainPrediction& prediction() const;

  private:
    const StemModel& model_;
    run::Heartbeat heartbeat_;
    std::vector<double> times_;
    std::vector<Place> places_;
    std::vector<double> values_;                ///< of prediction_
    std::optional<ChainPrediction> prediction_; ///< empty: could not be computed
    std::string failure_;
    int runs_ = 0;
};

} // namespace culm::calibrate
