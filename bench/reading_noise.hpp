// SPDX-License-Identifier: BSD-3-Clause
// Noise of readings that a fit does not assume: correlated in time, common to the rows, with long
// tails, rounded.
#pragma once

#include "measure/folder/measurement.hpp"

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <random>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace culm::bench {

/// The families of Noise other than white noise.
inline constexpr std::array<std::string_view, 7> noise_families{
    "ar05", "ar09", "ar05_common", "ar09_common", "student", "outliers", "quantised"};

/// Errors of variance 1 of a family, (times, heights), before tails and rounding; of any other name
/// they are white.
///
/// * ar05, ar09: first-order autoregression with a correlation of 0.5 or 0.9 from frame to frame;
///   with _common half of the variance is one series that all rows share;
/// * student: Student's t with three degrees of freedom (variance 3);
/// * outliers: 3 % of the readings have an additional error of 15;
/// * quantised: white, and readings are multiples of twice the size.
class Noise {
  public:
    /// An autoregression of any correlation from 0 to less than 1.
    struct Autoregression {
        double correlation = 0.0;
        bool is_common = false; ///< half of the variance is one series that all rows share
    };
    Noise(Autoregression series, std::uint64_t number) : series_(series), dice_(number) {}

    Noise(const std::string& family, std::uint64_t number)
        : Noise(Autoregression{.correlation = family.starts_with("ar05")   ? 0.5
                                              : family.starts_with("ar09") ? 0.9
                                                                           : 0.0,
                               .is_common = family.ends_with("_common")},
                number) {
        family_ = family;
    }

    /// Adds errors of standard deviation `size`, m, to the readings.
    void add(double size, measure::Measurement& measurement) {
        const std::size_t rows = measurement.heights.size();
        const double correlation = series_.correlation;
        std::vector<double> state(rows + 1);
        for (double& each : state)
            each = normal_(dice_);
        for (std::size_t i = 0; i < measurement.times.size(); ++i) {
            for (double& each : state)
                each = correlation * each +
                       std::sqrt(1.0 - correlation * correlation) * normal_(dice_);
            for (std::size_t j = 0; j < rows; ++j) {
                double& reading = measurement.deflections[i * rows + j];
                // Half of the variance is common.
                reading += size * (series_.is_common ? std::sqrt(0.5) * (state[j] + state[rows])
                                                     : scattered(state[j]));
                if (family_ == "quantised")
                    reading = 2.0 * size * std::round(reading / (2.0 * size));
            }
        }
    }

  private:
    [[nodiscard]] double scattered(double value) {
        if (family_ == "student") {
            double sum = 0.0;
            for (int k = 0; k < 3; ++k)
                sum += std::pow(normal_(dice_), 2);
            return value / std::sqrt(sum / 3.0);
        }
        if (family_ == "outliers" && share_(dice_) < 0.03)
            return value + 15.0 * normal_(dice_);
        return value;
    }

    Autoregression series_;
    std::string family_;
    std::mt19937_64 dice_;
    std::normal_distribution<double> normal_;
    std::uniform_real_distribution<double> share_;
};

} // namespace culm::bench
