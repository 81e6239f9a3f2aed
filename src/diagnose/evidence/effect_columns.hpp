// SPDX-License-Identifier: BSD-3-Clause
// How the readings of a fitted model change when an effect is added to it.
#pragma once

#include "fit/fit_model.hpp"

#include <cmath>
#include <limits>
#include <span>
#include <string>
#include <vector>

namespace culm::diagnose {

/// Change of the readings by a size of the prior's standard deviation.
struct EffectColumn {
    Eigen::VectorXd readings; ///< (rows of the fit's system)
    /// Index of the effect's free parameter that is the size; none if only the location changes the
    /// readings, or if the effect has no free parameter.
    std::size_t parameter = std::numeric_limits<std::size_t>::max();
    bool is_one_sided = false;
    bool is_certain = false;      ///< it acts with exactly this size
    double secant = 0.0;          ///< size at the end of a secant; 0: a derivative
    double absent = 0.0;          ///< of a size: coordinate where the effect is absent
    double deviation = 1.0;       ///< of a size: that of its prior, by its coordinate
    double known_amount = 0.0;    ///< mean of the prior in standard deviations from the absence …
    double known_precision = 1.0; ///< … and its precision; these of a size that is not known

    /// Up to which the readings are linear: for a derivative in standard deviations of the prior,
    /// for a secant in units of its length.
    [[nodiscard]] double largest_amount() const {
        return secant == 0.0 ? 3.0 : 2.0 * std::abs(secant);
    }
};

/// An effect at one point of the grid of its locations, angles and time constants.
struct EffectNode {
    /// Values of the effect's free parameters at this point; sizes where the columns begin.
    std::vector<double> values;
    double modulus_ratio = 1.0; ///< of Y there to that of the fitted model
    double damping_ratio = 1.0; ///< likewise of β
    std::vector<EffectColumn> columns;

    /// Does the location alone change the model, as the spring of a clamp with friction does? The
    /// first column is then that change.
    [[nodiscard]] bool has_offset() const {
        return !columns.front().is_certain &&
               columns.front().parameter == std::numeric_limits<std::size_t>::max();
    }
};

struct EffectColumns {
    std::string failure; ///< why there are no columns; empty if there are some
    std::vector<EffectNode> nodes;
    int batches = 0; ///< of lanes that were run

    /// The number of columns of all nodes.
    [[nodiscard]] Eigen::Index column_count() const;
};

/// Columns at every point of the effect's grid: derivatives by its sizes where it is absent. If
/// first derivatives may be weak (a soft clamp, an elliptic section, a slow release), also
/// secants to its usual sizes with the first mode kept.
[[nodiscard]] EffectColumns effect_columns(const fit::Fit& base,
                                           const physics::SelectedEffect& effect,
                                           std::span<const fit::ObservedRecording> recordings,
                                           const fit::FitOptions& options);

} // namespace culm::diagnose
