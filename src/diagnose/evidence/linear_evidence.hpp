// SPDX-License-Identifier: BSD-3-Clause
// Predicted log evidence of the models that add effects to a fitted one, without a fit.
#pragma once

#include "diagnose/evidence/effect_columns.hpp"
#include "diagnose/evidence/log_evidence.hpp"
#include "fit/linear/scaled_solve.hpp"

#include <map>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

namespace culm::diagnose {

/// A set of effects that may join the fitted model.
struct PredictedGain {
    double log_evidence = 0.0; ///< over that of the fitted model; −infinity: no allowed sizes
    std::vector<std::size_t> nodes;           ///< (effects) the likeliest point of each one's grid
    std::vector<std::vector<double>> amounts; ///< (effects)(columns of the node)
    std::vector<double> falls;                ///< (effects) of χ² by each alone
};

/// The candidates' columns without the part that the model's parameters imitate. A set with columns
/// S changes log Z by ½ bᵀ (G + I)⁻¹ b − ½ log|G + I| + log P(S), G = SᵀS, b = Sᵀ r.
class LinearEvidence {
  public:
    /// `candidates` may include failed ones.
    LinearEvidence(const fit::WeightedSystem& system, const std::vector<CandidateView>& candidates);

    /// From SᵀS and Sᵀr, summed over stems; the columns of `candidates` need no readings.
    /// own_change() is not available.
    LinearEvidence(const std::vector<EffectColumns>& candidates, Eigen::MatrixXd gram,
                   Eigen::VectorXd overlap);

    /// Sum over the points of the grids, which are equally probable; sizes with a forbidden sign
    /// are excluded. Two points of one grid together represent the points between them.
    [[nodiscard]] PredictedGain gain(std::span<const std::size_t> candidates) const;

    /// Change of the fitted numbers that accompanies the columns' amounts, with exact inputs.
    [[nodiscard]] Eigen::VectorXd own_change(std::span<const std::size_t> candidates,
                                             const PredictedGain& gain) const;

  private:
    struct Column {
        bool is_one_sided = false;
        bool is_certain = false;
        double largest = 0.0;
    };
    struct Node {
        std::vector<Eigen::Index> sizes;
        std::size_t first = 0;   ///< index among the candidate's nodes
        bool is_between = false; ///< two points of the grid: their amounts have one sign
    };
    struct Sum;

    void add_nodes(const EffectColumns& columns);
    void add(std::span<const std::size_t> candidates, std::vector<std::size_t>& chosen,
             Sum& sum) const;
    void add_point(std::span<const std::size_t> candidates, const std::vector<std::size_t>& chosen,
                   Sum& sum) const;
    [[nodiscard]] PredictedGain point(double log_value, std::span<const std::size_t> candidates,
                                      const std::vector<const Node*>& nodes,
                                      std::map<Eigen::Index, double>& amounts) const;
    [[nodiscard]] double solve(const std::vector<Eigen::Index>& sizes,
                               const std::vector<Eigen::Index>& certain,
                               std::map<Eigen::Index, double>& amounts) const;
    [[nodiscard]] const Column& column(Eigen::Index k) const {
        return columns_[static_cast<std::size_t>(k)];
    }

    std::optional<fit::Projector> own_;    ///< with all error terms
    std::optional<fit::Projector> fitted_; ///< of the fitted numbers alone
    std::vector<std::vector<Node>> nodes_; ///< (candidates)
    std::vector<Column> columns_;
    Eigen::MatrixXd raw_;     ///< (rows, columns)
    Eigen::MatrixXd gram_;    ///< (columns, columns) without what the parameters imitate
    Eigen::VectorXd overlap_; ///< (columns) with the residual
};

} // namespace culm::diagnose
