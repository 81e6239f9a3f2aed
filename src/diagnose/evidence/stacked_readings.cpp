// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/evidence/stacked_readings.hpp"

#include "fit/model/parameter.hpp"
#include "fit/solve/residual_statistics.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/QR>

namespace culm::diagnose {
namespace {

/// Part of a column of unit length that the others cannot imitate. The derivatives come from lanes
/// that differ by 1e-6 of a parameter and are accurate to about 1e-5 (run/sensitivities.hpp); an
/// independent part below a tenth of that is rounding error.
constexpr double least_independence = 1e-6;

class Stack {
  public:
    Stack(const fit::Fit& base, std::span<const fit::ObservedRecording> recordings,
          std::span<const fit::StemModel> models)
        : base_(base), recordings_(recordings), models_(models) {}

    void make_room(const fit::JointLayout& layout) {
        layout_ = layout;
        out_.ids = layout.ids;
        Eigen::Index rows = 0;
        for (const fit::RecordingFit& part : base_.parts)
            rows += static_cast<Eigen::Index>(part.residuals.size());
        out_.constraints = static_cast<Eigen::Index>(std::ranges::count_if(
            layout.owners, [&](const auto& owner) { return is_error(owner); }));
        rows += out_.constraints;
        out_.jacobian = Eigen::MatrixXd::Zero(rows, static_cast<Eigen::Index>(out_.ids.size()));
        out_.residual = Eigen::VectorXd::Zero(rows);
        out_.predicted = Eigen::VectorXd::Zero(rows);
    }
    /// The constraints of the error terms.
    void add_constraints() {
        for (std::size_t k = 0; k < layout_.owners.size(); ++k) {
            const fit::JointLayout::Owner& owner = layout_.owners[k];
            if (!is_error(owner))
                continue;
            out_.jacobian(row_, static_cast<Eigen::Index>(k)) = 1.0;
            out_.residual(row_++) = -models_[owner.model].value(owner.parameter);
        }
    }
    void add_rows(std::size_t part, const fit::ChainPrediction& prediction) {
        const Eigen::Index first = row_;
        for (std::size_t k = 0; k < prediction.readings.size(); ++k, ++row_) {
            const std::size_t j = k % prediction.rows;
            const double measured = recordings_[part].deflection(k / prediction.rows, j);
            const double predicted = prediction.readings[k];
            if (!std::isfinite(measured) || !std::isfinite(predicted))
                continue;
            const double noise = base_.parts[part].noise[j];
            out_.residual(row_) = (measured - predicted) / noise;
            out_.predicted(row_) = predicted / noise;
            for (std::size_t p = 0; p < prediction.parameters; ++p)
                if (const double d = prediction.jacobian[k * prediction.parameters + p];
                    std::isfinite(d))
                    add_derivative(layout_.shares[part][p], d / noise);
        }
        whiten(part, first);
    }
    [[nodiscard]] StackedReadings take() { return std::move(out_); }

  private:
    /// The rows of a part from `first` on.
    void whiten(std::size_t part, Eigen::Index first) {
        if (!base_.parts[part].noise_model)
            return;
        const fit::Whitening whitening = fit::whitening_of(base_.parts[part]);
        const auto count = static_cast<std::size_t>(row_ - first);
        whitening.apply({out_.residual.data() + first, count});
        whitening.apply({out_.predicted.data() + first, count});
        for (Eigen::Index k = 0; k < out_.jacobian.cols(); ++k)
            whitening.apply({out_.jacobian.col(k).data() + first, count});
    }
    [[nodiscard]] bool is_error(const fit::JointLayout::Owner& owner) const {
        return models_[owner.model].is_error(owner.parameter);
    }
    void add_derivative(const fit::JointLayout::Share& share, double derivative) {
        out_.jacobian(row_, static_cast<Eigen::Index>(share.place)) = share.factor * derivative;
    }

