// SPDX-License-Identifier: BSD-3-Clause
#include "reduce/chaos_basis.hpp"

#include <algorithm>

namespace culm::reduce {

namespace {

constexpr int most_degrees = 12;

using Degrees = std::vector<std::size_t>;

/// Appends the terms whose degrees of the groups from `group` on add up to `degree`; stops when
/// there are more than `most`.
void append_terms(const std::vector<GroupPolynomials>& polynomials, std::size_t group, int degree,
                  std::size_t most, Degrees& term, std::vector<Degrees>& terms) {
    if (terms.size() > most)
        return;
    if (group == polynomials.size()) {
        if (degree == 0)
            terms.push_back(term);
        return;
    }
    append_terms(polynomials, group + 1, degree, most, term, terms);
    const std::vector<int>& degrees = polynomials[group].degrees();
    for (std::size_t k = 0; k < degrees.size() && degrees[k] <= degree; ++k) {
        term[group] = k + 1;
        append_terms(polynomials, group + 1, degree - degrees[k], most, term, terms);
    }
    term[group] = 0;
}

} // namespace

ChaosBasis::ChaosBasis(const std::vector<InputGroup>& groups, std::size_t most_terms)
    : groups_(groups) {
    // A group of several inputs alone must not have more functions than there may be terms.
    for (const InputGroup& group : groups) {
        const auto inputs = static_cast<std::size_t>(group.nodes.cols());
        int degree = 0;
        std::size_t functions = 1; // binomial(degree + inputs, inputs)
        while (degree < most_degrees) {
            const auto next = static_cast<std::size_t>(degree) + 1;
            functions = functions * (next + inputs) / next;
            if (functions > most_terms)
                break;
            ++degree;
        }
        polynomials_.emplace_back(group.nodes, group.weights, degree);
    }
    for (int degree = 0; degree <= most_degrees; ++degree) {
        std::vector<Degrees> more = terms_;
        Degrees term(groups.size(), 0);
        append_terms(polynomials_, 0, degree, most_terms, term, more);
        if (more.size() > most_terms || (degree > 0 && more.size() == terms_.size()))
            break;
        terms_ = std::move(more);
        terms_up_to_.push_back(terms_.size());
    }
}

bool ChaosBasis::is_of_one_group(std::size_t term) const {
    return std::ranges::count_if(terms_[term], [](std::size_t k) { return k > 0; }) == 1;
}

Eigen::MatrixXd ChaosBasis::at_points(Eigen::Index first, Eigen::Index count) const {
    std::vector<Eigen::MatrixXd> functions;
    functions.reserve(groups_.size());
    for (std::size_t g = 0; g < groups_.size(); ++g)
        functions.push_back(polynomials_[g].at(groups_[g].values.middleRows(first, count)));
    Eigen::MatrixXd values = Eigen::MatrixXd::Ones(count, static_cast<Eigen::Index>(terms_.size()));
    for (std::size_t k = 0; k < terms_.size(); ++k)
        for (std::size_t g = 0; g < groups_.size(); ++g)
            if (terms_[k][g] > 0)
                values.col(static_cast<Eigen::Index>(k)).array() *=
                    functions[g].col(static_cast<Eigen::Index>(terms_[k][g] - 1)).array();
    return values;
}

} // namespace culm::reduce
