// SPDX-License-Identifier: BSD-3-Clause
// A model of a measured stem: a case with its effects, and which of its numbers may be fitted.
#pragma once

#include "fit/chain/observed_recording.hpp"
#include "fit/chain/parameter.hpp"
#include "fit/chain/stem_chain.hpp"
#include "physics/effects/selection.hpp"

#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace culm::fit {

/// The fit only knows the free parameters, whatever physics the case contains. The moment of the
/// release is known to about a frame, so it is one of them: the stem is held before release_time,
/// and the case runs from there. If a recording begins while the stem swings, its release was not
/// recorded; it is half a period earlier and determines amplitude and phase of the first mode.
struct StemModel {
    run::CaseSpec spec;                            ///< with the values from which a fit starts
    std::vector<FreeParameter> parameters;         ///< of the case, in the order of all results
    double release_time = 0.0;                     ///< on the measurement's clock, s
    double release_time_bound = 0.0;               ///< about the expected one; 0: it is not free
    std::vector<std::string> remarks;              ///< omissions, one sentence each
    std::shared_ptr<const ReadingErrors> errors{}; ///< fitted ones, of the recording; null: none
    double exposure{};                             ///< over which a reading is a mean, s
    double expected_release{};                     ///< s; 0 if the recording shows it
    std::vector<double> error_values{};            ///< (terms of the errors)

    /// The fitted numbers: the parameters, the release time if it is free, then the fitted error
    /// terms, each with a Gaussian constraint of mean 0 and standard deviation 1.
    [[nodiscard]] std::vector<physics::ParameterId> free_ids() const;
    [[nodiscard]] std::size_t free_count() const { return first_error() + error_values.size(); }
    /// Index of the first error term among the fitted numbers.
    [[nodiscard]] std::size_t first_error() const {
        return parameters.size() + (release_time_bound > 0.0 ? 1 : 0);
    }
    [[nodiscard]] bool is_error(std::size_t k) const { return k >= first_error(); }
    [[nodiscard]] const ErrorTerm& error_term(std::size_t k) const {
        return errors->terms[k - first_error()];
    }
    /// Index of a free parameter of the case; the parameter count if it is not free.
    [[nodiscard]] std::size_t place_of(const physics::ParameterId& id) const;
    [[nodiscard]] double value(std::size_t k) const; ///< of the fitted number, SI units
    void set_value(std::size_t k, double value);
    [[nodiscard]] std::pair<double, double> bounds(std::size_t k) const; ///< of its value
    /// The coordinate in which it is fitted.
    [[nodiscard]] physics::FittedAs fitted_as(std::size_t k) const {
        return k < parameters.size() ? parameters[k].fitted_as : physics::FittedAs::Itself;
    }
    /// d coordinate/d value of the fitted number.
    [[nodiscard]] double coordinate_slope(std::size_t k) const {
        return fit::coordinate_slope(fitted_as(k), value(k));
    }
};

/// The prediction of a model for a recording.
struct ChainPrediction {
    int spheres = 0; ///< of the chain
    std::size_t frames = 0;
    std::size_t rows = 0;
    std::size_t parameters = 0;
    int batches = 0;              ///< of lanes that were run; of models together in one of them
    std::vector<double> readings; ///< (frames, rows), m; NaN beyond the model's stem
    /// (frames, rows, parameters), m per unit of each free parameter's coordinate.
    std::vector<double> jacobian;
};

/// The case that is computed: that of the model with Y and β changed by its error terms.
[[nodiscard]] run::CaseSpec computed_case(const StemModel& model);

/// The computed case as a model without free parameters and error terms.
[[nodiscard]] StemModel fixed_model(StemModel model);

/// The number `parameter` of the effect of that name in a case, called "effect.parameter", with the
/// bounds and the scale that suit the stem. The bounds for any stem span many decades, and a value
/// that is small for all stems would count as lying at a bound. The case must contain the effect
/// when the number is read or set.
[[nodiscard]] FreeParameter effect_parameter(const physics::Effect& effect,
                                             const physics::StemParameters<double>& stem,
                                             std::size_t parameter);

/// Appends the effect to the model's case with the user's fixed values and, for the rest, the
/// defaults that suit the stem; parameters that are calibrated and not fixed become free. Values
/// that the measurement states (direction of gravity, time of the hold) are used unless the user
/// fixes them. Throws core::InputError if the effects cannot be combined, or gravity has no
/// direction.
[[nodiscard]] StemModel with_effect(StemModel model, const physics::SelectedEffect& selected,
                                    const measure::Measurement& measurement);

using SelectedEffects = std::vector<physics::SelectedEffect>;

/// The same effects in the library's order, then users' effects by name, so that results do not
/// depend on the order in which effects are named.
[[nodiscard]] SelectedEffects in_library_order(SelectedEffects effects);

/// Is an effect of the same name among `effects`?
[[nodiscard]] bool contains(const SelectedEffects& effects, const physics::SelectedEffect& wanted);

/// "baseline", then the effects' names in the given order.
[[nodiscard]] std::vector<std::string> model_names(const SelectedEffects& effects);

/// `baseline`, with its values, and the effects, with the defaults that suit the stem; their
/// parameters are free unless the user fixed them, within the bounds that suit the stem. Throws
/// core::InputError if the effects cannot be combined, or gravity has no direction.
[[nodiscard]] StemModel candidate_model(const StemModel& baseline, const SelectedEffects& effects,
                                        const measure::Measurement& measurement);

/// The model for a recording with error terms: those that it has keep their values, the others are
/// 0.
[[nodiscard]] StemModel with_error_terms(StemModel model, const ObservedRecording& recording);

/// Changes Y and β until the first mode has this frequency (Hz, without damping) and decay rate
/// (1/s, negative), to first order in the damping. A frequency with a relative error of 1/N is a
/// cycle off after N cycles, and no gradient leads back: a start keeps the first mode of the
/// readings.
void set_first_mode(double frequency, double decay_rate, StemModel& model);

/// Changes Y and β until the model's case has the frequency and decay of the first mode of
/// `wanted`, to first order in the damping.
void keep_first_mode(const run::CaseSpec& wanted, StemModel& model);

/// The model with another division of its stem and the same first mode.
[[nodiscard]] StemModel with_spheres(StemModel model, int spheres);

/// Has every effect a size that a fit can make vanish, so that the model contains the one without?
[[nodiscard]] bool is_nested(const StemModel& model);

/// Was the stem pulled aside, or does an effect move a stem that is held straight: gravity across
/// it, a natural curvature, a moving support, or a user's law?
[[nodiscard]] bool can_move(const StemModel& model, const measure::Measurement& recording);

/// The candidates for these recordings: gravity only if its direction is known.
[[nodiscard]] SelectedEffects candidate_effects(std::span<const measure::Measurement> recordings);

} // namespace culm::fit
