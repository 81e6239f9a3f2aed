// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/evidence/estimated_starts.hpp"

#include "fit/linear/layout.hpp"
#include "fit/linear/scaled_solve.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <iterator>
#include <string>
#include <tuple>

namespace culm::diagnose {
namespace {

/// Share of the way to the likeliest estimate at which a fit may begin, too.
constexpr double shorter_share = 0.25;

/// Are the amounts those of the model without the effect?
bool is_absent_at(const EffectNode& node, const std::vector<double>& amounts) {
    return !node.columns.front().is_certain &&
           std::ranges::all_of(amounts, [](double amount) { return amount == 0.0; });
}

/// Position on the way from the model without the effect to the node, as a fraction.
double way_to(const EffectNode& node, const std::vector<double>& amounts) {
    if (is_absent_at(node, amounts))
        return 0.0;
    if (node.has_offset())
        return amounts.front();
    const double secant = node.columns.front().secant;
    return secant == 0.0 ? 1.0 : amounts.front() / secant;
}

/// Size `k` among the effect's parameters, as a coordinate; `value` if the node has no column for
/// it. If recordings have separate sizes, each has its own column.
double size_of(const EffectNode& node, const std::vector<double>& amounts, std::size_t k,
               std::size_t recording, const ParameterPrior& prior, double value) {
    const bool has_own = std::ranges::count(node.columns, k, &EffectColumn::parameter) > 1;
    double coordinate = prior.absent;
    std::size_t seen = 0;
    for (std::size_t c = 0; c < node.columns.size(); ++c) {
        if (node.columns[c].parameter != k)
            continue;
        if (!has_own || seen == recording)
            coordinate += amounts[c] * prior.deviation;
        ++seen;
    }
    return seen > 0 ? coordinate : value;
}

/// A location, angle or time constant between two points of the grid.
double place_between(const fit::FreeParameter& parameter, double first, double second,
                     double share) {
    if (share == 0.0 || first == second)
        return first;
    if (parameter.is_phase)
        return std::arg(std::polar(1.0 - share, first) + std::polar(share, second));
    return fit::from_coordinate(parameter.fitted_as,
                                (1.0 - share) * fit::to_coordinate(parameter.fitted_as, first) +
                                    share * fit::to_coordinate(parameter.fitted_as, second));
}

/// Models at or on the way to the linear estimate with some effects.
class EstimatedStarts {
  public:
    EstimatedStarts(const LinearisedStem& base, const std::vector<std::size_t>& chosen)
        : base_(base), chosen_(chosen), fitted_(fit::start_from(base.fit)),
          layout_(fit::joint_layout(fitted_, base.recordings)) {
        std::tie(lower_, upper_) = fit::bounds_of(fitted_, layout_);
        const Eigen::MatrixXd own = base.columns.system.jacobian(Eigen::all, base.columns.own);
        normal_ = own.transpose() * own;
        right_ = own.transpose() * base.columns.system.residual;
        for (std::size_t k = 0; k < base.columns.own.size(); ++k)
            if (base.columns.own[k] < base.columns.system.fitted)
                moving_.push_back(static_cast<Eigen::Index>(k));
    }

