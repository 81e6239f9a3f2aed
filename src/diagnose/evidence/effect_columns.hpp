// SPDX-License-Identifier: BSD-3-Clause
// How the readings of a fitted model change when an effect joins it.
#pragma once

#include "diagnose/evidence/stacked_readings.hpp"
#include "fit/fit_model.hpp"

#include <limits>
#include <span>
#include <string>
#include <vector>

namespace culm::diagnose {

/// Change of the stacked readings by a size of the prior's standard deviation.
struct EffectColumn {
    std::vector<double> readings; ///< (rows of StackedReadings)
    /// Which free parameter of the effect is the size; none: what the location alone changes, or
    /// an effect without a number to fit.
    std::size_t parameter = std::numeric_limits<std::size_t>::max();
    bool is_one_sided = false;
    bool is_certain = false; ///< it acts with exactly this size
    double secant = 0.0;     ///< size at the end of a secant; 0: a derivative
};

template <class Wire>
void fields(Wire& wire, EffectColumn& column) {
    wire(column.readings, column.parameter, column.is_one_sided, column.is_certain, column.secant);
}

/// An effect at one point of the grid of its locations, angles and time constants.
struct EffectNode {
    /// Of the effect's free parameters at this point; sizes where the columns begin.
    std::vector<double> values;
    double modulus_ratio = 1.0; ///< of Y there to that of the fitted model
    double damping_ratio = 1.0; ///< likewise of β
    std::vector<EffectColumn> columns;
};

template <class Wire>
void fields(Wire& wire, EffectNode& node) {
    wire(node.values, node.modulus_ratio, node.damping_ratio, node.columns);
}

struct EffectColumns {
    std::string failure; ///< why there are none; empty if there are
    std::vector<EffectNode> nodes;
};

template <class Wire>
void fields(Wire& wire, EffectColumns& columns) {
    wire(columns.failure, columns.nodes);
}

/// A candidate about the best model.
struct CandidateView {
    physics::SelectedEffect effect;
    EffectColumns columns;
};

/// stacked_readings() of the fit. If it leaves the plane, `predicted` is computed by planar chains,
/// as the runs that are compared with it. Throws core::NumericalError.
[[nodiscard]] StackedReadings
readings_to_compare(const fit::Fit& base, std::span<const fit::ObservedRecording> recordings,
                    const run::Heartbeat& heartbeat);

/// For every point of the effect's grid: derivatives by its sizes where it is absent, and, where a
/// first derivative may say little (a soft clamp, an elliptic section, a slow release), secants to
/// its usual sizes with the first mode kept. `stacked`: readings_to_compare(base).
[[nodiscard]] EffectColumns effect_columns(const fit::Fit& base, const StackedReadings& stacked,
                                           const physics::SelectedEffect& effect,
                                           std::span<const fit::ObservedRecording> recordings,
                                           const fit::FitOptions& options);

/// An effect of a given size beside a fitted model, with the first mode kept by Y and β.
struct SizedEffect {
    double size = 0.0;          ///< in standard deviations of the prior
    double modulus_ratio = 1.0; ///< of Y there to that of the fitted model
    double damping_ratio = 1.0; ///< likewise of β
    Eigen::VectorXd change;     ///< (rows of StackedReadings) from where it is absent
};

/// The effect in sizes from far too small to be seen up to the usual one, in lanes, the smallest
/// first, with its locations and time constants at their defaults; of an effect without a number to
/// fit, itself. Throws as predict_readings().
struct SizedEffects {
    std::string parameter; ///< that is the size; empty: none
    std::vector<SizedEffect> sizes;
};
[[nodiscard]] SizedEffects effect_at_sizes(const fit::Fit& base, const StackedReadings& stacked,
                                           const physics::SelectedEffect& effect,
                                           std::span<const fit::ObservedRecording> recordings,
                                           const fit::FitOptions& options);

} // namespace culm::diagnose
