// SPDX-License-Identifier: BSD-3-Clause
// Numbers that several stems share: those of the effects of their rig, and error terms of its
// camera.
//
// Each stem s has own numbers θ_s; all stems on a rig have the shared numbers φ. At given φ every
// stem is fitted alone. About these fits ½ χ² of stem s, with θ_s eliminated, is a quadratic form
//
//     ½ χ²_s(φ + δ) = ½ χ²_s(φ) − g_s·δ + ½ δᵀ A_s δ,   A_s = (H_φφ − H_φθ H_θθ⁻¹ H_θφ)_s
//
// (a Schur complement), and θ_s follows by −H_θθ⁻¹ H_θφ δ. The sum of these forms and of the priors
// of φ gives the next φ: one Newton step of all stems. Written by hand, because the stems are
// computed on different ranks and each returns one small block; a solver of sparse problems would
// need all Jacobians in one process.
//
// Traps: the sum is in the order of the stems, so that any number of ranks gives the same bits. An
// error term that several stems have counts its prior once.
#pragma once

#include "fit/fit.hpp"

#include <map>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace culm::diagnose {

/// Which numbers of a stem are shared.
struct Sharing {
    std::map<std::string, std::string> rig_of; ///< by effect, of those that belong to a rig
    std::vector<std::string> terms;            ///< ids of error terms

    /// The effects of the rig, which are held in a stem's fit.
    [[nodiscard]] std::vector<std::string> held() const;
};

/// "quadratic_drag.drag_coefficient of rig A".
[[nodiscard]] std::string shared_name(const std::string& effect, const std::string& parameter,
                                      const std::string& rig);

/// The weighted system of a stem by owner of the columns.
struct SharedColumns {
    std::vector<std::string> names;    ///< of the shared numbers
    std::vector<double> at;            ///< (names) coordinates; of an error term its value
    std::vector<Eigen::Index> columns; ///< (names) of the system
    std::vector<Eigen::Index> own;     ///< the other columns
    fit::WeightedSystem system;        ///< without the constraints of shared terms
};

/// `fit` has parts; the effects of the rig are held in it (FitOptions::held_effects).
[[nodiscard]] SharedColumns shared_columns(const fit::Fit& fit,
                                           std::span<const fit::ObservedRecording> recordings,
                                           const Sharing& sharing);

/// The quadratic form of one stem.
struct SharedBlock {
    std::vector<std::string> names; ///< (shared)
    Eigen::VectorXd at;             ///< (shared) coordinates about which it is made
    Eigen::VectorXd gradient;       ///< (shared) g, without the priors of terms
    Eigen::MatrixXd information;    ///< (shared, shared) A
    /// (fitted numbers, shared) change of the stem's numbers per change of a coordinate; without
    /// rows if nothing is shared.
    Eigen::MatrixXd follow;

    [[nodiscard]] Eigen::Index size() const { return std::ssize(names); }
};

[[nodiscard]] SharedBlock block_of(const SharedColumns& stem);

/// The range of a shared number, in its coordinate. Only an error term has a prior; the origin of
/// the others is where they stay if the readings do not determine them.
struct SharedPrior {
    double mean = 0.0;
    double precision = 1.0;
    double lower = -1e300;
    double upper = 1e300;
};

/// The minimum of the sum of the stems' forms and the priors.
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

/// `variances` (stems) divide the blocks: the noise over what the fits assumed. A name without a
/// prior is that of an error term.
[[nodiscard]] SharedMinimum minimum_of(std::span<const SharedBlock> blocks,
                                       std::span<const double> variances,
                                       const std::map<std::string, SharedPrior>& priors);

} // namespace culm::diagnose
