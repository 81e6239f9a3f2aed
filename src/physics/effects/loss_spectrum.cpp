// SPDX-License-Identifier: BSD-3-Clause
#include "physics/effects/loss_spectrum.hpp"

#include <cmath>
#include <numbers>

#include <Eigen/Dense>

namespace culm::physics {

namespace {

constexpr int branch_count = 6;
constexpr int frequencies_a_branch = 8;
/// How far the branches reach beyond the band at both ends. With 2 the loss factor stays within 0.8
/// % of its value from half the first frequency to 20 times it, and no branch becomes negative up
/// to a loss factor of 0.5; without it the branches at the ends have to stand in for those beyond.
constexpr double reach = 2.0;

/// Stiffness of one branch over its spring's: in phase with the strain, and a quarter cycle ahead.
struct BranchResponse {
    double storage;
    double loss;
};

BranchResponse response(double angular_frequency, double relaxation_time) {
    const double x = angular_frequency * relaxation_time;
    return {x * x / (1.0 + x * x), x / (1.0 + x * x)};
}

double angular(double frequency) {
    return 2.0 * std::numbers::pi * frequency;
}

/// `count` numbers from `first` to `last`, even in the logarithm.
double evenly_spaced(double first, double last, int count, int k) {
    return first * std::pow(last / first, static_cast<double>(k) / static_cast<double>(count - 1));
}

} // namespace

std::vector<MaxwellBranch<double>> constant_loss_branches(double loss_factor,
                                                          const FrequencyBand& band) {
    std::vector<MaxwellBranch<double>> branches;
    branches.reserve(branch_count);
    for (int b = 0; b < branch_count; ++b)
        branches.push_back(
            {.relative_stiffness = 0.0,
             .relaxation_time = 1.0 / angular(evenly_spaced(band.lowest / reach,
                                                            reach * band.highest, branch_count, b)),
             .held_share = 0.0});
    constexpr int rows = branch_count * frequencies_a_branch;
    Eigen::Matrix<double, rows, branch_count> lost;
    for (int k = 0; k < rows; ++k) {
        const double omega = angular(evenly_spaced(band.lowest, band.highest, rows, k));
        for (int b = 0; b < branch_count; ++b) {
            const BranchResponse of =
                response(omega, branches[static_cast<std::size_t>(b)].relaxation_time);
            lost(k, b) = of.loss - loss_factor * of.storage;
        }
    }
    const Eigen::Vector<double, branch_count> stiffness =
        lost.colPivHouseholderQr().solve(Eigen::Vector<double, rows>::Constant(loss_factor));
    for (int b = 0; b < branch_count; ++b)
        branches[static_cast<std::size_t>(b)].relative_stiffness = stiffness[b];
    return branches;
}

double loss_factor_of(std::span<const MaxwellBranch<double>> branches, double frequency) {
    double storage = 1.0;
    double loss = 0.0;
    for (const MaxwellBranch<double>& branch : branches) {
        const BranchResponse of = response(angular(frequency), branch.relaxation_time);
        storage += branch.relative_stiffness * of.storage;
        loss += branch.relative_stiffness * of.loss;
    }
    return loss / storage;
}

} // namespace culm::physics
