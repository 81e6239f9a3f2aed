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

class Limit {
  public:
    Limit(const SearchResult& search, const physics::SelectedEffect& effect,
          const fit::FitOptions& options)
        : search_(search), effect_(effect), options_(options) {
        out_.effect = effect.effect->name();
    }

    [[nodiscard]] DetectionLimit compute() {
        const SizedEffects found = effect_at_sizes(search_.best_fit, search_.stacked, effect_,
                                                   search_.recordings, options_);
        if (found.sizes.empty()) {
            out_.failure = "no run shows what it does";
            return out_;
        }
        const Projector own(search_.stacked.jacobian);
        std::vector<double> seen;
        for (const SizedEffect& each : found.sizes)
            seen.push_back(own.remainder(each.change).norm());
        const Crossing at = crossing_of(found.sizes, seen);
        name(found.parameter, at.size);
        if (!std::isfinite(at.size))
            return out_;
        const SizedEffect& near = found.sizes[at.nearest];
        const double share = at.size / near.size;
        const Eigen::VectorXd hidden_by = share * own.coefficients(near.change);
        out_.youngs_modulus_bias =
            bias(hidden_by, physics::bond_youngs_modulus, std::pow(near.modulus_ratio, share));
        out_.damping_bias =
            bias(hidden_by, physics::bond_damping, 1.0 + share * (near.damping_ratio - 1.0));
        return out_;
    }

  private:
    /// Relative bias of a parameter fitted without the effect; the truth is `ratio` times as large.
    [[nodiscard]] double bias(const Eigen::VectorXd& hidden_by, const physics::ParameterId& id,
                              double ratio) const {
        const auto found = std::ranges::find(search_.stacked.ids, id);
        const fit::FittedParameter* const value = search_.best_fit.parts.front().find(id);
        if (found == search_.stacked.ids.end() || value == nullptr || !(ratio > 0.0))
            return 0.0;
        return (1.0 + hidden_by(found - search_.stacked.ids.begin()) / value->value) / ratio - 1.0;
    }

    void name(const std::string& parameter, double size) {
        const fit::StemModel model = candidate_model(search_.best_fit.parts.front().model,
                                                     {effect_}, search_.recordings.front());
        for (const fit::FreeParameter& each : model.parameters)
            if (each.access.id.effect == out_.effect && each.access.id.name == parameter) {
                const ParameterPrior prior = prior_of(each, model);
                out_.parameter = parameter;
                out_.unit = each.unit;
                out_.value = from_coordinate(each.fitted_as, prior.absent + size * prior.deviation);
                out_.is_beyond_bounds = !(out_.value >= each.lower && out_.value <= each.upper);
            }
        if (out_.parameter.empty())
            name_known_number(model.spec.effects.back().values, size);
    }

    /// For an effect without a free parameter: the largest of its known values gives the size.
    void name_known_number(const std::vector<double>& values, double size) {
        const std::vector<physics::EffectParameter> parameters = effect_.effect->parameters();
        const auto largest =
            std::ranges::max_element(values, {}, [](double value) { return std::abs(value); });
        if (largest == values.end())
            return;
        const physics::EffectParameter& parameter =
            parameters[static_cast<std::size_t>(largest - values.begin())];
        out_.parameter = parameter.name;
        out_.unit = parameter.unit;
        out_.value = size * std::abs(*largest);
        out_.is_beyond_bounds = !(out_.value <= parameter.upper);
    }

    const SearchResult& search_;
    const physics::SelectedEffect& effect_;
    const fit::FitOptions& options_;
    DetectionLimit out_;
};

} // namespace

std::vector<DetectionLimit> detection_limits(const SearchResult& search,
                                             const SearchOptions& options) {
    const auto work = [&](std::size_t item, const run::Heartbeat& heartbeat) {
        const fit::FitOptions own = with_heartbeat(options.candidate, heartbeat);
        DetectionLimit failed;
        failed.effect = search.views[item].effect.effect->name();
        failed.failure = search.views[item].columns.failure;
        if (!failed.failure.empty())
            return failed;
        try {
            return Limit(search, search.views[item].effect, own).compute();
        } catch (const core::NumericalError& error) {
            failed.failure = error.what();
        }
        return failed;
    };
    std::vector<double> costs;
    for (const CandidateView& view : search.views) {
        fit::SelectedEffects larger = search.best_fit.effects;
        larger.push_back(view.effect);
        costs.push_back(fit::relative_cost(larger));
    }
    std::vector<DetectionLimit> limits;
    for (std::optional<DetectionLimit>& answer : options.map.values(costs, work)) {
        DetectionLimit lost;
        lost.failure = "the rank that computed it was lost";
        lost.effect = search.views[limits.size()].effect.effect->name();
        limits.push_back(std::move(answer).value_or(std::move(lost)));
    }
    return limits;
}

} // namespace culm::diagnose
