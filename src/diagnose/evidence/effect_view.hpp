// SPDX-License-Identifier: BSD-3-Clause
// What the readings of one fitted stem show of candidate effects.
//
// With the Jacobian J of the stem's own numbers (its parameters and error terms), the columns C of
// the candidates, then of the numbers that it shares with other stems, and the residual r,
//
//     coefficients = J⁺ C,   gram = C'ᵀ C',   overlap = C'ᵀ r,   C' = C − J J⁺ C:
//
// a fit of the stem's own numbers hides J J⁺ C, and C' is what it can detect (Frisch, Waugh and
// Lovell). Everything that a search asks about the candidates follows from these small matrices, so
// the readings do not travel.
#pragma once

#include "diagnose/evidence/effect_columns.hpp"
#include "diagnose/evidence/linear_evidence.hpp"
#include "diagnose/evidence/log_evidence.hpp"
#include "diagnose/models/sharing.hpp"

#include <string>
#include <vector>

#include <Eigen/Core>

namespace culm::diagnose {

struct EffectView {
    std::vector<EffectColumns> columns; ///< (candidates) without readings; some may have failed
    std::vector<std::string> shared;    ///< names of the shared numbers
    std::vector<double> shared_at;      ///< (shared) coordinates
    Eigen::MatrixXd gram;               ///< (all, all)
    Eigen::VectorXd overlap;            ///< (all)
    Eigen::MatrixXd coefficients;       ///< (own, columns of the candidates)

    /// Number of columns of the candidates.
    [[nodiscard]] Eigen::Index column_count() const;
    /// The first column of a candidate's node.
    [[nodiscard]] Eigen::Index first_column(std::size_t candidate, std::size_t node) const;
};

/// `candidates`: with readings, about the fit with this system.
[[nodiscard]] EffectView view_of(std::vector<EffectColumns> candidates,
                                 const SharedColumns& system);

} // namespace culm::diagnose
