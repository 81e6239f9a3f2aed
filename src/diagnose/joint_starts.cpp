// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/joint_starts.hpp"

#include "core/error.hpp"
#include "diagnose/fit_starts.hpp"
#include "diagnose/frequency_match.hpp"
#include "diagnose/model_fit.hpp"
#include "run/modes.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <set>
#include <string>
#include <utility>

namespace culm::diagnose {
namespace {

/// Phases that differ by less at the end of the record are no different start.
constexpr double same_phase = 0.1; // cycles
/// A size that leaves more than this of the disagreement does not reconcile the recordings.
constexpr double needed_share = 0.5;

const calibrate::FreeParameter* find(const calibrate::StemModel& model, const std::string& name) {
    const auto found = std::ranges::find_if(
        model.parameters, [&](const auto& parameter) { return parameter.access.name == name; });
    return found == model.parameters.end() ? nullptr : &*found;
}

/// The phase by which the recordings differ at their ends beside what they all miss.
double disagreement(const JointStart& models, std::span<const RecordedSwing> swings) {
    double lowest = std::numeric_limits<double>::infinity();
    double highest = -lowest;
    double cycles = 0.0;
    for (std::size_t m = 0; m < models.size(); ++m) {
        const double ratio = std::log(swings[m].mode.frequency / first_frequency(models[m].spec));
        lowest = std::min(lowest, ratio); // false for NaN: such a part says nothing
        highest = std::max(highest, ratio);
        cycles = std::max(cycles, swings[m].cycles);
    }
    return (highest - lowest) * cycles;
}

/// Mean of a shared value over the fits that tell it, on the scale on which it is fitted.
double weighted_mean(const std::string& name, std::span<const calibrate::ChainFit> alone,
                     double otherwise) {
    double sum = 0.0;
    double weights = 0.0;
    bool is_logarithm = false;
    for (const calibrate::ChainFit& fit : alone) {
        const calibrate::FittedParameter* const found = fit.find(name);
        if (found == nullptr || !(found->standard_error > 0.0) ||
            !std::isfinite(found->standard_error))
            continue;
        is_logarithm = found->fitted_as != physics::FittedAs::Itself && found->value > 0.0;
        const double value = is_logarithm ? std::log(found->value) : found->value;
        const double error =
            is_logarithm ? found->standard_error / found->value : found->standard_error;
        sum += value / (error * error);
        weights += 1.0 / (error * error);
    }
    if (!(weights > 0.0))
        return otherwise;
    return is_logarithm ? std::exp(sum / weights) : sum / weights;
}

/// β such that the recordings' first modes decay as they do, in the mean.
void keep_decay(std::span<const RecordedSwing> swings, JointStart& start) {
    double sum = 0.0;
    for (std::size_t m = 0; m < start.size(); ++m) {
        calibrate::StemModel own = start[m];
        keep_first_mode(swings[m].mode, own);
        sum += std::log(own.spec.stem.bond_damping);
    }
    for (calibrate::StemModel& model : start)
        model.spec.stem.bond_damping = std::exp(sum / static_cast<double>(start.size()));
}

void set_modulus(double youngs_modulus, JointStart& start) {
    for (calibrate::StemModel& model : start)
        model.spec.stem.bond_youngs_modulus = youngs_modulus;
}

/// The moduli that give each recording its frequency.
std::vector<double> apparent_moduli(const JointStart& models,
                                    std::span<const RecordedSwing> swings) {
    std::vector<double> moduli;
    for (std::size_t m = 0; m < models.size(); ++m)
        moduli.push_back(matching_modulus(models[m].spec, swings[m].mode.frequency));
    return moduli;
}

/// Each recording with a size of its own beside one modulus.
JointStart with_own_sizes(JointStart start, const std::string& name, double youngs_modulus,
                          std::span<const RecordedSwing> swings) {
    set_modulus(youngs_modulus, start);
    for (std::size_t m = 0; m < start.size(); ++m)
        if (const calibrate::FreeParameter* const size = find(start[m], name)) {
            const double wanted = std::log(swings[m].mode.frequency);
            match(*size, start[m].spec, [&](const run::CaseSpec& spec) {
                return std::log(first_frequency(spec)) - wanted;
            });
        }
    return start;
}

/// All recordings with the size at which the highest and the lowest modulus become one.
JointStart with_shared_size(JointStart start, const std::string& name,
                            std::span<const RecordedSwing> swings) {
    const std::vector<double> moduli = apparent_moduli(start, swings);
    const auto [low, high] = std::ranges::minmax_element(moduli);
    const auto lowest = static_cast<std::size_t>(low - moduli.begin());
    const auto highest = static_cast<std::size_t>(high - moduli.begin());
    const calibrate::FreeParameter* const size = find(start[lowest], name);
    const calibrate::FreeParameter* const other = find(start[highest], name);
    if (size == nullptr || other == nullptr)
        return start;
    match(*size, start[lowest].spec, [&](const run::CaseSpec& spec) {
        run::CaseSpec second = start[highest].spec;
        other->access.set(second, size->access.get(spec));
        return std::log(matching_modulus(second, swings[highest].mode.frequency) /
                        matching_modulus(spec, swings[lowest].mode.frequency));
    });
    const double value = size->access.get(start[lowest].spec);
    for (calibrate::StemModel& model : start)
        if (const calibrate::FreeParameter* const own = find(model, name))
            own->access.set(model.spec, value);
    double sum = 0.0;
    for (const double modulus : apparent_moduli(start, swings))
        sum += std::log(modulus);
    set_modulus(std::exp(sum / static_cast<double>(start.size())), start);
    return start;
}

std::set<std::string> new_sizes(const JointStart& models,
                                std::span<const calibrate::ChainFit> smaller) {
    std::set<std::string> names;
    for (const calibrate::StemModel& model : models)
        for (const calibrate::FreeParameter& parameter : model.parameters)
            if (!parameter.is_place && parameter.access.name.find('.') != std::string::npos &&
                std::ranges::all_of(smaller, [&](const calibrate::ChainFit& fit) {
                    return fit.find(parameter.access.name) == nullptr;
                }))
                names.insert(parameter.access.name);
    return names;
}

} // namespace

RecordedSwing recorded_swing(const measure::Measurement& measurement,
                             const CandidateOptions& options) {
    const calibrate::StemModel model = calibrate::baseline_model(measurement, options.chain);
    const double natural = run::natural_frequency(model.spec);
    const double ratio =
        std::min(std::numbers::pi * natural * calibrate::damping_time(model.spec), 0.99);
    const double share = std::sqrt(1.0 - ratio * ratio);
    RecordedSwing swing;
    swing.mode.frequency = natural * share;
    swing.mode.decay_per_cycle = -2.0 * std::numbers::pi * ratio / share;
    swing.mode.decay_rate = swing.mode.decay_per_cycle * swing.mode.frequency;
    swing.cycles = swing.mode.frequency * measurement.times.back();
    swing.tip_deflection = model.spec.tip_deflection;
    return swing;
}

std::vector<JointStart> shared_starts(const JointStart& models,
                                      std::span<const calibrate::ChainFit> alone,
                                      std::span<const RecordedSwing> swings) {
    JointStart own;
    for (std::size_t m = 0; m < models.size(); ++m)
        own.push_back(calibrate::started_from(models[m], alone[m]));
    const auto with_value_of = [&](const auto& value_of) {
        JointStart start = own;
        for (calibrate::StemModel& model : start)
            for (const calibrate::FreeParameter& parameter : model.parameters)
                if (!belongs_to_recording(parameter.access.name))
                    parameter.access.set(model.spec, value_of(parameter));
        return start;
    };
    std::vector<JointStart> starts{with_value_of([&](const calibrate::FreeParameter& parameter) {
        return weighted_mean(parameter.access.name, alone, parameter.access.get(own.front().spec));
    })};
    if (disagreement(starts.front(), swings) < same_phase)
        return starts;
    for (const calibrate::StemModel& one : own)
        starts.push_back(with_value_of([&](const calibrate::FreeParameter& parameter) {
            const calibrate::FreeParameter* const found = find(one, parameter.access.name);
            return (found != nullptr ? *found : parameter).access.get(one.spec);
        }));
    return starts;
}

std::vector<JointStart> reconciling_starts(const JointStart& models,
                                           std::span<const calibrate::ChainFit> smaller,
                                           std::span<const RecordedSwing> swings) {
    const double before = disagreement(models, swings);
    std::vector<JointStart> starts;
    if (!(before >= same_phase))
        return starts;
    JointStart start = models;
    for (std::size_t m = 0; m < start.size(); ++m) {
        // A joint fit that misses cycles bends these too.
        start[m].release_time = 0.0;
        if (find(start[m], "tip_deflection") != nullptr)
            start[m].spec.tip_deflection = swings[m].tip_deflection;
    }
    const auto keep_if_reconciled = [&](JointStart candidate) {
        if (!(disagreement(candidate, swings) < needed_share * before))
            return;
        try {
            keep_decay(swings, candidate);
        } catch (const core::NumericalError&) {
            return; // no chain that vibrates: a fit could not begin there either
        }
        starts.push_back(std::move(candidate));
    };
    for (const std::string& name : new_sizes(models, smaller)) {
        if (!belongs_to_recording(name)) {
            keep_if_reconciled(with_shared_size(start, name, swings));
            continue;
        }
        std::vector<double> moduli = apparent_moduli(start, swings);
        std::ranges::sort(moduli, std::greater{});
        for (const double modulus : {moduli.front(), moduli.back()})
            keep_if_reconciled(with_own_sizes(start, name, modulus, swings));
    }
    return starts;
}

} // namespace culm::diagnose