    /// The point with the sizes that explain most while no parameter leaves its bounds.
    [[nodiscard]] PredictedPoint within_bounds(PredictedPoint point) const {
        const Eigen::Index own = normal_.cols();
        const Eigen::MatrixXd ways = ways_of(point);
        const Eigen::Index all = own + ways.cols();
        Eigen::VectorXd lower = Eigen::VectorXd::Constant(all, -no_limit);
        Eigen::VectorXd upper = Eigen::VectorXd::Constant(all, no_limit);
        for (const Eigen::Index k : moving_) {
            lower(k) = lower_(column(k));
            upper(k) = upper_(column(k));
        }
        std::vector<double*> amounts;
        Eigen::VectorXd precisions(ways.cols());
        Eigen::VectorXd means(ways.cols());
        Eigen::Index at = own;
        for (std::size_t e = 0; e < chosen_.size(); ++e)
            for (std::size_t k = 0; k < point.effects[e].amounts.size(); ++k, ++at) {
                const EffectColumn& of = node(e, point.effects[e].node).columns[k];
                const double largest = of.is_certain ? 1.0 : of.largest_amount();
                lower(at) = of.is_certain ? 1.0 : of.is_one_sided ? 0.0 : -largest;
                upper(at) = largest;
                precisions(at - own) = of.known_precision;
                means(at - own) = of.known_amount;
                amounts.push_back(&point.effects[e].amounts[k]);
            }
        const Eigen::MatrixXd hidden = base_.view.coefficients * ways;
        const Eigen::MatrixXd across = normal_ * hidden;
        const Eigen::Index columns = ways.rows();
        Eigen::MatrixXd information(all, all);
        information << normal_, across, across.transpose(),
            ways.transpose() * base_.view.gram.topLeftCorner(columns, columns) * ways +
                hidden.transpose() * across;
        information.bottomRightCorner(ways.cols(), ways.cols()) += precisions.asDiagonal();
        Eigen::VectorXd right(all);
        right << right_, ways.transpose() * base_.view.overlap.head(columns) +
                             hidden.transpose() * right_ + precisions.cwiseProduct(means);
        const Eigen::VectorXd change = fit::bounded_minimum(information, right, lower, upper);
        for (std::size_t k = 0; k < amounts.size(); ++k)
            *amounts[k] = change(own + static_cast<Eigen::Index>(k));
        return point;
    }

    /// With this share of the sizes. Y and β keep the first mode: that of the base along a finite
    /// change, else that of the straight way.
    [[nodiscard]] fit::StartModels towards(const PredictedPoint& point, double share) const {
        for (std::size_t e = 0; e < chosen_.size(); ++e)
            if (keeps_first_mode(e, point.effects[e]))
                return at(point, share);
        return fit::in_valley([&](double part) { return at(point, part * share); },
                              fit::joint_layout(at(point, share), base_.recordings));
    }

  private:
    static constexpr double no_limit = 1e6; ///< of a pull

    [[nodiscard]] const EffectNode& node(std::size_t e, std::size_t at) const {
        return base_.view.columns[chosen_[e]].nodes[at];
    }
    /// Index in the system of a column of the stem.
    [[nodiscard]] Eigen::Index column(Eigen::Index own) const {
        return base_.columns.own[static_cast<std::size_t>(own)];
    }

    /// The directions of the amounts, (columns of the candidates, amounts).
    [[nodiscard]] Eigen::MatrixXd ways_of(const PredictedPoint& point) const {
        Eigen::Index count = 0;
        for (const PlacedEffect& effect : point.effects)
            count += std::ssize(effect.amounts);
        Eigen::MatrixXd ways = Eigen::MatrixXd::Zero(base_.view.column_count(), count);
        Eigen::Index at = 0;
        for (std::size_t e = 0; e < chosen_.size(); ++e) {
            const PlacedEffect& effect = point.effects[e];
            for (Eigen::Index k = 0; k < std::ssize(effect.amounts); ++k, ++at) {
                ways(base_.view.first_column(chosen_[e], effect.node) + k, at) +=
                    1.0 - effect.share;
                ways(base_.view.first_column(chosen_[e], effect.other) + k, at) += effect.share;
            }
        }
        return ways;
    }

    /// Along a finite change of one recording, Y and β change such that the first mode stays.
    /// (Several recordings have one material, and a beat has another frequency.)
    [[nodiscard]] bool keeps_first_mode(std::size_t e, const PlacedEffect& effect) const {
        const EffectNode& at = node(e, effect.node);
        return (at.columns.front().secant != 0.0 || at.has_offset()) &&
               base_.candidates[chosen_[e]].effect->dimensions < 3 && base_.recordings.size() == 1;
    }

    /// The model with effect number `e`.
    [[nodiscard]] fit::StemModel with_effect(const fit::StemModel& base, std::size_t e,
                                             const PlacedEffect& effect,
                                             std::size_t recording) const {
        const physics::SelectedEffect& candidate = base_.candidates[chosen_[e]];
        fit::StemModel model = candidate_model(base, {candidate}, base_.recordings[recording]);
        place_effect(candidate, base_.view.columns[chosen_[e]], effect, recording, model);
        if (keeps_first_mode(e, effect)) {
            fit::keep_first_mode(base.spec, model);
            return model;
        }
        const EffectNode& at = node(e, effect.node);
        const double share = way_to(at, effect.amounts);
        model.spec.stem.bond_youngs_modulus *= std::pow(at.modulus_ratio, share);
        model.spec.stem.bond_damping *= std::pow(at.damping_ratio, share);
        return model;
    }

