// SPDX-License-Identifier: BSD-3-Clause
// Predicted log evidence of the models that add effects to a fitted one, without a fit.
#pragma once

#include "diagnose/evidence/effect_columns.hpp"
#include "diagnose/evidence/log_evidence.hpp"

#include <map>
#include <span>
#include <utility>
#include <vector>

#include <Eigen/Core>

namespace culm::diagnose {

/// One effect at a point of its grid, or between two points.
struct PlacedEffect {
    std::size_t node = 0;        ///< of the grid
    std::size_t other = 0;       ///< the second point; the same: none
    double share = 0.0;          ///< of the second point
    std::vector<double> amounts; ///< (columns of the node); between two points their sum
    double fall = 0.0;           ///< of χ² by this effect alone

    [[nodiscard]] std::size_t nearest() const { return share > 0.5 ? other : node; }
};

/// Effects that join the fitted model, each at a point of its grid.
struct PredictedPoint {
    double log_value = 0.0; ///< log evidence there over that of the fitted model
    std::vector<PlacedEffect> effects;
};

/// A set of effects that may join the fitted model.
struct PredictedGain {
    double log_evidence = 0.0; ///< over that of the fitted model; −infinity: no allowed sizes
    std::vector<PredictedPoint> points; ///< the likeliest ones, the best first
};

/// Calls visit(set) for the sets of at most `room` of the numbers 0 … count − 1, in the order of
/// their names in a dictionary; false: no set that begins with this one is visited.
template <class Visit>
void for_each_set(std::size_t count, std::size_t room, const Visit& visit,
                  std::vector<std::size_t> set = {}) {
    if (set.size() == room)
        return;
    for (std::size_t k = set.empty() ? 0 : set.back() + 1; k < count; ++k) {
        std::vector<std::size_t> larger = set;
        larger.push_back(k);
        if (visit(larger))
            for_each_set(count, room, visit, std::move(larger));
    }
}

/// The candidates' columns without the part that the model's parameters imitate. A set with columns
/// S changes log Z by ½ bᵀ (G + I)⁻¹ b − ½ log|G + I| + log P(S), G = SᵀS, b = Sᵀ r.
class LinearEvidence {
  public:
    /// From G and b. The columns of the candidates, which may include failed ones, need no
    /// readings.
    LinearEvidence(const std::vector<EffectColumns>& candidates, Eigen::MatrixXd gram,
                   Eigen::VectorXd overlap);

    /// Sum over the points of the grids, which are equally probable; sizes with a forbidden sign
    /// are excluded. Two points of one grid together represent the points between them.
    [[nodiscard]] PredictedGain gain(std::span<const std::size_t> candidates) const;

  private:
    struct Column {
        bool is_one_sided = false;
        bool is_certain = false;
        double largest = 0.0;
    };
    struct Node {
        std::vector<Eigen::Index> sizes;
        std::size_t first = 0;   ///< index among the candidate's nodes
        std::size_t second = 0;  ///< of a node between two; else the same
        bool is_between = false; ///< two points of the grid: their amounts have one sign
    };
    struct Sum;

    void add_nodes(const EffectColumns& columns);
    void add(std::span<const std::size_t> candidates, std::vector<std::size_t>& chosen,
             Sum& sum) const;
    void add_point(std::span<const std::size_t> candidates, const std::vector<std::size_t>& chosen,
                   Sum& sum) const;
    [[nodiscard]] PredictedPoint point(double log_value, const std::vector<const Node*>& nodes,
                                       std::map<Eigen::Index, double>& amounts) const;
    [[nodiscard]] double solve(const std::vector<Eigen::Index>& sizes,
                               const std::vector<Eigen::Index>& certain,
                               std::map<Eigen::Index, double>& amounts) const;
    [[nodiscard]] const Column& column(Eigen::Index k) const {
        return columns_[static_cast<std::size_t>(k)];
    }

    std::vector<std::vector<Node>> nodes_; ///< (candidates)
    std::vector<Column> columns_;
    Eigen::MatrixXd gram_;    ///< (columns, columns) without what the parameters imitate
    Eigen::VectorXd overlap_; ///< (columns) with the residual
};

} // namespace culm::diagnose
