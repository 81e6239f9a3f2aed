// SPDX-License-Identifier: BSD-3-Clause
#include "fit/solve/residuals.hpp"

#include "core/error.hpp"
#include "run/modes.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace culm::fit {

namespace {

/// Standard deviations. Values this far off are rejected by their cost, not by a bound.
constexpr double largest_error = 1e3;

constexpr double slope_share = 1e-3; ///< of the step, for its slope
constexpr int corrections = 3;       ///< f² is nearly a straight line in Y
constexpr double largest_correction = 2.0;

} // namespace

ReadingResiduals::ReadingResiduals(const StemModel& model, const ObservedRecording& measurement,
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
    if (!measurement.noise_model)
        return;
    std::vector<bool> is_seen(times_.size() * rows, false);
    for (const Place& place : places_)
        is_seen[place.reading] = true;
    whitening_.emplace(measurement.noise_model, rows, is_seen);
}

void ReadingResiduals::whiten() {
    const std::size_t count = prediction_->readings.size();
    const std::size_t parameters = prediction_->parameters;
    white_residuals_.assign(count, 0.0);
    white_jacobian_.assign(parameters * count, 0.0);
    for (const Place& place : places_) {
        const double predicted = prediction_->readings[place.reading];
        if (std::isnan(predicted))
            continue;
        white_residuals_[place.reading] = (predicted - place.measured) * place.inverse_noise;
        for (std::size_t k = 0; k < parameters; ++k)
            if (const double derivative = prediction_->jacobian[place.reading * parameters + k];
                std::isfinite(derivative))
                white_jacobian_[k * count + place.reading] = derivative * place.inverse_noise;
    }
    whitening_->apply(white_residuals_);
    for (std::size_t k = 0; k < parameters; ++k)
        whitening_->apply(std::span(white_jacobian_).subspan(k * count, count));
}

void ReadingResiduals::prepare(const std::vector<double>& values) {
    // Ceres evaluates the same point again for its Jacobian; one run gave both.
    if (is_prepared_ && values_ == values)
        return;
    is_prepared_ = true;
    values_ = values;
    prediction_.reset();
    try {
        ++runs_;
        prediction_ = predict_readings(current_model(), times_, heartbeat_);
        if (whitening_)
            whiten();
    } catch (const core::NumericalError& error) {
        failure_ = error.what();
    }
}

bool ReadingResiduals::evaluate(const Place& place, double* residual) const {
    if (!prediction_)
        return false;
    if (whitening_) {
        *residual = white_residuals_[place.reading];
        return true;
    }
    const double predicted = prediction_->readings[place.reading];
    // The model's stem may not quite reach the row; the reading then has no information on it.
    *residual = std::isnan(predicted) ? 0.0 : (predicted - place.measured) * place.inverse_noise;
    return true;
}

double ReadingResiduals::derivative(const Place& place, std::size_t parameter) const {
    if (whitening_)
        return white_jacobian_[parameter * prediction_->readings.size() + place.reading];
    const double derivative =
        prediction_->jacobian[place.reading * prediction_->parameters + parameter];
    const bool is_seen = !std::isnan(prediction_->readings[place.reading]);
    // Near the edge of the stem a lane may miss the row and then has no derivative.
    return is_seen && std::isfinite(derivative) ? derivative * place.inverse_noise : 0.0;
}

StemModel ReadingResiduals::current_model() const {
    StemModel current = model_;
    for (std::size_t k = 0; k < values_.size(); ++k)
        current.set_value(k, values_[k]);
    return current;
}

const ChainPrediction& ReadingResiduals::prediction() const {
    if (!prediction_)
        throw core::NumericalError(core::FailureKind::FitFailed, failure_);
    return *prediction_;
}

JointResiduals::JointResiduals(const std::vector<StemModel>& models, const JointLayout& layout,
                               std::vector<ReadingResiduals> parts)
    : models_(models), layout_(layout), parts_(std::move(parts)) {
    for (std::size_t k = 0; k < layout.ids.size(); ++k) {
        const StemModel& model = start(k);
        const double value = model.value(layout.owners[k].parameter);
        internal_.push_back(owner(k) != nullptr ? to_internal(*owner(k), model.spec, value)
                                                : (value - plain_centre(k)) / plain_scale(k));
    }
    per_internal_.resize(internal_.size());
}

const StemModel& JointResiduals::start(std::size_t parameter) const {
    return models_[layout_.owners[parameter].model];
}

const FreeParameter* JointResiduals::owner(std::size_t parameter) const {
    const std::vector<FreeParameter>& free = start(parameter).parameters;
    const std::size_t place = layout_.owners[parameter].parameter;
    return place < free.size() ? &free[place] : nullptr;
}

double JointResiduals::plain_scale(std::size_t parameter) const {
    return is_error(parameter) ? 1.0 : start(parameter).release_time_bound;
}

double JointResiduals::plain_centre(std::size_t parameter) const {
    return is_error(parameter) ? 0.0 : start(parameter).expected_release;
}

bool JointResiduals::is_error(std::size_t parameter) const {
    return start(parameter).is_error(layout_.owners[parameter].parameter);
}

double JointResiduals::value_of(std::size_t parameter, double internal) const {
    const FreeParameter* const free = owner(parameter);
    return free != nullptr ? from_internal(*free, start(parameter).spec, internal)
                           : plain_centre(parameter) + internal * plain_scale(parameter);
}