    /// On the straight way: the base's parameters compensate the effects, with exact inputs.
    [[nodiscard]] fit::StartModels at(const PredictedPoint& point, double share) const {
        PredictedPoint part = point;
        std::vector<double> all;
        for (PlacedEffect& effect : part.effects)
            for (double& amount : effect.amounts) {
                amount *= share;
                all.push_back(amount);
            }
        const Eigen::Map<const Eigen::VectorXd> amounts(all.data(), std::ssize(all));
        const Eigen::VectorXd shown =
            normal_ * (base_.view.coefficients * (ways_of(point) * amounts));
        std::vector<Eigen::Index> places;
        for (const Eigen::Index k : moving_)
            places.push_back(column(k));
        Eigen::VectorXd change = Eigen::VectorXd::Zero(lower_.size());
        change(places) = fit::bounded_minimum(normal_(moving_, moving_), -shown(moving_),
                                              lower_(places), upper_(places));
        fit::StartModels models = fit::moved(fitted_, layout_, change);
        for (std::size_t e = 0; e < chosen_.size(); ++e)
            for (std::size_t m = 0; m < models.size(); ++m)
                models[m] = with_effect(models[m], e, part.effects[e], m);
        return models;
    }

    const LinearisedStem& base_;
    const std::vector<std::size_t>& chosen_;
    fit::StartModels fitted_;
    fit::JointLayout layout_;
    Eigen::VectorXd lower_; ///< (fitted numbers) of their changes
    Eigen::VectorXd upper_;
    Eigen::MatrixXd normal_;           ///< JᵀJ of the stem's own numbers
    Eigen::VectorXd right_;            ///< Jᵀr
    std::vector<Eigen::Index> moving_; ///< own numbers that a fit changes
};

} // namespace

void place_effect(const physics::SelectedEffect& candidate, const EffectColumns& columns,
                  const PlacedEffect& effect, std::size_t recording, fit::StemModel& model) {
    const EffectNode& node = columns.nodes[effect.node];
    const EffectNode& other = columns.nodes[effect.other];
    const std::string name = candidate.effect->name;
    std::vector<fit::FreeParameter> own;
    std::ranges::copy_if(model.parameters, std::back_inserter(own),
                         [&](const auto& each) { return each.access.id.effect == name; });
    // Between two phases the sum of the vectors is shorter than that of the lengths.
    std::vector<double> amounts = effect.amounts;
    for (std::size_t k = 0; k < own.size(); ++k)
        if (own[k].is_phase)
            for (double& amount : amounts)
                amount *= std::abs(std::polar(1.0 - effect.share, node.values[k]) +
                                   std::polar(effect.share, other.values[k]));
    for (std::size_t k = 0; k < own.size(); ++k) {
        const fit::FreeParameter& parameter = own[k];
        double value = place_between(parameter, node.values[k], other.values[k], effect.share);
        if (!parameter.is_place)
            value = fit::from_coordinate(
                parameter.fitted_as,
                size_of(node, amounts, k, recording, prior_of(parameter, model),
                        fit::to_coordinate(parameter.fitted_as, node.values[k])));
        else if (parameter.fitted_as == physics::FittedAs::Inverse)
            value /= way_to(node, amounts); // a compliance of 0 is a rigid clamp
        if (!std::isfinite(value))          // a stiffness without compliance
            value = parameter.upper;
        parameter.access.set(model.spec, std::clamp(value, parameter.lower, parameter.upper));
    }
}

std::vector<fit::StartModels> starts_to_estimate(const LinearisedStem& base,
                                                 const std::vector<std::size_t>& chosen,
                                                 const PredictedGain& gain) {
    const EstimatedStarts estimated(base, chosen);
    std::vector<fit::StartModels> starts;
    for (const PredictedPoint& point : gain.points)
        starts.push_back(estimated.towards(estimated.within_bounds(point), 1.0));
    const PredictedPoint likeliest = estimated.within_bounds(gain.points.front());
    starts.push_back(estimated.towards(likeliest, shorter_share));
    starts.push_back(estimated.towards(likeliest, 0.0));
    return starts;
}

} // namespace culm::diagnose
