// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/evidence/log_evidence.hpp"

#include "diagnose/policy.hpp"
#include "fit/linear/layout.hpp"
#include "fit/linear/scaled_solve.hpp"
#include "fit/start/starts.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include <Eigen/LU>

namespace culm::diagnose {
namespace {

using fit::to_coordinate;
using physics::FittedAs;

/// Standard deviation of a size over the default of its card: the default is the size in a careful
/// laboratory, and other laboratories have sizes a few times larger.
constexpr double deviation_over_default = 3.0;

bool contains(const std::vector<std::string>& names, const std::string& name) {
    return std::ranges::find(names, name) != names.end();
}

/// The parameter as the effect describes it for this stem.
std::optional<physics::EffectParameter> described(const fit::FreeParameter& parameter,
                                                  const fit::StemModel& model) {
    for (const physics::ActiveEffect& active : model.spec.effects)
        if (active.effect->name == parameter.access.id.effect)
            for (physics::EffectParameter& each : active.effect->parameters_for(model.spec.stem))
                if (each.name == parameter.access.id.name)
                    return std::move(each);
    return std::nullopt;
}

/// Signed distance of the usual size from the absence of the effect, as a coordinate.
double usual_size(const physics::EffectParameter& card, const fit::StemModel& model,
                  double absent) {
    const double of_default = to_coordinate(card.fitted_as, card.default_value) - absent;
    double largest = deviation_over_default * of_default;
    if (card.start_values == nullptr)
        return largest;
    const physics::StartScales scales =
        fit::stem_start_scales(model.spec.stem, model.spec.duration);
    for (const double value : card.start_values(scales))
        if (const double size = to_coordinate(card.fitted_as, value) - absent;
            std::abs(size) > std::abs(largest))
            largest = size;
    return largest;
}

/// Columns of the parameters of effects whose presence is judged, of the other numbers, and of the
/// error terms that belong to the model.
struct Columns {
    std::vector<Eigen::Index> own;
    std::vector<Eigen::Index> others;
    std::vector<Eigen::Index> of_model; ///< among the others
};

/// Adds the priors of the effects' parameters.
Columns add_priors(const fit::Fit& fit, const fit::JointLayout& layout,
                   const std::vector<std::string>& given, const std::vector<std::string>& held,
                   ModelEvidence& out) {
    Columns columns;
    for (std::size_t k = 0; k < fit.system.ids.size(); ++k) {
        const auto place = static_cast<Eigen::Index>(k);
        const physics::ParameterId& id = fit.system.ids[k];
        if (id.is_of_effect() && contains(held, id.effect))
            continue;
        if (fit.system.errors[k] == fit::ErrorKind::SecondMode)
            columns.of_model.push_back(place);
        if (fit.system.errors[k] || !id.is_of_effect() || contains(given, id.effect)) {
            columns.others.push_back(place);
            continue;
        }
        columns.own.push_back(place);
        const auto [m, parameter] = layout.owners[k];
        const fit::StemModel& model = fit.parts[m].model;
        const ParameterPrior prior = prior_of(model.parameters[parameter], model);
        out.log_prior += prior.log_density(
            to_coordinate(fit.parameters[k].fitted_as, fit.parameters[k].value_with_errors));
        out.prior_precision.push_back(prior.precision());
    }
    return columns;
}

/// Adds MᵀM of the error terms that belong to the model, without what the other numbers imitate.
void add_model_terms(const fit::WeightedSystem& system, const Columns& columns,
                     ModelEvidence& out) {
    if (columns.of_model.empty())
        return;
    std::vector<Eigen::Index> rest;
    std::ranges::set_difference(columns.others, columns.of_model, std::back_inserter(rest));
    Eigen::MatrixXd terms = system.jacobian(Eigen::all, columns.of_model);
    terms.bottomRows(system.constraints).setZero();
    const Eigen::MatrixXd left = fit::Projector(system.jacobian(Eigen::all, rest)).remainder(terms);
    out.model_terms = left.transpose() * left;
}

/// Is a parameter at the bound where its effect is absent?
bool is_at_absence(const fit::FittedParameter& parameter) {
    constexpr double nearness = 1e-6; // of the range
    const double value = parameter.value_with_errors;
    const double range = parameter.upper - parameter.lower;
    if (std::min(value - parameter.lower, parameter.upper - value) > nearness * range)
        return false;
    const double absent = parameter.fitted_as == physics::FittedAs::Inverse
                              ? parameter.upper
                              : std::clamp(parameter.absent, parameter.lower, parameter.upper);
    const double far =
        absent - parameter.lower > parameter.upper - absent ? parameter.lower : parameter.upper;
    return std::abs(value - absent) < std::abs(value - far);
}

} // namespace

double ParameterPrior::log_density(double coordinate) const {
    if (known_within > 0.0) {
        const double distance = (coordinate - known) / known_within;
        return -0.5 * distance * distance -
               std::log(known_within * std::sqrt(2.0 * std::numbers::pi));
    }
    if (is_place)
        return -std::log(range);
    const double distance = (coordinate - absent) / deviation;
    const double normal = -0.5 * distance * distance -
                          std::log(std::abs(deviation) * std::sqrt(2.0 * std::numbers::pi));
    return is_one_sided ? normal + std::numbers::ln2 : normal;
}

double ParameterPrior::precision() const {
    if (known_within > 0.0)
        return 0.0;
    return is_place ? 2.0 * std::numbers::pi / (range * range) : 1.0 / (deviation * deviation);
}

ParameterPrior prior_of(const fit::FreeParameter& parameter, const fit::StemModel& model) {
    ParameterPrior prior;
    prior.is_place = parameter.is_place;
    const double lower = to_coordinate(parameter.fitted_as, parameter.lower);
    const double upper = to_coordinate(parameter.fitted_as, parameter.upper);
    prior.range = std::max(std::abs(upper - lower), 1e-300);
    prior.known = parameter.default_value;
    prior.known_within = parameter.known_within;
    if (prior.is_place)
        return prior;
    const bool is_inverse = parameter.fitted_as == FittedAs::Inverse;
    prior.absent = is_inverse ? 0.0 : to_coordinate(parameter.fitted_as, parameter.absent);
    prior.is_one_sided =
        is_inverse || !(parameter.lower < parameter.absent && parameter.absent < parameter.upper);
    if (const auto card = described(parameter, model))
        prior.deviation = usual_size(*card, model, prior.absent);
    if (prior.known_within > 0.0)
        prior.deviation = std::hypot(prior.known - prior.absent, prior.known_within);
    if (prior.deviation == 0.0)
        prior.deviation = parameter.access.scale > 0.0 ? parameter.access.scale : prior.range;
    return prior;
}

double log_prior_odds() {
    const double probability = Policy().effect_probability;
    return std::log(probability / (1.0 - probability));
}

double NoiseScale::mean_known() const {
    double sum = 0.0;
    double count = 0.0;
    for (std::size_t m = 0; m < variance.size(); ++m)
        if (is_noise_known[m]) {
            sum += variance[m] * static_cast<double>(readings[m]);
            count += static_cast<double>(readings[m]);
        }
    return count > 0.0 ? sum / count : 1.0;
}

NoiseScale noise_scale_of(const fit::Fit& best) {
    NoiseScale scale;
    for (const fit::RecordingMisfit& misfit : best.misfits) {
        const auto readings = static_cast<double>(std::max<std::size_t>(misfit.readings, 1));
        scale.variance.push_back(misfit.is_noise_known
                                     ? std::max(1.0, misfit.chi_squared / readings)
                                     : misfit.rmse * misfit.rmse);
        scale.is_noise_known.push_back(misfit.is_noise_known);
        scale.readings.push_back(misfit.readings);
    }
    return scale;
}

NoiseScale noise_as_assumed(const fit::Fit& first) {
    NoiseScale scale = noise_scale_of(first);
    for (std::size_t m = 0; m < scale.variance.size(); ++m)
        if (scale.is_noise_known[m])
            scale.variance[m] = 1.0;
    return scale;
}

std::vector<std::string> absent_effects(const fit::Fit& fit,
                                        const std::vector<std::string>& given) {
    std::vector<std::string> absent;
    for (const physics::SelectedEffect& selected : fit.effects) {
        if (contains(given, selected.effect->name))
            continue;
        bool has_size = false;
        bool is_there = false;
        for (const fit::FittedParameter& parameter : fit.parameters) {
            if (parameter.id.effect != selected.effect->name || parameter.is_place)
                continue;
            has_size = true;
            is_there = is_there || !is_at_absence(parameter);
        }
        if (has_size && !is_there)
            absent.emplace_back(selected.effect->name);
    }
    return absent;
}

ModelEvidence evidence_of(const fit::Fit& fit, std::span<const fit::ObservedRecording> recordings,
                          const std::vector<std::string>& given,
                          const std::vector<std::string>& held) {
    ModelEvidence out;
    for (const fit::RecordingMisfit& misfit : fit.misfits)
        out.misfits.push_back(misfit.is_noise_known ? misfit.chi_squared
                                                    : misfit.rmse * misfit.rmse *
                                                          static_cast<double>(misfit.readings));
    for (const fit::Pull& pull : fit.pulls)
        out.squared_pulls += pull.value * pull.value;
    for (const physics::SelectedEffect& effect : fit.effects)
        out.effects += contains(given, effect.effect->name) ? 0 : 1;
    const Columns columns =
        add_priors(fit, fit::joint_layout(fit::start_from(fit), recordings), given, held, out);
    add_model_terms(fit.system, columns, out);
    if (out.effects == 0)
        return out;
    out.absent_effects = absent_effects(fit, given);
    const fit::Projector nuisance(fit.system.jacobian(Eigen::all, columns.others));
    const Eigen::MatrixXd left = nuisance.remainder(fit.system.jacobian(Eigen::all, columns.own));
    out.information = left.transpose() * left;
    return out;
}

double log_evidence(const ModelEvidence& evidence, const NoiseScale& noise) {
    double log_likelihood = -0.5 * evidence.squared_pulls;
    for (std::size_t m = 0; m < evidence.misfits.size(); ++m) {
        const double ratio = evidence.misfits[m] / noise.variance[m];
        const auto readings = static_cast<double>(std::max<std::size_t>(noise.readings[m], 1));
        // The size of an unknown noise is eliminated too: −n log(rms).
        log_likelihood -=
            noise.is_noise_known[m] ? 0.5 * ratio : 0.5 * readings * std::log(ratio / readings);
    }
    double log_volume = 0.0;
    if (const Eigen::Index d = evidence.information.rows(); d > 0) {
        Eigen::MatrixXd hessian = evidence.information / noise.mean_known();
        hessian.diagonal() += Eigen::Map<const Eigen::VectorXd>(evidence.prior_precision.data(), d);
        log_volume -= 0.5 * fit::ScaledSpectrum(hessian).log_determinant();
        log_volume += 0.5 * static_cast<double>(d) * std::log(2.0 * std::numbers::pi);
    }
    if (evidence.model_terms.size() > 0) {
        Eigen::MatrixXd covariance = evidence.model_terms / noise.mean_known();
        covariance.diagonal().array() += 1.0;
        log_volume -= 0.5 * std::log(covariance.determinant());
    }
    return log_likelihood + evidence.log_prior + log_volume +
           static_cast<double>(evidence.effects) * log_prior_odds();
}

} // namespace culm::diagnose
