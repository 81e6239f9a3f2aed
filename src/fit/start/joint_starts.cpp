// SPDX-License-Identifier: BSD-3-Clause
#include "core/error.hpp"
#include "fit/start/starts.hpp"
#include "run/modes.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <optional>
#include <set>
#include <utility>

#include <Eigen/Cholesky>

namespace culm::fit {

namespace {

constexpr int modulus_passes = 3;         // f² is nearly a straight line in Y
constexpr double first_step = 1.0 / 16.0; ///< of the size's scale
constexpr int most_doublings = 20;
constexpr int halvings = 12;
/// An excess that changes by less than this share over a scale does not depend on the size.
constexpr double least_influence = 1e-3;

/// A point of the search: the fitted form of the size, and the excess, which shall vanish.
struct Trial {
    double internal = 0.0;
    double excess = 0.0;
};

/// The first frequency of chain_modes, Hz; NaN if the chain does not vibrate.
double first_frequency(const run::CaseSpec& spec) {
    try {
        const auto modes = run::chain_modes(spec, 1);
        if (!modes.empty())
            return modes.front().frequency;
    } catch (const core::NumericalError&) {
        // The eigenvalues of a chain that is far from any stem may not be computable.
    }
    return std::numeric_limits<double>::quiet_NaN();
}

/// Y (Pa) at which the case's first mode has this frequency (Hz). f² = Y a + b with b from effects
/// that do not scale with Y (gravity, a clamp): the ratio of squares converges by b/f² a pass.
double matching_modulus(run::CaseSpec spec, double frequency) {
    for (int pass = 0; pass < modulus_passes; ++pass) {
        const double own = first_frequency(spec);
        if (!std::isfinite(own))
            break;
        spec.stem.bond_youngs_modulus *= (frequency / own) * (frequency / own);
    }
    return spec.stem.bond_youngs_modulus;
}

/// Sets `size` in `spec` to the value at which `excess` vanishes or, if there is none, is smallest:
/// doubling steps in both directions from where the effect of `size` is absent, within the bounds,
/// then bisection. The excess is not smooth at the bounds and may have no zero, so Newton's method
/// would leave the range; each evaluation is an eigenvalue of the chain and costs a millisecond.
void match(const FreeParameter& size, run::CaseSpec& spec,
           const std::function<double(const run::CaseSpec&)>& excess) {
    const auto [lower, upper] =
        std::minmax({to_internal(size, spec, size.lower), to_internal(size, spec, size.upper)});
    const auto at = [&](double internal) {
        run::CaseSpec changed = spec;
        size.access.set(changed, from_internal(size, spec, internal));
        return Trial{internal, excess(changed)};
    };
    const Trial absent = at(to_internal(size, spec, absent_value(size)));
    Trial best = absent;
    const auto take = [&best](const Trial& trial) {
        if (std::abs(trial.excess) < std::abs(best.excess))
            best = trial;
    };
    const auto finds_zero = [&, lowest = lower, highest = upper](double direction) {
        Trial last = absent;
        double step = first_step;
        for (int k = 0; k < most_doublings; ++k, step *= 2.0) {
            Trial next = at(std::clamp(absent.internal + direction * step, lowest, highest));
            if (!std::isfinite(next.excess) || next.internal == last.internal)
                return false;
            take(next);
            if (std::signbit(next.excess) == std::signbit(last.excess)) {
                last = next;
                continue;
            }
            for (int halving = 0; halving < halvings; ++halving) {
                const Trial middle = at(0.5 * (last.internal + next.internal));
                take(middle);
                (std::signbit(middle.excess) == std::signbit(last.excess) ? last : next) = middle;
            }
            return true;
        }
        return false;
    };
    for (const double direction : {1.0, -1.0}) {
        const Trial far = at(std::clamp(absent.internal + direction, lower, upper));
        if (std::abs(far.excess - absent.excess) > least_influence * std::abs(absent.excess) &&
            finds_zero(direction))
            break;
    }
    size.access.set(spec, from_internal(size, spec, best.internal));
}

/// Starts are the same if their phases at the end of the record differ by less than this.
constexpr double same_phase = 0.1; // cycles
/// A size reconciles the recordings only if less than this share of the disagreement remains.
constexpr double needed_share = 0.5;

const FreeParameter* find(const StemModel& model, const physics::ParameterId& id) {
    const auto found = std::ranges::find_if(
        model.parameters, [&](const auto& parameter) { return parameter.access.id == id; });
    return found == model.parameters.end() ? nullptr : &*found;
}

/// The phase by which the recordings differ at their ends, without their common phase error.
double disagreement(const StartModels& models, std::span<const RecordedSwing> swings) {
    double lowest = std::numeric_limits<double>::infinity();
    double highest = -lowest;
    double cycles = 0.0;
    for (std::size_t m = 0; m < models.size(); ++m) {
        const double ratio =
            std::log(swings[m].mode.frequency / first_frequency(case_beside_errors(models[m])));
        lowest = std::min(lowest, ratio); // false for NaN: such a part is ignored
        highest = std::max(highest, ratio);
        cycles = std::max(cycles, swings[m].cycles);
    }
    return (highest - lowest) * cycles;
}

bool is_logarithm(const FittedParameter& parameter) {
    return parameter.fitted_as != physics::FittedAs::Itself && parameter.value > 0.0;
}

/// Information of the posteriors of recordings' own fits, and information times mean.
struct Posteriors {
    Eigen::MatrixXd information; ///< (joint list, joint list)
    Eigen::VectorXd weighted;    ///< (joint list), logarithms where fitted as such
    /// (joint list) The constraint of an error that several recordings share counts once.
    std::vector<bool> is_constrained;
};

/// Adds the posterior of a recording's own fit, whose free parameters have these `shares`. False if
/// it has none.
bool add_posterior(const std::vector<JointLayout::Share>& shares, const RecordingFit& fit,
                   Posteriors& sum) {
    const auto free = static_cast<Eigen::Index>(shares.size());
    const Eigen::VectorXd deviation = fit.covariance.diagonal().cwiseSqrt();
    if (deviation.size() != free || !deviation.allFinite() || !(deviation.minCoeff() > 0.0))
        return false;
    const auto inverse = deviation.cwiseInverse().asDiagonal();
    const Eigen::LLT<Eigen::MatrixXd> correlation(inverse * fit.covariance * inverse);
    if (correlation.info() != Eigen::Success)
        return false;
    Eigen::MatrixXd by_joint = Eigen::MatrixXd::Zero(free, sum.information.cols());
    Eigen::VectorXd at(free); // both in deviations
    for (Eigen::Index k = 0; k < free; ++k) {
        const auto [place, factor] = shares[static_cast<std::size_t>(k)];
        const FittedParameter& parameter = fit.parameters[static_cast<std::size_t>(k)];
        const double joint = parameter.value / factor;
        const bool is_log = is_logarithm(parameter);
        const double unit = (is_log ? parameter.value : factor) / deviation(k);
        by_joint(k, static_cast<Eigen::Index>(place)) = unit;
        at(k) = (is_log ? std::log(joint) : joint) * unit;
        if (!fit.model.is_error(static_cast<std::size_t>(k)))
            continue;
        if (sum.is_constrained[place])
            sum.information.diagonal()(static_cast<Eigen::Index>(place)) -= 1.0; // its mean is 0
        sum.is_constrained[place] = true;
    }
    sum.information += by_joint.transpose() * correlation.solve(by_joint);
    sum.weighted += by_joint.transpose() * correlation.solve(at);
    return true;
}

/// The models at the point where the Gaussian posteriors of the recordings' own fits meet; empty if
/// a fit has none, or they do not determine all. Their information adds. With means of Y and β
/// alone each recording would keep the errors of its values, and after a wrong length measurement
/// these differ by whole cycles.
std::optional<StartModels> where_posteriors_meet(StartModels own,
                                                 std::span<const RecordingFit> alone,
                                                 const JointLayout& layout) {
    const auto count = static_cast<Eigen::Index>(layout.ids.size());
    Posteriors sum{Eigen::MatrixXd::Zero(count, count), Eigen::VectorXd::Zero(count),
                   std::vector<bool>(layout.ids.size(), false)};
    for (std::size_t m = 0; m < own.size(); ++m)
        if (!add_posterior(layout.shares[m], alone[m], sum))
            return std::nullopt;
    const Eigen::LLT<Eigen::MatrixXd> information(sum.information);
    if (information.info() != Eigen::Success)
        return std::nullopt;
    const Eigen::VectorXd mean = information.solve(sum.weighted);
    if (mean.size() == 0 || !mean.allFinite())
        return std::nullopt;
    for (std::size_t m = 0; m < own.size(); ++m)
        for (std::size_t k = 0; k < layout.shares[m].size(); ++k) {
            const auto [place, factor] = layout.shares[m][k];
            const double value = mean(static_cast<Eigen::Index>(place));
            own[m].set_value(
                k, factor * (is_logarithm(alone[m].parameters[k]) ? std::exp(value) : value));
        }
    return own;
}
/// Sets β such that the recordings' first modes decay as recorded, on average.
void keep_decay(std::span<const RecordedSwing> swings, StartModels& start) {
    double sum = 0.0;
    for (std::size_t m = 0; m < start.size(); ++m) {
        StemModel own = start[m];
        keep_first_mode(swings[m].mode, own);
        sum += std::log(own.spec.stem.bond_damping);
    }
    for (StemModel& model : start)
        model.spec.stem.bond_damping = std::exp(sum / static_cast<double>(start.size()));
}

void set_modulus(double youngs_modulus, StartModels& start) {
    for (StemModel& model : start)
        model.spec.stem.bond_youngs_modulus = youngs_modulus;
}

/// The modulus for each recording that gives it its frequency.
std::vector<double> apparent_moduli(const StartModels& models,
                                    std::span<const RecordedSwing> swings) {
    std::vector<double> moduli;
    for (std::size_t m = 0; m < models.size(); ++m)
        moduli.push_back(matching_modulus(models[m].spec, swings[m].mode.frequency));
    return moduli;
}

/// Sets one modulus for all recordings and a separate size for each recording.
StartModels with_own_sizes(StartModels start, const physics::ParameterId& id, double youngs_modulus,
                           std::span<const RecordedSwing> swings) {
    set_modulus(youngs_modulus, start);
    for (std::size_t m = 0; m < start.size(); ++m)
        if (const FreeParameter* const size = find(start[m], id)) {
            const double wanted = std::log(swings[m].mode.frequency);
            match(*size, start[m].spec, [&](const run::CaseSpec& spec) {
                return std::log(first_frequency(spec)) - wanted;
            });
        }
    return start;
}

/// Sets all recordings to the size at which the highest and the lowest modulus are equal.
StartModels with_shared_size(StartModels start, const physics::ParameterId& id,
                             std::span<const RecordedSwing> swings) {
    const std::vector<double> moduli = apparent_moduli(start, swings);
    const auto [low, high] = std::ranges::minmax_element(moduli);
    const auto lowest = static_cast<std::size_t>(low - moduli.begin());
    const auto highest = static_cast<std::size_t>(high - moduli.begin());
    const FreeParameter* const size = find(start[lowest], id);
    const FreeParameter* const other = find(start[highest], id);
    if (size == nullptr || other == nullptr)
        return start;
    match(*size, start[lowest].spec, [&](const run::CaseSpec& spec) {
        run::CaseSpec second = start[highest].spec;
        other->access.set(second, size->access.get(spec));
        return std::log(matching_modulus(second, swings[highest].mode.frequency) /
                        matching_modulus(spec, swings[lowest].mode.frequency));
    });
    const double value = size->access.get(start[lowest].spec);
    for (StemModel& model : start)
        if (const FreeParameter* const own = find(model, id))
            own->access.set(model.spec, value);
    double sum = 0.0;
    for (const double modulus : apparent_moduli(start, swings))
        sum += std::log(modulus);
    set_modulus(std::exp(sum / static_cast<double>(start.size())), start);
    return start;
}

std::set<physics::ParameterId> new_sizes(const StartModels& models,
                                         std::span<const RecordingFit> smaller) {
    std::set<physics::ParameterId> ids;
    for (const StemModel& model : models)
        for (const FreeParameter& parameter : model.parameters)
            if (!parameter.is_place && parameter.access.id.is_of_effect() &&
                std::ranges::all_of(smaller, [&](const RecordingFit& fit) {
                    return fit.find(parameter.access.id) == nullptr;
                }))
                ids.insert(parameter.access.id);
    return ids;
}

} // namespace

RecordedSwing recorded_swing(const measure::Measurement& measurement, const FitOptions& options) {
    const StemModel model = baseline_model(measurement, options.chain);
    const double natural = run::natural_frequency(model.spec);
    const double ratio = std::min(std::numbers::pi * natural * damping_time(model.spec), 0.99);
    const double share = std::sqrt(1.0 - ratio * ratio);
    RecordedSwing swing;
    swing.mode.frequency = natural * share;
    swing.mode.decay_per_cycle = -2.0 * std::numbers::pi * ratio / share;
    swing.mode.decay_rate = swing.mode.decay_per_cycle * swing.mode.frequency;
    swing.cycles = swing.mode.frequency * measurement.times.back();
    swing.tip_deflection = model.spec.tip_deflection;
    return swing;
}

std::vector<StartModels> shared_starts(const StartModels& models,
                                       std::span<const RecordingFit> alone,
                                       std::span<const RecordedSwing> swings,
                                       const JointLayout& layout) {
    StartModels own;
    for (std::size_t m = 0; m < models.size(); ++m)
        own.push_back(started_from(models[m], alone[m]));
    std::vector<StartModels> starts;
    if (std::optional<StartModels> start = where_posteriors_meet(own, alone, layout)) {
        starts.push_back(std::move(*start));
        if (disagreement(starts.front(), swings) < same_phase)
            return starts;
    }
    for (const StemModel& one : own) {
        starts.push_back(own);
        for (StemModel& model : starts.back())
            for (const FreeParameter& parameter : model.parameters)
                if (!belongs_to_recording(parameter.access.id)) {
                    const FreeParameter* const found = find(one, parameter.access.id);
                    parameter.access.set(
                        model.spec, (found != nullptr ? *found : parameter).access.get(one.spec));
                }
    }
    return starts;
}

std::vector<StartModels> reconciling_starts(const StartModels& models,
                                            std::span<const RecordingFit> smaller,
                                            std::span<const RecordedSwing> swings) {
    const double before = disagreement(models, swings);
    std::vector<StartModels> starts;
    if (!(before >= same_phase))
        return starts;
    StartModels start = models;
    for (std::size_t m = 0; m < start.size(); ++m) {
        // A joint fit that skips cycles distorts these, too.
        start[m].release_time = 0.0;
        if (find(start[m], physics::tip_deflection) != nullptr)
            start[m].spec.tip_deflection = swings[m].tip_deflection;
    }
    const auto keep_if_reconciled = [&](StartModels candidate) {
        if (!(disagreement(candidate, swings) < needed_share * before))
            return;
        try {
            keep_decay(swings, candidate);
        } catch (const core::NumericalError&) {
            return; // the chain does not vibrate: no fit could start there
        }
        starts.push_back(std::move(candidate));
    };
    for (const physics::ParameterId& id : new_sizes(models, smaller)) {
        if (!belongs_to_recording(id)) {
            keep_if_reconciled(with_shared_size(start, id, swings));
            continue;
        }
        std::vector<double> moduli = apparent_moduli(start, swings);
        std::ranges::sort(moduli, std::greater{});
        for (const double modulus : {moduli.front(), moduli.back()})
            keep_if_reconciled(with_own_sizes(start, id, modulus, swings));
    }
    return starts;
}

} // namespace culm::fit