run::CaseSpec JointResiduals::case_at(const double* internal) const {
    const StemModel& model = models_.front();
    run::CaseSpec spec = model.spec;
    const std::vector<JointLayout::Share>& shares = layout_.shares.front();
    for (std::size_t k = 0; k < model.parameters.size(); ++k) {
        const std::size_t place = shares[k].place;
        const auto [lower, upper] = bounds(place);
        const double within = std::clamp(internal[place], lower, upper);
        model.parameters[k].access.set(spec, shares[k].factor * value_of(place, within));
    }
    return spec;
}

std::pair<double, double> JointResiduals::bounds(std::size_t parameter) const {
    const FreeParameter* const free = owner(parameter);
    if (free == nullptr)
        return is_error(parameter) ? std::pair(-largest_error, largest_error)
                                   : std::pair(-1.0, 1.0);
    const run::CaseSpec& spec = start(parameter).spec;
    return std::minmax(
        {to_internal(*free, spec, free->lower), to_internal(*free, spec, free->upper)});
}

// Ceres asks for each reading separately; the chains run here, once for all readings.
void JointResiduals::PrepareForEvaluation(bool, bool) {
    std::vector<double> joint;
    for (std::size_t k = 0; k < internal_.size(); ++k) {
        joint.push_back(value_of(k, internal_[k]));
        const FreeParameter* const free = owner(k);
        per_internal_[k] =
            free != nullptr ? value_per_internal(*free, start(k).spec, joint[k]) : plain_scale(k);
    }
    for (std::size_t part = 0; part < parts_.size(); ++part) {
        std::vector<double> values;
        for (const JointLayout::Share& share : layout_.shares[part])
            values.push_back(share.factor * joint[share.place]);
        parts_[part].prepare(values);
    }
}

bool JointResiduals::evaluate(std::size_t part, const ReadingResiduals::Place& place,
                              double* residual, double* gradient) const {
    const ReadingResiduals& own = parts_[part];
    if (!own.evaluate(place, residual))
        return false;
    if (gradient == nullptr)
        return true;
    std::fill_n(gradient, internal_.size(), 0.0);
    const std::vector<JointLayout::Share>& shares = layout_.shares[part];
    for (std::size_t k = 0; k < shares.size(); ++k)
        // Chain rule: the reading by the part's value, that by the joint value, that by Ceres's
        // number.
        gradient[shares[k].place] =
            own.derivative(place, k) * (shares[k].factor * per_internal_[shares[k].place]);
    return true;
}

ValleySteps::ValleySteps(const JointResiduals& residuals, const JointLayout& layout,
                         const std::vector<bool>& is_held)
    : residuals_(residuals), size_(residuals.parameter_count()) {
    for (std::size_t k = 0; k < size_; ++k)
        if (k >= is_held.size() || !is_held[k])
            free_.push_back(k);
    const auto found = std::ranges::find(layout.ids, physics::bond_youngs_modulus);
    const auto place = static_cast<std::size_t>(found - layout.ids.begin());
    if (found != layout.ids.end() && std::ranges::find(free_, place) != free_.end())
        modulus_ = place;
}

double ValleySteps::log_square(const std::vector<double>& internal) const {
    return 2.0 * std::log(run::lowest_frequency_with_effects(residuals_.case_at(internal.data())));
}

// The readings of N cycles lose their phase after a change of f by 1/N, while Y and an added mass
// or a soft clamp can change together by far more at the same f. So χ² is a curved valley whose
// walls are steep in f and whose floor is flat. A straight Gauss-Newton step leaves the floor and
// is shortened again and again. Here a step has the frequency of the straight step to first order:
// f² is proportional to Y except for the share of the other parameters, so ln f² is corrected by
// changes of ln Y.
void ValleySteps::follow_frequency(const std::vector<double>& point,
                                   std::vector<double>& moved) const {
    std::vector<double> ahead(size_);
    std::vector<double> behind(size_);
    for (std::size_t k = 0; k < size_; ++k) {
        ahead[k] = point[k] + slope_share * (moved[k] - point[k]);
        behind[k] = point[k] - slope_share * (moved[k] - point[k]);
    }
    // The frequency of the step to first order: a central difference along it.
    const double wanted =
        log_square(point) + (log_square(ahead) - log_square(behind)) / (2.0 * slope_share);
    const double straight = moved[*modulus_];
    for (int pass = 0; pass < corrections; ++pass) {
        const double missing = wanted - log_square(moved);
        if (!(std::abs(missing) < largest_correction)) { // no frequency to follow
            moved[*modulus_] = straight;
            return;
        }
        moved[*modulus_] += missing;
    }
}

bool ValleySteps::Plus(const double* point, const double* step, double* moved) const {
    std::vector<double> to(point, point + size_);
    for (std::size_t k = 0; k < free_.size(); ++k)
        to[free_[k]] += step[k];
    if (modulus_)
        follow_frequency({point, point + size_}, to);
    std::ranges::copy(to, moved);
    return true;
}

// To first order Plus() is the straight step, so its derivative is that of a linear subspace.
bool ValleySteps::PlusJacobian(const double*, double* jacobian) const {
    std::fill_n(jacobian, size_ * free_.size(), 0.0); // (ambient, tangent), row-major
    for (std::size_t k = 0; k < free_.size(); ++k)
        jacobian[free_[k] * free_.size() + k] = 1.0;
    return true;
}

bool ValleySteps::Minus(const double* moved, const double* point, double* step) const {
    for (std::size_t k = 0; k < free_.size(); ++k)
        step[k] = moved[free_[k]] - point[free_[k]];
    return true;
}

bool ValleySteps::MinusJacobian(const double*, double* jacobian) const {
    std::fill_n(jacobian, size_ * free_.size(), 0.0); // (tangent, ambient), row-major
    for (std::size_t k = 0; k < free_.size(); ++k)
        jacobian[k * size_ + free_[k]] = 1.0;
    return true;
}

} // namespace culm::fit
