// SPDX-License-Identifier: BSD-3-Clause
// Products of the polynomials of several independent groups of inputs, up to a total degree.
#pragma once

#include "reduce/group_polynomials.hpp"
#include "reduce/sensitivity.hpp"

#include <cstddef>
#include <vector>

#include <Eigen/Core>

namespace culm::reduce {

class ChaosBasis {
  public:
    /// The largest total degree (at most 12) with no more than `most_terms` terms.
    ChaosBasis(const std::vector<InputGroup>& groups, std::size_t most_terms);

    [[nodiscard]] std::size_t terms() const { return terms_.size(); }
    [[nodiscard]] int degree() const { return static_cast<int>(terms_up_to_.size()) - 1; }
    /// Terms of total degree 0 … d; they come first.
    [[nodiscard]] std::size_t terms_up_to(int d) const {
        return terms_up_to_[static_cast<std::size_t>(d)];
    }
    /// Does the term contain the group? Does it contain no other?
    [[nodiscard]] bool contains(std::size_t term, std::size_t group) const {
        return terms_[term][group] > 0;
    }
    [[nodiscard]] bool is_of_one_group(std::size_t term) const;

    /// Values at points first … first + count − 1 of the groups: (count, terms).
    [[nodiscard]] Eigen::MatrixXd at_points(Eigen::Index first, Eigen::Index count) const;

  private:
    const std::vector<InputGroup>& groups_;
    std::vector<GroupPolynomials> polynomials_;
    /// For each term the function of each group, counted from 1; 0 is the constant.
    std::vector<std::vector<std::size_t>> terms_;
    std::vector<std::size_t> terms_up_to_;
};

} // namespace culm::reduce
