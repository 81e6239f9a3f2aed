// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/evidence/stacked_readings.hpp"

#include "fit/model/parameter.hpp"
#include "fit/solve/residual_statistics.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/QR>

namespace culm::diagnose {
namespace {

/// Part of a column of unit length that the others cannot imitate. The derivatives come from lanes
/// that differ by 1e-6 of a parameter and are accurate to about 1e-5 (run/sensitivities.hpp); an
/// independent part below a tenth of that is rounding error.
constexpr double least_independence = 1e-6;

/// The readings of `models`, each with its prediction(m), and the constraints of the error terms.
StackedReadings stack(const fit::Fit& base, std::span<const fit::ObservedRecording> recordings,
                      std::span<const fit::StemModel> models, const auto& prediction_of) {
    const fit::JointLayout layout = fit::joint_layout(models, recordings);
    const auto is_error = [&](const fit::JointLayout::Owner& owner) {
        return models[owner.model].is_error(owner.parameter);
    };
    StackedReadings out;
    out.ids = layout.ids;
    out.constraints = static_cast<Eigen::Index>(std::ranges::count_if(layout.owners, is_error));
    Eigen::Index rows = out.constraints;
    for (const fit::RecordingFit& part : base.parts)
        rows += static_cast<Eigen::Index>(part.residuals.size());
    out.jacobian = Eigen::MatrixXd::Zero(rows, static_cast<Eigen::Index>(out.ids.size()));
    out.residual = Eigen::VectorXd::Zero(rows);
    out.predicted = Eigen::VectorXd::Zero(rows);
    Eigen::Index row = 0;
    for (std::size_t m = 0; m < models.size(); ++m) {
        const fit::ChainPrediction& prediction = prediction_of(m);
        const Eigen::Index first = row;
        for (std::size_t k = 0; k < prediction.readings.size(); ++k, ++row) {
            const std::size_t j = k % prediction.rows;
            const double measured = recordings[m].deflection(k / prediction.rows, j);
            const double predicted = prediction.readings[k];
            if (!std::isfinite(measured) || !std::isfinite(predicted))
                continue;
            const double noise = base.parts[m].noise[j];
            out.residual(row) = (measured - predicted) / noise;
            out.predicted(row) = predicted / noise;
            for (std::size_t p = 0; p < prediction.parameters; ++p) {
                const fit::JointLayout::Share& share = layout.shares[m][p];
                if (const double d = prediction.jacobian[k * prediction.parameters + p];
                    std::isfinite(d))
                    out.jacobian(row, static_cast<Eigen::Index>(share.place)) =
                        share.factor * (d / noise);
            }
        }
        if (!base.parts[m].noise_model)
            continue;
        const fit::Whitening whitening = fit::whitening_of(base.parts[m]);
        const auto count = static_cast<std::size_t>(row - first);
        whitening.apply({out.residual.data() + first, count});
        whitening.apply({out.predicted.data() + first, count});
        for (Eigen::Index k = 0; k < out.jacobian.cols(); ++k)
            whitening.apply({out.jacobian.col(k).data() + first, count});
    }
    for (std::size_t k = 0; k < layout.owners.size(); ++k) {
        const fit::JointLayout::Owner& owner = layout.owners[k];
        if (!is_error(owner))
            continue;
        out.jacobian(row, static_cast<Eigen::Index>(k)) = 1.0;
        out.residual(row++) = -models[owner.model].value(owner.parameter);
    }
    return out;
}

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
    return stack(base, recordings, models, [&](std::size_t m) {
        return fit::predict_readings(models[m], base.parts[m].times, heartbeat);
    });
}

StackedReadings stacked_readings(const fit::Fit& base,
                                 std::span<const fit::ObservedRecording> recordings) {
    return stack(
        base, recordings, fit::start_from(base),
        [&](std::size_t m) -> const fit::ChainPrediction& { return base.parts[m].prediction; });
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

namespace {

/// Of one run; `predictions` of its recordings.
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

} // namespace

std::vector<Eigen::VectorXd> readings_together(const std::vector<fit::StartModels>& runs,
                                               const StackedReadings& like, const fit::Fit& base,
                                               const run::Heartbeat& heartbeat) {
    std::vector<std::vector<fit::ChainPrediction>> by_run(runs.size());
    for (std::size_t m = 0; m < base.parts.size(); ++m) {
        std::vector<fit::StemModel> models;
        for (const fit::StartModels& run : runs)
            models.push_back(run[m]);
        std::vector<fit::ChainPrediction> predictions =
            fit::predict_together(models, base.parts[m].times, heartbeat);
        for (std::size_t k = 0; k < runs.size(); ++k)
            by_run[k].push_back(std::move(predictions[k]));
    }
    std::vector<Eigen::VectorXd> readings;
    for (const std::vector<fit::ChainPrediction>& predictions : by_run)
        readings.push_back(stacked_predictions(predictions, like, base));
    return readings;
}

} // namespace culm::diagnose
