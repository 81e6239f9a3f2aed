// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/detection_limits.hpp"

#include "diagnose/evidence/log_evidence.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>

namespace culm::diagnose {
namespace {

constexpr double detected_at = 3.0; ///< standard deviations of the noise
constexpr auto no_parameter = std::numeric_limits<std::size_t>::max();

Eigen::Map<const Eigen::VectorXd> vector_of(const EffectColumn& column) {
    return {column.readings.data(), static_cast<Eigen::Index>(column.readings.size())};
}

/// The column by which the effect is seen best: from where it is absent to a usual size, if that
/// was computed, because derivatives may vanish where the effect is absent.
struct Signature {
    const EffectNode* node = nullptr;
    const EffectColumn* column = nullptr;
    double length = 0.0; ///< of the part that the model cannot imitate, for a size of 1
    double slope = 0.0;  ///< likewise of the derivative, if there is a secant too

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

/// Of an effect whose location alone changes the model: the derivative by its size where the
/// location changes least. Empty for other effects.
std::optional<Signature> signature_beside_offset(const EffectColumns& columns,
                                                 const fit::Projector& own) {
    std::optional<Signature> out;
    double least = std::numeric_limits<double>::infinity();
    for (const EffectNode& node : columns.nodes)
        if (node.has_offset() && node.columns.size() > 1)
            if (const double offset = own.remainder(vector_of(node.columns[0])).norm();
                offset < least) {
                least = offset;
                out = {&node, &node.columns[1], own.remainder(vector_of(node.columns[1])).norm(),
                       0.0};
            }
    return out;
}

Signature signature_of(const EffectColumns& columns, const fit::Projector& own) {
    if (const auto beside = signature_beside_offset(columns, own))
        return *beside;
    Signature out;
    std::map<std::size_t, double> slopes; // by parameter
    for (const EffectNode& node : columns.nodes)
        for (const EffectColumn& column : node.columns) {
            if (!column.is_certain && column.parameter == no_parameter)
                continue;
            const double length = own.remainder(vector_of(column)).norm();
            const bool is_secant = column.secant != 0.0;
            if (!is_secant)
                slopes[column.parameter] = std::max(slopes[column.parameter], length);
            const bool has_secant = out.column != nullptr && out.column->secant != 0.0;
            if (is_secant == has_secant ? length > out.length : is_secant)
                out = {&node, &column, length, 0.0};
        }
    if (out.column != nullptr && out.column->secant != 0.0)
        out.slope = slopes[out.column->parameter];
    return out;
}

/// Relative bias of a parameter fitted without the effect, which changes the fitted parameters by
/// `hidden_by`; the truth is `ratio` times as large.
double bias(const SearchResult& search, const Eigen::VectorXd& hidden_by,
            const physics::ParameterId& id, double ratio) {
    const auto found = std::ranges::find(search.best_fit.system.ids, id);
    if (found == search.best_fit.system.ids.end() || !(ratio > 0.0))
        return 0.0;
    const auto place = found - search.best_fit.system.ids.begin();
    const fit::FittedParameter& parameter =
        search.best_fit.parameters[static_cast<std::size_t>(place)];
    const double per_value =
        fit::coordinate_slope(parameter.fitted_as, parameter.value) * parameter.value;
    return (1.0 + hidden_by(place) / per_value) / ratio - 1.0;
}

/// Sets the parameter, its unit and value for a size in standard deviations of the prior.
void name(const SearchResult& search, const physics::SelectedEffect& effect, std::size_t parameter,
          double size, DetectionLimit& limit) {
    const fit::StemModel model = candidate_model(search.best_fit.parts.front().model, {effect},
                                                 search.chain.recordings.front());
    std::size_t own = 0;
    for (const fit::FreeParameter& each : model.parameters)
        if (each.access.id.effect == limit.effect && own++ == parameter) {
            const ParameterPrior prior = prior_of(each, model);
            limit.parameter = each.access.id.name;
            limit.unit = each.unit;
            limit.value =
                fit::from_coordinate(each.fitted_as, prior.absent + size * prior.deviation);
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
    const physics::EffectParameter known =
        effect.effect->parameters()[static_cast<std::size_t>(largest - values.begin())];
    limit.parameter = known.name;
    limit.unit = known.unit;
    limit.value = size * std::abs(*largest);
    limit.is_beyond_bounds = !(limit.value <= known.upper);
}

DetectionLimit limit_of(const SearchResult& search, const fit::Projector& own,
                        const CandidateView& view) {
    DetectionLimit limit;
    limit.effect = view.effect.effect->name();
    limit.failure = view.columns.failure;
    if (!limit.failure.empty())
        return limit;
    const Signature signature = signature_of(view.columns, own);
    if (signature.column == nullptr) {
        limit.failure = "no run shows what it does";
        return limit;
    }
    const double size = signature.size();
    name(search, view.effect, signature.column->parameter, size, limit);
    if (!std::isfinite(size))
        return limit;
    const double secant = signature.column->secant;
    const double share = secant == 0.0 ? 0.0 : size / secant;
    const Eigen::VectorXd hidden_by = size * own.coefficients(vector_of(*signature.column));
    limit.youngs_modulus_bias = bias(search, hidden_by, physics::bond_youngs_modulus,
                                     std::pow(signature.node->modulus_ratio, share));
    limit.damping_bias = bias(search, hidden_by, physics::bond_damping,
                              1.0 + share * (signature.node->damping_ratio - 1.0));
    return limit;
}

} // namespace

std::vector<DetectionLimit> detection_limits(const SearchResult& search) {
    const fit::Projector own(search.best_fit.system.jacobian);
    std::vector<DetectionLimit> limits;
    for (const CandidateView& view : search.views)
        limits.push_back(limit_of(search, own, view));
    return limits;
}

} // namespace culm::diagnose
