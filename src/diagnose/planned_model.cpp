// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/planned_model.hpp"

#include "core/error.hpp"
#include "diagnose/adequacy.hpp"
#include "fit/linear/layout.hpp"
#include "fit/linear/scaled_solve.hpp"
#include "fit/start/starts.hpp"
#include "physics/effects/library.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <iterator>
#include <numeric>
#include <set>
#include <tuple>

namespace culm::diagnose {
namespace {

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

void place_effect(const CandidateView& view, const PlacedEffect& effect, std::size_t recording,
                  fit::StemModel& model) {
    const EffectNode& node = view.columns.nodes[effect.node];
    const EffectNode& other = view.columns.nodes[effect.other];
    const std::string name = view.effect.effect->name();
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

/// Along a finite change of one recording, Y and β change such that the first mode stays. (Several
/// recordings have one material, and a beat has another frequency.)
bool keeps_first_mode(const CandidateView& view, const PlacedEffect& effect,
                      std::size_t recordings) {
    const EffectNode& node = view.columns.nodes[effect.node];
    return (node.columns.front().secant != 0.0 || node.has_offset()) &&
           view.effect.effect->dimensions() < 3 && recordings == 1;
}

/// The model with the effect.
fit::StemModel with_effect(const fit::StemModel& base, const CandidateView& view,
                           const PlacedEffect& effect, std::size_t recording,
                           std::span<const fit::ObservedRecording> recordings) {
    fit::StemModel model = candidate_model(base, {view.effect}, recordings[recording]);
    place_effect(view, effect, recording, model);
    if (keeps_first_mode(view, effect, recordings.size())) {
        fit::keep_first_mode(base.spec, model);
        return model;
    }
    const EffectNode& node = view.columns.nodes[effect.node];
    const double share = way_to(node, effect.amounts);
    model.spec.stem.bond_youngs_modulus *= std::pow(node.modulus_ratio, share);
    model.spec.stem.bond_damping *= std::pow(node.damping_ratio, share);
    return model;
}

/// Models at or on the way to the linear estimate with some effects.
class EstimatedStarts {
  public:
    EstimatedStarts(const fit::Fit& base, std::span<const fit::ObservedRecording> recordings,
                    const std::vector<CandidateView>& views, const std::vector<std::size_t>& chosen)
        : base_(base), recordings_(recordings), views_(views), chosen_(chosen),
          fitted_(fit::start_from(base)), layout_(fit::joint_layout(fitted_, recordings)) {
        std::tie(lower_, upper_) = fit::bounds_of(fitted_, layout_);
    }

    /// The point with the sizes that explain most while no parameter leaves its bounds.
    [[nodiscard]] PredictedPoint within_bounds(PredictedPoint point) const {
        const Eigen::Index own = base_.system.jacobian.cols();
        Eigen::MatrixXd all = base_.system.jacobian;
        Eigen::VectorXd lower = Eigen::VectorXd::Constant(own, -no_limit);
        lower.head(lower_.size()) = lower_;
        Eigen::VectorXd upper = Eigen::VectorXd::Constant(own, no_limit);
        upper.head(upper_.size()) = upper_;
        std::vector<double*> amounts;
        for (std::size_t e = 0; e < chosen_.size(); ++e)
            for (std::size_t k = 0; k < point.effects[e].amounts.size(); ++k) {
                const Eigen::Index column = all.cols();
                all.conservativeResize(Eigen::NoChange, column + 1);
                all.col(column) = column_of(e, point.effects[e], k);
                lower.conservativeResize(column + 1);
                upper.conservativeResize(column + 1);
                const EffectColumn& of = node(e, point.effects[e].node).columns[k];
                const double largest = of.is_certain ? 1.0 : of.largest_amount();
                lower(column) = of.is_certain ? 1.0 : of.is_one_sided ? 0.0 : -largest;
                upper(column) = largest;
                amounts.push_back(&point.effects[e].amounts[k]);
            }
        Eigen::MatrixXd information = all.transpose() * all;
        information.diagonal().tail(all.cols() - own).array() += 1.0; // the prior of the sizes
        const Eigen::VectorXd change = fit::bounded_minimum(
            information, all.transpose() * base_.system.residual, lower, upper);
        for (std::size_t k = 0; k < amounts.size(); ++k)
            *amounts[k] = change(own + static_cast<Eigen::Index>(k));
        return point;
    }

    /// With this share of the sizes. Y and β keep the first mode: that of the base along a finite
    /// change, else that of the straight way.
    [[nodiscard]] fit::StartModels towards(const PredictedPoint& point, double share) const {
        for (std::size_t e = 0; e < chosen_.size(); ++e)
            if (keeps_first_mode(views_[chosen_[e]], point.effects[e], recordings_.size()))
                return at(point, share);
        return fit::in_valley([&](double part) { return at(point, part * share); },
                              fit::joint_layout(at(point, share), recordings_));
    }

  private:
    static constexpr double no_limit = 1e6; ///< of a pull

    [[nodiscard]] const EffectNode& node(std::size_t e, std::size_t at) const {
        return views_[chosen_[e]].columns.nodes[at];
    }

    [[nodiscard]] Eigen::VectorXd column_of(std::size_t e, const PlacedEffect& effect,
                                            std::size_t k) const {
        const auto readings = [&](std::size_t at) {
            const std::vector<double>& of = node(e, at).columns[k].readings;
            return Eigen::Map<const Eigen::VectorXd>(of.data(), std::ssize(of));
        };
        if (effect.share == 0.0)
            return readings(effect.node);
        return (1.0 - effect.share) * readings(effect.node) + effect.share * readings(effect.other);
    }

    /// On the straight way: the base's parameters compensate the effects, with exact inputs.
    [[nodiscard]] fit::StartModels at(const PredictedPoint& point, double share) const {
        PredictedPoint part = point;
        Eigen::VectorXd readings = Eigen::VectorXd::Zero(base_.system.residual.size());
        for (std::size_t e = 0; e < chosen_.size(); ++e)
            for (std::size_t k = 0; k < part.effects[e].amounts.size(); ++k) {
                double& amount = part.effects[e].amounts[k];
                amount *= share;
                readings += amount * column_of(e, part.effects[e], k);
            }
        const Eigen::MatrixXd own = base_.system.jacobian.leftCols(lower_.size());
        fit::StartModels models =
            fit::moved(fitted_, layout_,
                       fit::bounded_minimum(own.transpose() * own, -own.transpose() * readings,
                                            lower_, upper_));
        for (std::size_t e = 0; e < chosen_.size(); ++e)
            for (std::size_t m = 0; m < models.size(); ++m)
                models[m] =
                    with_effect(models[m], views_[chosen_[e]], part.effects[e], m, recordings_);
        return models;
    }

    const fit::Fit& base_;
    std::span<const fit::ObservedRecording> recordings_;
    const std::vector<CandidateView>& views_;
    const std::vector<std::size_t>& chosen_;
    fit::StartModels fitted_;
    fit::JointLayout layout_;
    Eigen::VectorXd lower_; ///< (fitted numbers) of their changes
    Eigen::VectorXd upper_;
};

/// Share of the way to the likeliest estimate at which a fit may begin, too.
constexpr double shorter_share = 0.25;

/// Does the size of effect number `place` of the fit permit that the effect is absent from the
/// recording? An effect acts in at least one recording.
bool may_be_absent(const fit::Fit& fit, std::size_t place, const std::string& recording) {
    const physics::SelectedEffect& effect = fit.effects[place];
    return fit::belongs_to_recording({effect.effect->name(), {}, {}}) &&
           effect.absent_from.size() + 1 < fit.misfits.size() &&
           std::ranges::any_of(fit.parameters, [&](const fit::FittedParameter& parameter) {
               return parameter.id.effect == effect.effect->name() &&
                      parameter.id.recording == recording && !parameter.is_place &&
                      (is_absent(parameter) || parameter.is_at_bound);
           });
}

} // namespace

ModelKey key_of(const fit::SelectedEffects& effects) {
    ModelKey key;
    for (const physics::SelectedEffect& selected : effects) {
        std::string& text = key.emplace_back(physics::to_string(selected));
        for (const std::string& recording : selected.absent_from)
            text += " without " + recording;
    }
    std::ranges::sort(key);
    return key;
}

bool can_be_combined(const fit::SelectedEffects& effects) {
    std::vector<physics::EffectPointer> pointers;
    std::set<physics::Family> laws;
    for (const physics::SelectedEffect& selected : effects) {
        pointers.push_back(selected.effect);
        if (physics::is_one_law(selected.effect->family()) &&
            !laws.insert(selected.effect->family()).second)
            return false;
    }
    try {
        physics::check_combination(pointers);
    } catch (const core::InputError&) {
        return false;
    }
    return true;
}

std::vector<fit::StartModels> starts_to_estimate(const fit::Fit& base,
                                                 std::span<const fit::ObservedRecording> recordings,
                                                 const std::vector<CandidateView>& views,
                                                 const std::vector<std::size_t>& chosen,
                                                 const PredictedGain& gain) {
    const EstimatedStarts estimated(base, recordings, views, chosen);
    std::vector<fit::StartModels> starts;
    for (const PredictedPoint& point : gain.points)
        starts.push_back(estimated.towards(estimated.within_bounds(point), 1.0));
    const PredictedPoint likeliest = estimated.within_bounds(gain.points.front());
    starts.push_back(estimated.towards(likeliest, shorter_share));
    starts.push_back(estimated.towards(likeliest, 0.0));
    return starts;
}

bool contains_all(const fit::SelectedEffects& effects, const fit::SelectedEffects& some) {
    return std::ranges::all_of(some,
                               [&](const auto& each) { return fit::contains(effects, each); });
}

std::vector<fit::SelectedEffects>
sets_to_compare(const fit::Fit& fit, std::span<const fit::ObservedRecording> recordings,
                std::size_t known) {
    std::vector<fit::SelectedEffects> sets;
    const fit::SelectedEffects& effects = fit.effects;
    for (std::size_t k = known; k < effects.size(); ++k) {
        if (effects.size() > known + 1) {
            fit::SelectedEffects& smaller = sets.emplace_back(effects);
            smaller.erase(smaller.begin() + static_cast<std::ptrdiff_t>(k));
        }
        for (const measure::Measurement& recording : recordings)
            if (may_be_absent(fit, k, recording.stem.id)) {
                std::vector<std::string>& absent = sets.emplace_back(effects)[k].absent_from;
                absent.push_back(recording.stem.id);
                std::ranges::sort(absent);
            }
    }
    return sets;
}

fit::Fit fit_larger(const fit::SelectedEffects& effects, const fit::Fit& smaller,
                    std::span<const fit::ObservedRecording> recordings,
                    const fit::FitOptions& options) {
    if (!smaller.moves() || smaller.failed())
        return fit::fit_model(effects, smaller, recordings, options);
    int batches = 0;
    fit::Fit fit;
    fit::SelectedEffects added = fit::in_library_order(effects);
    std::erase_if(added, [&](const auto& each) { return fit::contains(smaller.effects, each); });
    try {
        std::vector<CandidateView> views;
        for (const physics::SelectedEffect& effect : added) {
            views.push_back({effect, effect_columns(smaller, effect, recordings, options)});
            batches += views.back().columns.batches;
            if (const std::string& failure = views.back().columns.failure; !failure.empty())
                throw core::NumericalError(core::FailureKind::FitFailed, failure);
        }
        std::vector<std::size_t> all(views.size());
        std::iota(all.begin(), all.end(), 0);
        PredictedGain gain = LinearEvidence(smaller.system, views).gain(all);
        if (gain.points.empty()) { // all allowed sizes make the fit worse: it starts without them
            gain.points.emplace_back();
            for (const CandidateView& view : views)
                gain.points.front().effects.push_back(
                    {.amounts = std::vector(view.columns.nodes.front().columns.size(), 0.0)});
        }
        fit::SelectedEffects larger = smaller.effects;
        larger.insert(larger.end(), added.begin(), added.end());
        fit = fit::fit_near(starts_to_estimate(smaller, recordings, views, all, gain), larger,
                            smaller, recordings, options);
        batches += fit.batches;
    } catch (const std::runtime_error& error) { // InputError or NumericalError
        fit.reason = error.what();
    }
    fit.batches = batches;
    fit.effects = effects;
    return fit;
}

FittedModel fit_planned(const PlannedModel& planned, const fit::Fit& smaller,
                        std::span<const fit::ObservedRecording> recordings,
                        const fit::SelectedEffects& known, const Policy& policy,
                        const fit::FitOptions& options) {
    const fit::Fit fit =
        planned.starts.empty()
            ? fit_larger(planned.effects, smaller, recordings, options)
            : fit::fit_near(planned.starts, planned.effects, smaller, recordings, options);
    FittedModel out;
    if (!fit.failed())
        out.evidence = evidence_of(fit, recordings, known);
    out.is_inadequate =
        fit.is_fitted() && verdict_on(fit, recordings, policy).finding == Finding::Inadequate;
    out.fit = fit::to_numbers_with_points(fit);
    return out;
}

} // namespace culm::diagnose
