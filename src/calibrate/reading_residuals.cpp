// SPDX-License-Identifier: BSD-3-Clause
#include "calibrate/reading_residuals.hpp"

#include "core/error.hpp"

#include <algorithm>
#include <cmath>

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
    for (const FreeParameter& parameter : model.parameters)
        internal_.push_back(to_internal(parameter, model.spec, parameter.access.get(model.spec)));
    if (model.release_time_bound > 0.0)
        internal_.push_back(model.release_time / model.release_time_bound);
}

double ReadingResiduals::value(std::size_t parameter) const {
    return parameter < model_.parameters.size()
               ? from_internal(model_.parameters[parameter], model_.spec, internal_[parameter])
               : internal_[parameter] * model_.release_time_bound;
}

double ReadingResiduals::natural_per_internal(std::size_t parameter) const {
    if (parameter >= model_.parameters.size())
        return model_.release_time_bound;
    return value_per_internal(model_.parameters[parameter], model_.spec, value(parameter));
}

std::pair<double, double> ReadingResiduals::bounds(std::size_t parameter) const {
    const FreeParameter& free = model_.parameters[parameter];
    return std::minmax(
        {to_internal(free, model_.spec, free.lower), to_internal(free, model_.spec, free.upper)});
}

double ReadingResiduals::lower(std::size_t parameter) const {
    return parameter < model_.parameters.size() ? bounds(parameter).first : -1.0;
}

double ReadingResiduals::upper(std::size_t parameter) const {
    return parameter < model_.parameters.size() ? bounds(parameter).second : 1.0;
}

StemModel ReadingResiduals::current_model() const {
    StemModel current = model_;
    for (std::size_t k = 0; k < internal_.size(); ++k)
        if (k < model_.parameters.size())
            model_.parameters[k].access.set(current.spec, value(k));
        else
            current.release_time = value(k);
    return current;
}

void ReadingResiduals::PrepareForEvaluation(bool, bool) {
    if (prepared_ == internal_)
        return;
    prepared_ = internal_;
    prediction_.reset();
    ++runs_;
    try {
        prediction_ = predict_readings(current_model(), times_, heartbeat_);
    } catch (const core::NumericalError& error) {
        failure_ = error.what();
    }
}

bool ReadingResiduals::evaluate(const Place& place, double* residual, double* gradient) const {
    if (!prediction_)
        return false;
    const double predicted = prediction_->readings[place.reading];
    // The model's stem may just not reach the row: the reading then tells it nothing.
    const bool is_seen = !std::isnan(predicted);
    *residual = is_seen ? (predicted - place.measured) * place.inverse_noise : 0.0;
    if (gradient == nullptr)
        return true;
    for (std::size_t k = 0; k < internal_.size(); ++k) {
        const double derivative = prediction_->jacobian[place.reading * internal_.size() + k];
        gradient[k] = is_seen && std::isfinite(derivative)
                          ? derivative * natural_per_internal(k) * place.inverse_noise
                          : 0.0;
    }
    return true;
}

const ChainPrediction& ReadingResiduals::prediction() {
    PrepareForEvaluation(true, true);
    if (!prediction_)
        throw core::NumericalError(core::FailureKind::FitFailed, failure_);
    return *prediction_;
}

} // namespace culm::calibrate
