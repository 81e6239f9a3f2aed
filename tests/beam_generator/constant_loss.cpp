// SPDX-License-Identifier: BSD-3-Clause
#include "beam_generator/constant_loss.hpp"

#include <cmath>
#include <complex>
#include <numbers>

namespace culm::beam {
namespace {

constexpr int branch_count = 10;
constexpr double lowest = 1.0 / 3.0;
constexpr double highest = 40.0;
constexpr int sweeps = 60;

std::complex<double> modulus(const std::vector<RelaxingBranch>& branches, double frequency) {
    std::complex<double> sum = 1.0;
    for (const RelaxingBranch& branch : branches) {
        const std::complex<double> phase(0.0, 2.0 * std::numbers::pi * frequency * branch.time);
        sum += branch.fraction * phase / (1.0 + phase);
    }
    return sum;
}

} // namespace

double loss_factor_at(const std::vector<RelaxingBranch>& branches, double frequency) {
    const std::complex<double> value = modulus(branches, frequency);
    return value.imag() / value.real();
}

std::vector<RelaxingBranch> constant_loss(double loss_factor, double first_frequency) {
    // The row extends a little beyond both ends of the band.
    const double from = 0.5 * lowest * first_frequency;
    const double ratio = std::pow(4.0 * highest / lowest, 1.0 / (branch_count - 1));
    std::vector<RelaxingBranch> branches;
    std::vector<double> frequencies;
    for (int k = 0; k < branch_count; ++k) {
        frequencies.push_back(from * std::pow(ratio, k));
        const double time = 1.0 / (2.0 * std::numbers::pi * frequencies.back());
        // The fraction in an infinite row of branches (Liu et al. 1976).
        branches.push_back({2.0 / std::numbers::pi * loss_factor * std::log(ratio), time, 0.0});
    }
    for (int sweep = 0; sweep < sweeps && loss_factor > 0.0; ++sweep)
        for (std::size_t k = 0; k < branches.size(); ++k)
            branches[k].fraction *= loss_factor / loss_factor_at(branches, frequencies[k]);
    return branches;
}

} // namespace culm::beam
