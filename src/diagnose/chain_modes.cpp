// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/chain_modes.hpp"

#include "integrate/slowest_mode.hpp"
#include "run/case_model.hpp"

#include <cmath>
#include <numbers>

namespace culm::diagnose {
namespace {

/// By how much the branches stiffen bending at an angular frequency: Σ g (ωτ)²/(1 + (ωτ)²).
double branch_stiffening(const physics::ChainModel<double>& model, double angular_frequency) {
    double sum = 0.0;
    for (const physics::MaxwellBranch<double>& branch : model.branches) {
        const double square = std::pow(angular_frequency * branch.relaxation_time, 2);
        sum += branch.relative_stiffness * square / (1.0 + square);
    }
    return sum;
}

std::vector<integrate::VibrationMode> slowest(const integrate::LinearisedChain& chain,
                                              std::size_t count) {
    if (count != 1)
        return integrate::vibration_modes(chain, count);
    const auto mode = integrate::slowest_mode(chain);
    return mode ? std::vector{*mode} : std::vector<integrate::VibrationMode>{};
}

} // namespace

std::vector<integrate::VibrationMode> chain_modes(const run::CaseSpec& spec, std::size_t count) {
    run::CaseSpec planar = spec;
    planar.dimensions = 2;
    std::erase_if(planar.effects,
                  [](const auto& active) { return active.effect->dimensions() > 2; });
    const physics::ChainModel<double> model = run::case_model(planar).chain;
    const physics::Chain<2, double> chain(planar.stem.sphere_count, model, planar.law);
    std::vector<integrate::VibrationMode> modes =
        slowest(integrate::linearise_transverse(chain), count);
    if (modes.empty())
        return modes;
    const double factor =
        std::sqrt(1.0 + branch_stiffening(model, 2.0 * std::numbers::pi * modes.front().frequency));
    for (integrate::VibrationMode& mode : modes) {
        mode.frequency *= factor;
        mode.decay_per_cycle /= factor;
    }
    return modes;
}

} // namespace culm::diagnose
