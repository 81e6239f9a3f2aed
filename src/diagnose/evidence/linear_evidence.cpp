// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/evidence/linear_evidence.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include <Eigen/Cholesky>

namespace culm::diagnose {
namespace {

constexpr Eigen::Index most_columns = 24; ///< of one set: three effects, a few columns each
using SmallMatrix =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, most_columns, most_columns>;
using SmallVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, most_columns, 1>;

constexpr std::size_t most_points = 2; ///< from which a fit may begin

} // namespace

/// log Σ exp over the points of the grids, and the likeliest point.
struct LinearEvidence::Sum {
    double total = 0.0; ///< over exp(log evidence of the likeliest point)
    double points = 0.0;
    std::vector<PredictedPoint> likeliest; ///< the best first

    [[nodiscard]] double largest() const {
        return likeliest.empty() ? -std::numeric_limits<double>::infinity()
                                 : likeliest.front().log_value;
    }
};

LinearEvidence::LinearEvidence(const std::vector<EffectColumns>& candidates, Eigen::MatrixXd gram,
                               Eigen::VectorXd overlap)
    : gram_(std::move(gram)), overlap_(std::move(overlap)) {
    for (const EffectColumns& each : candidates)
        add_nodes(each);
}

void LinearEvidence::add_nodes(const EffectColumns& columns) {
    std::vector<Node>& nodes = nodes_.emplace_back();
    for (std::size_t k = 0; k < columns.nodes.size(); ++k) {
        Node& node = nodes.emplace_back();
        node.first = node.second = k;
        for (const EffectColumn& column : columns.nodes[k].columns) {
            node.sizes.push_back(static_cast<Eigen::Index>(columns_.size()));
            columns_.push_back({column.is_one_sided, column.is_certain, column.largest_amount()});
        }
    }
    // Between two points of the grid the readings are nearly the mean of those at the two points.
    const std::size_t points = nodes.size();
    for (std::size_t a = 0; a < points; ++a)
        for (std::size_t b = a + 1; b < points; ++b)
            if (nodes[a].sizes.size() == 1 && nodes[b].sizes.size() == 1)
                nodes.push_back({{nodes[a].sizes.front(), nodes[b].sizes.front()}, a, b, true});
}

PredictedGain LinearEvidence::gain(std::span<const std::size_t> candidates) const {
    Sum sum;
    std::vector<std::size_t> chosen;
    add(candidates, chosen, sum);
    PredictedGain gain{sum.largest(), std::move(sum.likeliest)};
    if (sum.total > 0.0)
        gain.log_evidence += std::log(sum.total / sum.points) +
                             static_cast<double>(candidates.size()) * log_prior_odds();
    return gain;
}

void LinearEvidence::add(std::span<const std::size_t> candidates, std::vector<std::size_t>& chosen,
                         Sum& sum) const {
    if (chosen.size() == candidates.size())
        return add_point(candidates, chosen, sum);
    const std::vector<Node>& nodes = nodes_[candidates[chosen.size()]];
    for (std::size_t k = 0; k < nodes.size(); ++k) {
        chosen.push_back(k);
        add(candidates, chosen, sum);
        chosen.pop_back();
    }
}

/// Amounts of the columns that maximise the posterior, and the logarithm of its integral.
double LinearEvidence::solve(const std::vector<Eigen::Index>& sizes,
                             const std::vector<Eigen::Index>& certain,
                             std::map<Eigen::Index, double>& amounts) const {
    double log_value = 0.0;
    SmallVector right = overlap_(sizes);
    for (const Eigen::Index f : certain) {
        amounts[f] = 1.0;
        right -= gram_(sizes, f);
        log_value += overlap_(f);
        for (const Eigen::Index g : certain)
            log_value -= 0.5 * gram_(f, g);
    }
    if (sizes.empty())
        return log_value;
    SmallMatrix hessian = gram_(sizes, sizes);
    hessian.diagonal().array() += 1.0;
    const Eigen::LLT<SmallMatrix> factors(hessian);
    SmallVector amount = factors.solve(right);
    // The step ends where the columns are no longer known to be linear.
    double step = 1.0;
    for (std::size_t k = 0; k < sizes.size(); ++k)
        step = std::min(step,
                        column(sizes[k]).largest / std::abs(amount(static_cast<Eigen::Index>(k))));
    log_value += right.dot(amount) * (step - 0.5 * step * step);
    const SmallMatrix lower = factors.matrixL();
    for (std::size_t k = 0; k < sizes.size(); ++k) {
        const auto at = static_cast<Eigen::Index>(k);
        amounts[sizes[k]] = step * amount(at);
        log_value -= std::log(lower(at, at));
        if (column(sizes[k]).is_one_sided)
            log_value += std::numbers::ln2;
    }
    return log_value;
}

void LinearEvidence::add_point(std::span<const std::size_t> candidates,
                               const std::vector<std::size_t>& chosen, Sum& sum) const {
    sum.points += 1.0;
    std::vector<Eigen::Index> sizes;
    std::vector<Eigen::Index> certain;
    std::vector<const Node*> nodes;
    for (std::size_t e = 0; e < candidates.size(); ++e) {
        nodes.push_back(&nodes_[candidates[e]][chosen[e]]);
        for (const Eigen::Index each : nodes.back()->sizes)
            (column(each).is_certain ? certain : sizes).push_back(each);
    }
    if (static_cast<Eigen::Index>(sizes.size()) > most_columns)
        return;
    // A size with the forbidden sign is set to absent, and the others are solved for again. With
    // several recordings, an effect may be absent from one of them.
    std::map<Eigen::Index, double> amounts;
    double log_value = 0.0;
    for (bool is_allowed = false; !is_allowed;) {
        amounts.clear();
        log_value = solve(sizes, certain, amounts);
        is_allowed = std::erase_if(sizes, [&](Eigen::Index each) {
                         return column(each).is_one_sided && amounts[each] < 0.0;
                     }) == 0;
        for (const Node* node : nodes) // has an effect lost all of its sizes?
            if (std::ranges::none_of(node->sizes, [&](Eigen::Index each) {
                    return column(each).is_certain || std::ranges::find(sizes, each) != sizes.end();
                }))
                return;
    }
    if (std::ranges::any_of(nodes, [&](const Node* node) {
            return node->is_between &&
                   amounts[node->sizes.front()] * amounts[node->sizes.back()] <= 0.0;
        }))
        return;
    const double largest = sum.largest();
    sum.total = log_value > largest ? sum.total * std::exp(largest - log_value) + 1.0
                                    : sum.total + std::exp(log_value - largest);
    const auto after = std::ranges::find_if(
        sum.likeliest, [&](const PredictedPoint& each) { return each.log_value < log_value; });
    sum.likeliest.insert(after, point(log_value, nodes, amounts));
    if (sum.likeliest.size() > most_points)
        sum.likeliest.pop_back();
}

PredictedPoint LinearEvidence::point(double log_value, const std::vector<const Node*>& nodes,
                                     std::map<Eigen::Index, double>& amounts) const {
    PredictedPoint out{log_value, {}};
    for (const Node* node : nodes) {
        PlacedEffect& effect = out.effects.emplace_back();
        effect.node = node->first;
        effect.other = node->second;
        // aᵀ G a of its columns is an upper bound of what it explains in addition to the others.
        for (const Eigen::Index i : node->sizes) {
            effect.amounts.push_back(amounts[i]);
            for (const Eigen::Index j : node->sizes)
                effect.fall += amounts[i] * gram_(i, j) * amounts[j];
        }
        if (node->is_between) {
            const double sum = effect.amounts.front() + effect.amounts.back();
            effect.share = effect.amounts.back() / sum;
            effect.amounts = {sum};
        }
    }
    return out;
}

} // namespace culm::diagnose
