// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/detection_limits.hpp"

#include "core/order_statistics.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <optional>

namespace culm::diagnose {
namespace {

constexpr double detected_at = 3.0; ///< standard deviations of the noise
constexpr auto no_parameter = std::numeric_limits<std::size_t>::max();

/// Where a node's column is, and what it shows.
struct SeenColumn {
    const EffectNode* node = nullptr;
    const EffectColumn* column = nullptr;
    Eigen::Index place = 0; ///< in the view
    double length = 0.0;    ///< of the part that the model cannot imitate, for a size of 1
};

/// The column by which the effect is seen best: from where it is absent to a usual size, if that
/// was computed, because derivatives may vanish where the effect is absent.
struct Signature : SeenColumn {
    double slope = 0.0; ///< as `length`, of the derivative, if there is a secant too

    /// Size at which the signature reaches detected_at: a s + b s² from derivative and secant, a
    /// straight line if it grows more slowly than that.
    [[nodiscard]] double size() const {
        const double usual = std::abs(column->secant);
        const double curvature = usual > 0.0 ? (length - slope) / usual : 0.0;
        const double size =
            curvature > 0.0 ? 2.0 * detected_at /
                                  (slope + std::sqrt(slope * slope + 4.0 * curvature * detected_at))
                            : detected_at / length;
        return column->secant < 0.0 ? -size : size;
    }
};

std::vector<SeenColumn> columns_of(const EffectView& view, std::size_t candidate) {
    std::vector<SeenColumn> columns;
    const EffectColumns& of = view.columns[candidate];
    Eigen::Index place = view.first_column(candidate, 0);
    for (const EffectNode& node : of.nodes)
        for (const EffectColumn& column : node.columns) {
            columns.push_back({&node, &column, place, std::sqrt(view.gram(place, place))});
            ++place;
        }
    return columns;
}

/// For an effect whose location alone changes the model: the derivative by its size where the
/// location changes least. Empty for other effects.
std::optional<Signature> signature_beside_offset(const std::vector<SeenColumn>& columns) {
    std::optional<Signature> out;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k + 1 < columns.size(); ++k) {
        const SeenColumn& offset = columns[k];
        const SeenColumn& next = columns[k + 1];
        if (offset.column == &offset.node->columns.front() && offset.node->has_offset() &&
            next.node == offset.node && offset.length < least) {
            least = offset.length;
            out = {next, 0.0};
        }
    }
    return out;
}

Signature signature_of(const std::vector<SeenColumn>& columns) {
    if (const auto beside = signature_beside_offset(columns))
        return *beside;
    Signature out;
    std::map<std::size_t, double> slopes; // by parameter
    for (const SeenColumn& each : columns) {
        const EffectColumn& column = *each.column;
        if (!column.is_certain && column.parameter == no_parameter)
            continue;
        const bool is_secant = column.secant != 0.0;
        if (!is_secant)
            slopes[column.parameter] = std::max(slopes[column.parameter], each.length);
        const bool has_secant = out.column != nullptr && out.column->secant != 0.0;
        if (is_secant == has_secant ? each.length > out.length : is_secant)
            out = {each, 0.0};
    }
    if (out.column != nullptr && out.column->secant != 0.0)
        out.slope = slopes[out.column->parameter];
    return out;
}

/// Relative bias of a parameter fitted without the effect, which changes the fitted parameters by
/// `hidden_by`; the truth is `ratio` times as large.
double bias(const fit::Fit& best, const Eigen::VectorXd& hidden_by, const physics::ParameterId& id,
            double ratio) {
    const auto found = std::ranges::find(best.parameters, id, &fit::FittedParameter::id);
    if (found == best.parameters.end() || !(ratio > 0.0))
        return 0.0;
    const double per_value = fit::coordinate_slope(found->fitted_as, found->value) * found->value;
    return (1.0 + hidden_by(found - best.parameters.begin()) / per_value) / ratio - 1.0;
}

/// Sets the parameter, its unit and value for a size in standard deviations of the prior.
void name(const fit::StemModel& model, const physics::SelectedEffect& effect,
          const EffectColumn& column, double size, DetectionLimit& limit) {
    std::size_t own = 0;
    for (const fit::FreeParameter& each : model.parameters)
        if (each.access.id.effect == limit.effect && own++ == column.parameter) {
            limit.parameter = each.access.id.name;
            limit.unit = each.unit;
            limit.value =
                fit::from_coordinate(each.fitted_as, column.absent + size * column.deviation);
            limit.is_beyond_bounds = !(limit.value >= each.lower && limit.value <= each.upper);
        }
    if (!limit.parameter.empty())
        return;
    // For an effect without a free parameter, the largest of its known values gives the size.
    const std::vector<double>& values = model.spec.effects.back().values;
    const auto largest =
        std::ranges::max_element(values, {}, [](double value) { return std::abs(value); });
    if (largest == values.end())
        return;
    const physics::EffectParameter& known =
        effect.effect->parameters[static_cast<std::size_t>(largest - values.begin())];
    limit.parameter = known.name;
    limit.unit = known.unit;
    limit.value = size * std::abs(*largest);
    limit.is_beyond_bounds = !(limit.value <= known.upper);
}

DetectionLimit limit_of(const SearchResult& search, const fit::StemModel& best, std::size_t c) {
    const physics::SelectedEffect& effect = search.stems->options().candidates[c];
    const EffectView& view = search.about->view(0);
    DetectionLimit limit;
    limit.effect = effect.effect->name;
    limit.failure = view.columns[c].failure;
    if (!limit.failure.empty())
        return limit;
    const Signature signature = signature_of(columns_of(view, c));
    if (signature.column == nullptr) {
        limit.failure = "no run shows what it does";
        return limit;
    }
    const double size = signature.size();
    name(candidate_model(best, {effect}, (*search.stems)[0].recordings.front()), effect,
         *signature.column, size, limit);
    if (!std::isfinite(size))
        return limit;
    const double secant = signature.column->secant;
    const double share = secant == 0.0 ? 0.0 : size / secant;
    const Eigen::VectorXd hidden_by = size * view.coefficients.col(signature.place);
    const fit::Fit& fit = search.best_model().stems[0].fit;
    limit.youngs_modulus_bias = bias(fit, hidden_by, physics::bond_youngs_modulus,
                                     std::pow(signature.node->modulus_ratio, share));
    limit.damping_bias = bias(fit, hidden_by, physics::bond_damping,
                              1.0 + share * (signature.node->damping_ratio - 1.0));
    return limit;
}

/// The column by which a stem shows the first size of a candidate; none: it does not.
std::optional<SeenColumn> first_size(const EffectView& view, std::size_t candidate) {
    for (const SeenColumn& each : columns_of(view, candidate))
        if (each.column->parameter != no_parameter && each.length > 0.0)
            return each;
    return std::nullopt;
}

std::vector<DetectionLimit> limits_of_stem(const SearchResult& search) {
    const fit::StemModel best =
        base_fit(*search.stems, 0, search.best_model(), search.stems->options().candidate)
            .parts.front()
            .model;
    std::vector<DetectionLimit> limits;
    for (std::size_t c = 0; c < search.stems->options().candidates.size(); ++c)
        if (!fit::contains(search.best_model().stems[0].fit.effects,
                           search.stems->options().candidates[c]) &&
            search.about->view(0).columns[c].failure != combination_failure)
            limits.push_back(limit_of(search, best, c));
    return limits;
}

std::vector<DetectionLimit> limits_of_rigs(const SearchResult& search) {
    std::vector<DetectionLimit> limits;
    const Stems& stems = *search.stems;
    for (std::size_t c = 0; c < stems.options().candidates.size(); ++c) {
        const physics::SelectedEffect& candidate = stems.options().candidates[c];
        if (candidate.effect->belongs_to != physics::BelongsTo::Rig)
            continue;
        for (const std::string& rig : stems.rigs()) {
            std::vector<double> information; // (stems) per coordinate
            EffectColumn size;
            for (const std::size_t s : stems.on_rig(rig))
                if (const auto seen = first_size(search.about->view(s), c)) {
                    size = *seen->column;
                    information.push_back(std::pow(seen->length / size.deviation, 2));
                }
            if (information.empty())
                continue;
            const physics::EffectParameter& card =
                candidate.effect->parameters[free_parameters(candidate)[size.parameter]];
            const auto value = [&](double in_all) {
                return fit::from_coordinate(
                    card.fitted_as,
                    size.absent + std::copysign(detected_at / std::sqrt(in_all), size.deviation));
            };
            const double of_all = std::accumulate(information.begin(), information.end(), 0.0);
            limits.push_back({candidate.effect->name,
                              rig,
                              {},
                              card.name,
                              card.unit,
                              value(of_all),
                              value(core::median(information))});
        }
    }
    return limits;
}

} // namespace

std::vector<DetectionLimit> detection_limits(const SearchResult& search) {
    return search.stems->is_one() ? limits_of_stem(search) : limits_of_rigs(search);
}

} // namespace culm::diagnose
