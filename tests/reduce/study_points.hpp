// SPDX-License-Identifier: BSD-3-Clause
// Synthetic studies for the tests of the regressions.
#pragma once

#include "reduce/study_regression.hpp"

#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

namespace culm::reduce::testing {

struct StudyData {
    std::vector<double> modulus; // Pa
    std::vector<double> damping;
    std::vector<double> decay;
    std::vector<double> frequency; // Hz
    [[nodiscard]] StudyPoints view() const { return {modulus, damping, decay, frequency}; }
    void add(double y, double beta, double b1, double b2) {
        modulus.push_back(y);
        damping.push_back(beta);
        decay.push_back(b1);
        frequency.push_back(b2);
    }
};

/// The paper's factorial, Y = 1 … 10 GPa, β = 25 … 200, with readings that obey Eqs. 12 and 13
/// up to normal scatter of the given size in √Y (√Pa) and β.
inline StudyData paper_study(double root_scatter, double damping_scatter, std::uint64_t seed = 1) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal(0.0, 1.0);
    StudyData study;
    for (int i = 1; i <= 10; ++i) {
        for (int j = 1; j <= 8; ++j) {
            const double modulus = 1e9 * i;
            const double damping = 25.0 * j;
            const double root = std::sqrt(modulus) + root_scatter * normal(random);
            const double seen_damping = damping + damping_scatter * normal(random);
            study.add(modulus, damping, (seen_damping - 2.5) / -261.4, (root - 91.4) / 574.3);
        }
    }
    return study;
}

} // namespace culm::reduce::testing
