// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/evidence/effect_view.hpp"

#include "fit/linear/scaled_solve.hpp"

#include <utility>

namespace culm::diagnose {
namespace {

/// Readings of all columns of the candidates, side by side, and those of the shared numbers.
Eigen::MatrixXd column_matrix(std::span<const EffectColumns> candidates, const SharedColumns& of) {
    const Eigen::Index rows = of.system.residual.size();
    Eigen::Index count = std::ssize(of.columns);
    for (const EffectColumns& each : candidates)
        count += each.column_count();
    Eigen::MatrixXd readings(rows, count);
    Eigen::Index k = 0;
    for (const EffectColumns& each : candidates)
        for (const EffectNode& node : each.nodes)
            for (const EffectColumn& column : node.columns)
                readings.col(k++) = column.readings;
    readings.rightCols(std::ssize(of.columns)) = of.system.jacobian(Eigen::all, of.columns);
    return readings;
}

} // namespace

Eigen::Index EffectView::column_count() const {
    return first_column(columns.size(), 0);
}

Eigen::Index EffectView::first_column(std::size_t candidate, std::size_t node) const {
    Eigen::Index first = 0;
    for (std::size_t c = 0; c < candidate; ++c)
        first += columns[c].column_count();
    for (std::size_t n = 0; n < node; ++n)
        first += std::ssize(columns[candidate].nodes[n].columns);
    return first;
}

EffectView view_of(std::vector<EffectColumns> candidates, const SharedColumns& of) {
    EffectView view;
    view.shared = of.names;
    view.shared_at = of.at;
    const Eigen::MatrixXd columns = column_matrix(candidates, of);
    const fit::Projector own(of.system.jacobian(Eigen::all, of.own));
    const Eigen::MatrixXd coefficients = own.coefficients(columns);
    const Eigen::MatrixXd remainder = own.remainder(columns, coefficients);
    Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(columns.cols(), columns.cols());
    gram.selfadjointView<Eigen::Lower>().rankUpdate(remainder.transpose());
    view.gram = gram.selfadjointView<Eigen::Lower>();
    view.overlap = remainder.transpose() * own.remainder(of.system.residual);
    view.coefficients = coefficients.leftCols(columns.cols() - std::ssize(of.columns));
    for (EffectColumns& candidate : candidates)
        for (EffectNode& node : candidate.nodes)
            for (EffectColumn& column : node.columns)
                column.readings.resize(0);
    view.columns = std::move(candidates);
    return view;
}

} // namespace culm::diagnose
