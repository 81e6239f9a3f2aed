// SPDX-License-Identifier: BSD-3-Clause
// The contribution of one stem to the numbers that the stems of a rig share: a gradient and a Schur
// complement. Their sum is one Newton step of all stems.
#pragma once

#include "fit/fit.hpp"
#include "physics/effects/effect.hpp"

#include <map>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace culm::diagnose {

/// An effect of a rig with one value of each parameter for all stems on it.
struct RigEffect {
    physics::SelectedEffect effect; ///< as a candidate; the user's fixed values stay
    std::string rig;
    std::vector<double> values; ///< (parameters of the effect), SI units
    bool is_known = false;      ///< the user states that it acts

    /// "quadratic_drag.drag_coefficient of rig A".
    [[nodiscard]] std::string shared_name(const std::string& parameter) const;
};

/// Indices of the effect's parameters that a fit may change, in the order of its free parameters.
[[nodiscard]] std::vector<std::size_t> free_parameters(const physics::SelectedEffect& effect);

/// Quadratic model of ½ χ² of a stem by shared numbers, with the stem's own numbers eliminated. The
/// coordinate of a parameter is as in ParameterPrior; that of an error term is its value.
struct SharedBlock {
    std::vector<std::string> names; ///< (shared)
    std::vector<double> at;         ///< (shared) coordinates about which the model is made
    std::vector<double> gradient; ///< (shared) −d(½ χ²)/d coordinate, without the terms' priors
    std::vector<double> information; ///< (shared · shared)
    /// (own · shared) change of the fitted numbers per change of a coordinate; own: as free_ids of
    /// the joint model in which the shared parameters are fixed.
    std::vector<double> follow;

    [[nodiscard]] Eigen::Index size() const { return static_cast<Eigen::Index>(names.size()); }
};

template <class Wire>
void fields(Wire& wire, SharedBlock& block) {
    wire(block.names, block.at, block.gradient, block.information, block.follow);
}

/// Readings of a fit with further free parameters: those of its rig's effects. Shared error terms
/// have no constraint here, because it counts once for all stems.
struct SharedReadings {
    fit::WeightedSystem system;
    std::vector<Eigen::Index> own;    ///< columns of the stem's own numbers
    std::vector<Eigen::Index> shared; ///< columns of the shared ones
    std::vector<std::string> names;   ///< (shared)
    std::vector<double> at;           ///< (shared)
    Eigen::MatrixXd columns;          ///< (rows, shared) per coordinate
};

/// `fit` has parts; `effects` of its rig have fixed values in it; `shared_terms` are names of error
/// terms. Runs each recording once. Throws core::NumericalError.
[[nodiscard]] SharedReadings shared_readings(const fit::Fit& fit,
                                             std::span<const fit::ObservedRecording> recordings,
                                             std::span<const RigEffect> effects,
                                             const std::vector<std::string>& shared_terms,
                                             const run::Heartbeat& heartbeat);

[[nodiscard]] SharedBlock block_of(const SharedReadings& readings);

/// The prior of a shared number, in its coordinate.
struct SharedPrior {
    double mean = 0.0;
    double precision = 1.0;
    double lower = -1e300;
    double upper = 1e300;
};

/// The minimum of the sum of the stems' quadratic models and the priors.
struct SharedMinimum {
    std::vector<std::string> names;   ///< in alphabetical order
    Eigen::VectorXd at;               ///< (names) coordinates, within the bounds
    Eigen::MatrixXd hessian;          ///< (names, names)
    std::vector<double> stem_changes; ///< (stems) of −½ χ² from each block's `at` to here

    /// Index of a name; −1: none.
    [[nodiscard]] Eigen::Index find(const std::string& name) const;
    /// Inverse of the Hessian, (names, names).
    [[nodiscard]] Eigen::MatrixXd covariance() const;
};

/// `variances` (stems) divide the blocks: the noise over what the fits assumed. The sum is in the
/// order of the stems, so that any number of ranks gives the same bits.
[[nodiscard]] SharedMinimum minimum_of(std::span<const SharedBlock> blocks,
                                       std::span<const double> variances,
                                       const std::map<std::string, SharedPrior>& priors);

} // namespace culm::diagnose