    const fit::Fit& base_;
    std::span<const fit::ObservedRecording> recordings_;
    std::span<const fit::StemModel> models_;
    StackedReadings out_;
    fit::JointLayout layout_;
    Eigen::Index row_ = 0;
};

/// Changes free parameter `k`, in its own unit, as far as the bounds allow.
void move(fit::StemModel& model, std::size_t k, double change) {
    if (model.is_error(k)) {
        model.set_value(k, model.value(k) + change);
        return;
    }
    if (k >= model.parameters.size()) {
        model.release_time = std::clamp(model.release_time + change,
                                        model.expected_release - model.release_time_bound,
                                        model.expected_release + model.release_time_bound);
        return;
    }
    const fit::FreeParameter& parameter = model.parameters[k];
    const double value = parameter.access.get(model.spec);
    const double internal = fit::to_internal(parameter, model.spec, value) +
                            change / fit::value_per_internal(parameter, model.spec, value);
    parameter.access.set(model.spec, std::clamp(fit::from_internal(parameter, model.spec, internal),
                                                parameter.lower, parameter.upper));
}

} // namespace

StackedReadings stacked_readings(std::span<const fit::StemModel> models,
                                 std::span<const fit::ObservedRecording> recordings,
                                 const fit::Fit& base, const run::Heartbeat& heartbeat) {
    Stack stack(base, recordings, models);
    stack.make_room(fit::joint_layout(models, recordings, fit::belongs_to_recording));
    for (std::size_t m = 0; m < models.size(); ++m)
        stack.add_rows(m, fit::predict_readings(models[m], base.parts[m].times, heartbeat));
    stack.add_constraints();
    return stack.take();
}

StackedReadings stacked_readings(const fit::Fit& base,
                                 std::span<const fit::ObservedRecording> recordings) {
    const fit::StartModels models = fit::start_from(base);
    Stack stack(base, recordings, models);
    stack.make_room(fit::joint_layout(models, recordings, fit::belongs_to_recording));
    for (std::size_t m = 0; m < base.parts.size(); ++m)
        stack.add_rows(m, base.parts[m].prediction);
    stack.add_constraints();
    return stack.take();
}

fit::StartModels moved(fit::StartModels models, const fit::JointLayout& layout,
                       const Eigen::VectorXd& change) {
    for (std::size_t m = 0; m < models.size(); ++m)
        for (std::size_t k = 0; k < layout.shares[m].size(); ++k) {
            const fit::JointLayout::Share& share = layout.shares[m][k];
            move(models[m], k, share.factor * change(static_cast<Eigen::Index>(share.place)));
        }
    return models;
}

Projector::Projector(const Eigen::MatrixXd& columns)
    : columns_(columns), scale_(columns.colwise().norm().transpose()) {
    for (double& entry : scale_)
        entry = entry > 0.0 ? entry : 1.0;
    solver_.setThreshold(least_independence);
    solver_.compute(columns * scale_.cwiseInverse().asDiagonal());
}

Eigen::MatrixXd Projector::coefficients(const Eigen::MatrixXd& wanted) const {
    if (columns_.isZero(0.0)) // nothing moves: the solver would divide by zero
        return Eigen::MatrixXd::Zero(columns_.cols(), wanted.cols());
    return scale_.cwiseInverse().asDiagonal() * Eigen::MatrixXd(solver_.solve(wanted));
}

Eigen::MatrixXd Projector::remainder(const Eigen::MatrixXd& wanted) const {
    return wanted - columns_ * coefficients(wanted);
}

Eigen::VectorXd stacked_predictions(std::span<const fit::ChainPrediction> predictions,
                                    const StackedReadings& like, const fit::Fit& base) {
    Eigen::VectorXd out = Eigen::VectorXd::Zero(like.residual.size());
    Eigen::Index row = 0;
    for (std::size_t m = 0; m < predictions.size(); ++m) {
        const Eigen::Index first = row;
        const fit::RecordingFit& part = base.parts[m];
        for (std::size_t k = 0; k < predictions[m].readings.size(); ++k, ++row)
            if (std::isfinite(predictions[m].readings[k]) && std::isfinite(part.residuals[k]))
                out(row) = predictions[m].readings[k] / part.noise[k % predictions[m].rows];
        if (part.noise_model)
            fit::whitening_of(part).apply(
                {out.data() + first, static_cast<std::size_t>(row - first)});
    }
    return out;
}

} // namespace culm::diagnose
