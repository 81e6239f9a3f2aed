// SPDX-License-Identifier: BSD-3-Clause
#include "fit/linear/weighted_system.hpp"

#include "fit/noise/whitening.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>

namespace culm::fit {
namespace {

using Table =
    Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>;

ReadingWeights weights_of(const SystemPart& part) {
    std::vector<bool> is_seen;
    for (std::size_t at = 0; at < part.prediction.readings.size(); ++at)
        is_seen.push_back(std::isfinite(part.recording.deflections[at]) &&
                          std::isfinite(part.prediction.readings[at]));
    return {part.noise, part.recording.noise_model, std::move(is_seen)};
}

Eigen::Index size_of(const SystemPart& part) {
    return static_cast<Eigen::Index>(part.prediction.readings.size());
}

/// Fills the rows from `first` on.
void add(const SystemPart& part, const std::vector<JointLayout::Share>& shares, Eigen::Index first,
         WeightedSystem& out) {
    const ChainPrediction& prediction = part.prediction;
    const Eigen::Index rows = size_of(part);
    const ReadingWeights weights = weights_of(part);
    const auto put = [&](const auto& values, Eigen::Ref<Eigen::VectorXd> column) {
        column.segment(first, rows) = values;
        weights.apply({column.data() + first, static_cast<std::size_t>(rows)});
    };
    const Eigen::Map<const Eigen::VectorXd> predicted(prediction.readings.data(), rows);
    const Eigen::Map<const Eigen::VectorXd> measured(part.recording.deflections.data(), rows);
    put(predicted, out.predicted);
    put(measured - predicted, out.residual);
    const Table jacobian(prediction.jacobian.data(), rows,
                         static_cast<Eigen::Index>(prediction.parameters));
    for (Eigen::Index p = 0; p < jacobian.cols(); ++p) {
        const auto [place, factor] = shares[static_cast<std::size_t>(p)];
        put(factor * jacobian.col(p), out.jacobian.col(static_cast<Eigen::Index>(place)));
    }
}

/// The columns of the terms that are not fitted, each with the row of its constraint.
void add_terms(std::span<const SystemPart> parts, WeightedSystem& out) {
    std::vector<std::string> ids;
    for (const SystemPart& part : parts)
        for (const ErrorTerm& term : part.terms)
            if (std::ranges::find(ids, term.id) == ids.end()) {
                ids.push_back(term.id);
                out.ids.push_back({{}, term.id, {}});
                out.errors.emplace_back(term.kind);
            }
    const Eigen::Index rows = out.residual.size();
    const Eigen::Index columns = out.jacobian.cols();
    const Eigen::Index count = std::ssize(ids);
    out.jacobian.conservativeResizeLike(Eigen::MatrixXd::Zero(rows + count, columns + count));
    out.jacobian.bottomRightCorner(count, count).setIdentity();
    out.residual.conservativeResizeLike(Eigen::VectorXd::Zero(rows + count));
    out.predicted.conservativeResizeLike(Eigen::VectorXd::Zero(rows + count));
    out.constraints += count;
    Eigen::Index row = 0;
    for (const SystemPart& part : parts) {
        for (const ErrorTerm& term : part.terms)
            out.jacobian.col(columns + (std::ranges::find(ids, term.id) - ids.begin()))
                .segment(row, size_of(part)) = weighted_term(term, part);
        row += size_of(part);
    }
}

/// The rows of the parameters whose values are known.
void add_known(const JointLayout& layout, std::span<const SystemPart> parts, WeightedSystem& out) {
    for (std::size_t k = 0; k < layout.owners.size(); ++k) {
        const auto [m, place] = layout.owners[k];
        const StemModel& model = parts[m].model;
        if (place >= model.parameters.size() || !(model.parameters[place].known_within > 0.0))
            continue;
        const FreeParameter& parameter = model.parameters[place];
        const Eigen::Index row = out.residual.size();
        out.jacobian.conservativeResizeLike(Eigen::MatrixXd::Zero(row + 1, out.jacobian.cols()));
        out.residual.conservativeResizeLike(Eigen::VectorXd::Zero(row + 1));
        out.predicted.conservativeResizeLike(Eigen::VectorXd::Zero(row + 1));
        out.jacobian(row, static_cast<Eigen::Index>(k)) = 1.0 / parameter.known_within;
        out.residual(row) = (parameter.default_value - model.value(place)) / parameter.known_within;
        ++out.constraints;
    }
}

} // namespace

Eigen::Index WeightedSystem::column_of(const ErrorTerm& term) const {
    return std::find_if(ids.begin() + fitted, ids.end(),
                        [&](const physics::ParameterId& id) { return id.name == term.id; }) -
           ids.begin();
}

WeightedSystem weighted_system(const JointLayout& layout, std::span<const SystemPart> parts) {
    const auto is_error = [&](const JointLayout::Owner& owner) {
        return parts[owner.model].model.is_error(owner.parameter);
    };
    WeightedSystem out;
    out.ids = layout.ids;
    out.fitted = std::ssize(layout.ids);
    for (const JointLayout::Owner& owner : layout.owners) {
        const StemModel& model = parts[owner.model].model;
        out.errors.push_back(is_error(owner) ? std::optional(model.error_term(owner.parameter).kind)
                                             : std::nullopt);
    }
    out.constraints = static_cast<Eigen::Index>(std::ranges::count_if(layout.owners, is_error));
    Eigen::Index rows = out.constraints;
    for (const SystemPart& part : parts)
        rows += size_of(part);
    out.jacobian = Eigen::MatrixXd::Zero(rows, static_cast<Eigen::Index>(out.ids.size()));
    out.residual = Eigen::VectorXd::Zero(rows);
    out.predicted = Eigen::VectorXd::Zero(rows);
    Eigen::Index row = 0;
    for (std::size_t m = 0; m < parts.size(); ++m) {
        add(parts[m], layout.shares[m], row, out);
        row += size_of(parts[m]);
    }
    for (std::size_t k = 0; k < layout.owners.size(); ++k) {
        const JointLayout::Owner& owner = layout.owners[k];
        if (!is_error(owner))
            continue;
        out.jacobian(row, static_cast<Eigen::Index>(k)) = 1.0;
        out.residual(row++) = -parts[owner.model].model.value(owner.parameter);
    }
    add_terms(parts, out);
    add_known(layout, parts, out);
    return out;
}

Eigen::VectorXd weighted_readings(const SystemPart& part) {
    Eigen::VectorXd readings =
        Eigen::Map<const Eigen::VectorXd>(part.prediction.readings.data(), size_of(part));
    weights_of(part).apply({readings.data(), static_cast<std::size_t>(readings.size())});
    return readings;
}

Eigen::VectorXd weighted_term(const ErrorTerm& term, const SystemPart& part) {
    Eigen::VectorXd column = Eigen::VectorXd::Zero(size_of(part));
    if (term.readings.empty())
        return column;
    column = Eigen::Map<const Eigen::VectorXd>(term.readings.data(), column.size());
    weights_of(part).apply({column.data(), static_cast<std::size_t>(column.size())});
    return column;
}

} // namespace culm::fit
