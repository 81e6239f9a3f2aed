// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/detection_limits.hpp"

#include "core/error.hpp"
#include "diagnose/evidence/log_evidence.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace culm::diagnose {
namespace {

constexpr double detected_at = 3.0; ///< standard deviations of the noise

/// Where the signature reaches detected_at, inter- or extrapolated by a power law.
struct Crossing {
    double size = std::numeric_limits<double>::infinity();
    std::size_t nearest = 0; ///< among the sizes
};

Crossing crossing_of(const std::vector<SizedEffect>& sizes, const std::vector<double>& seen) {
    Crossing out;
    while (out.nearest + 1 < sizes.size() && !(seen[out.nearest] >= detected_at))
        ++out.nearest;
    double power = 1.0;
    if (const std::size_t k = out.nearest; k > 0 && seen[k] > seen[k - 1] && seen[k - 1] > 0.0)
        power = std::clamp(std::log(seen[k] / seen[k - 1]) /
                               std::log(sizes[k].size / sizes[k - 1].size),
                           0.5, 4.0);
    if (seen[out.nearest] > 0.0)
        out.size = sizes[out.nearest].size * std::pow(detected_at / seen[out.nearest], 1.0 / power);
    return out;
}

/// Relative bias of a parameter fitted without the effect, which changes the fitted parameters by
/// `hidden_by`; the truth is `ratio` times as large.
double bias(const SearchResult& search, const Eigen::VectorXd& hidden_by,
            const physics::ParameterId& id, double ratio) {
    const auto found = std::ranges::find(search.stacked.ids, id);
    const fit::FittedParameter* const value = search.best_fit.parts.front().find(id);
    if (found == search.stacked.ids.end() || value == nullptr || !(ratio > 0.0))
        return 0.0;
    return (1.0 + hidden_by(found - search.stacked.ids.begin()) / value->value) / ratio - 1.0;
}

/// Sets the parameter, its unit and value for a size in standard deviations of the prior.
void name(const SearchResult& search, const physics::SelectedEffect& effect,
          const std::string& parameter, double size, DetectionLimit& limit) {
    const fit::StemModel model =
        candidate_model(search.best_fit.parts.front().model, {effect}, search.recordings.front());
    for (const fit::FreeParameter& each : model.parameters)
        if (each.access.id.effect == limit.effect && each.access.id.name == parameter) {
            const ParameterPrior prior = prior_of(each, model);
            limit.parameter = parameter;
            limit.unit = each.unit;
            limit.value = from_coordinate(each.fitted_as, prior.absent + size * prior.deviation);
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

void compute(const SearchResult& search, const physics::SelectedEffect& effect,
             const fit::FitOptions& options, DetectionLimit& limit) {
    const SizedEffects found =
        effect_at_sizes(search.best_fit, search.stacked, effect, search.recordings, options);
    if (found.sizes.empty()) {
        limit.failure = "no run shows what it does";
        return;
    }
    const Projector own(search.stacked.jacobian);
    std::vector<double> seen;
    for (const SizedEffect& each : found.sizes)
        seen.push_back(own.remainder(each.change).norm());
    const auto [size, nearest] = crossing_of(found.sizes, seen);
    name(search, effect, found.parameter, size, limit);
    if (!std::isfinite(size))
        return;
    const SizedEffect& near = found.sizes[nearest];
    const double share = size / near.size;
    const Eigen::VectorXd hidden_by = share * own.coefficients(near.change);
    limit.youngs_modulus_bias =
        bias(search, hidden_by, physics::bond_youngs_modulus, std::pow(near.modulus_ratio, share));
    limit.damping_bias =
        bias(search, hidden_by, physics::bond_damping, 1.0 + share * (near.damping_ratio - 1.0));
}

} // namespace

std::vector<DetectionLimit> detection_limits(const SearchResult& search,
                                             const DiagnosisOptions& options) {
    const auto work = [&](std::size_t item, const run::Heartbeat& heartbeat) {
        const fit::FitOptions own = with_heartbeat(options.candidate, heartbeat);
        DetectionLimit limit;
        limit.effect = search.views[item].effect.effect->name();
        limit.failure = search.views[item].columns.failure;
        if (!limit.failure.empty())
            return limit;
        try {
            compute(search, search.views[item].effect, own, limit);
        } catch (const core::NumericalError& error) {
            limit.failure = error.what();
        }
        return limit;
    };
    std::vector<double> costs;
    for (const CandidateView& view : search.views) {
        fit::SelectedEffects larger = search.best_fit.effects;
        larger.push_back(view.effect);
        costs.push_back(fit::relative_cost(larger));
    }
    std::vector<DetectionLimit> limits;
    for (DetectionLimit& answer : options.map.values(costs, work)) {
        DetectionLimit& limit = limits.emplace_back(std::move(answer));
        limit.effect = search.views[limits.size() - 1].effect.effect->name();
    }
    return limits;
}

} // namespace culm::diagnose
