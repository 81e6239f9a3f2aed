// SPDX-License-Identifier: BSD-3-Clause
#include "calibrate/reading_residuals.hpp"

#include "core/error.hpp"

#include <cmath>
#include <utility>

namespace culm::calibrate {

ReadingResiduals::ReadingResiduals(const StemModel& model, const measure::Measurement& measurement,
                                   const std::vector<double>& noise, double last_time,
                                   run::Heartbeat heartbeat)
    : model_(model), heartbeat_(std::move(heartbeat)) {
    const std::size_t rows = measurement.heights.size();
    for (std::size_t i = 0; i < measurement.times.size() && measurement.times[i] <= last_time;
         ++i) {
        times_.push_back(measurement.times[i]);
        for (std::size_t j = 0; j < rows; ++j)
            if (const double reading = measurement.deflection(i, j); !std::isnan(reading))
                places_.push_back({i * rows + j, reading, 1.0 / noise[j]});
    }
}

void ReadingResiduals::prepare(const std::vector<double>& values) {
    if (values_ == values && runs_ > 0)
        return;
    values_ = values;
    prediction_.reset();
    ++runs_;
    try {
        prediction_ = predict_readings(current_model(), times_, heartbeat_);
    } catch (const core::NumericalError& error) {
        failure_ = error.what();
    }
}

bool ReadingResiduals::evaluate(const Place& place, double* residual) const {
    if (!prediction_)
        return false;
    const double predicted = prediction_->readings[place.reading];
    // The model's stem may just not reach the row: the reading then tells it nothing.
    *residual = std::isnan(predicted) ? 0.0 : (predicted - place.measured) * place.inverse_noise;
    return true;
}

double ReadingResiduals::derivative(const Place& place, std::size_t parameter) const {
    const double derivative =
        prediction_->jacobian[place.reading * prediction_->parameters + parameter];
    const bool is_seen = !std::isnan(prediction_->readings[place.reading]);
    return is_seen && std::isfinite(derivative) ? derivative : 0.0;
}

StemModel ReadingResiduals::current_model() const {
    StemModel current = model_;
    for (std::size_t k = 0; k < values_.size(); ++k)
        if (k < model_.parameters.size())
            model_.parameters[k].access.set(current.spec, values_[k]);
        else
            current.release_time = values_[k];
    return current;
}

const ChainPrediction& ReadingResiduals::prediction() const {
    if (!prediction_)
        throw core::NumericalError(core::FailureKind::FitFailed, failure_);
    return *prediction_;
}

} // namespace culm::calibrate
