// SPDX-License-Identifier: BSD-3-Clause
#include "reduce/group_polynomials.hpp"

#include <cmath>
#include <cstddef>

namespace culm::reduce {

namespace {

using Eigen::Index;

/// Exponents of all monomials of `inputs` variables of exactly this degree.
void append_exponents(Index inputs, int degree, std::vector<int>& prefix,
                      std::vector<std::vector<int>>& all) {
    if (static_cast<Index>(prefix.size()) == inputs - 1) {
        all.push_back(prefix);
        all.back().push_back(degree);
        return;
    }
    for (int first = degree; first >= 0; --first) {
        prefix.push_back(first);
        append_exponents(inputs, degree - first, prefix, all);
        prefix.pop_back();
    }
}

} // namespace

GroupPolynomials::GroupPolynomials(const Eigen::MatrixXd& nodes, const Eigen::VectorXd& weights,
                                   int largest_degree) {
    centre_ = weights.transpose() * nodes;
    const Eigen::MatrixXd centred = nodes.rowwise() - centre_;
    scale_ = (weights.transpose() * centred.cwiseAbs2()).cwiseSqrt();
    for (double& scale : scale_)
        scale = scale > 0.0 ? scale : 1.0;
    std::vector<int> monomial_degrees;
    for (int degree = 0; degree <= largest_degree; ++degree) {
        std::vector<int> prefix;
        append_exponents(nodes.cols(), degree, prefix, exponents_);
        monomial_degrees.resize(exponents_.size(), degree);
    }
    // Gram-Schmidt, each step twice: orthogonal to rounding for any set of monomials (Giraud et al.
    // 2005). What is left of a monomial below this share of it is rounding.
    constexpr double independent_share = 1e-8;
    const Eigen::VectorXd roots = weights.cwiseSqrt();
    const Eigen::MatrixXd raw = roots.asDiagonal() * monomials(nodes);
    const Index count = raw.cols();
    Eigen::MatrixXd basis(raw.rows(), count);
    Eigen::MatrixXd recipes = Eigen::MatrixXd::Zero(count, count);
    Index kept = 0;
    for (Index k = 0; k < count; ++k) {
        Eigen::VectorXd column = raw.col(k);
        Eigen::VectorXd recipe = Eigen::VectorXd::Unit(count, k);
        const double norm = column.norm();
        for (int pass = 0; pass < 2; ++pass) {
            const Eigen::VectorXd along = basis.leftCols(kept).transpose() * column;
            column -= basis.leftCols(kept) * along;
            recipe -= recipes.leftCols(kept) * along;
        }
        const double rest = column.norm();
        if (!(rest > independent_share * norm))
            continue;
        basis.col(kept) = column / rest;
        recipes.col(kept) = recipe / rest;
        if (kept > 0)
            degrees_.push_back(monomial_degrees[static_cast<std::size_t>(k)]);
        ++kept;
    }
    coefficients_ = recipes.middleCols(1, kept - 1);
}

Eigen::MatrixXd GroupPolynomials::monomials(const Eigen::MatrixXd& places) const {
    const Eigen::MatrixXd standard =
        (places.rowwise() - centre_).array().rowwise() / scale_.array();
    Eigen::MatrixXd values =
        Eigen::MatrixXd::Ones(places.rows(), static_cast<Index>(exponents_.size()));
    for (Index k = 0; k < values.cols(); ++k)
        for (Index input = 0; input < places.cols(); ++input)
            for (int power = 0;
                 power < exponents_[static_cast<std::size_t>(k)][static_cast<std::size_t>(input)];
                 ++power)
                values.col(k).array() *= standard.col(input).array();
    return values;
}

Eigen::MatrixXd GroupPolynomials::at(const Eigen::MatrixXd& places) const {
    return monomials(places) * coefficients_;
}

} // namespace culm::reduce
