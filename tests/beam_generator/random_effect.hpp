// SPDX-License-Identifier: BSD-3-Clause
// Effects of random strength, on the scales of a stem and its pull.
#pragma once

#include "beam_generator/hidden_effect.hpp"
#include "beam_generator/random_number.hpp"
#include "measure/folder/measurement.hpp"

#include <cmath>
#include <cstdint>
#include <string_view>

namespace culm::beam {

/// The random numbers of one case, in the order in which they are asked for.
class Dice {
  public:
    explicit Dice(RandomPlace start) : place_(start) {}

    [[nodiscard]] double between(double low, double high) { return low + (high - low) * next(); }
    [[nodiscard]] double log_between(double low, double high) {
        return low * std::pow(high / low, next());
    }
    [[nodiscard]] int whole(int low, int high) {
        return low + static_cast<int>(next() * (high - low + 1));
    }
    [[nodiscard]] double sign() { return next() < 0.5 ? -1.0 : 1.0; }
    [[nodiscard]] bool happens(double probability) { return next() < probability; }

  private:
    [[nodiscard]] double next() {
        const double value = uniform(place_);
        ++place_.index;
        return value;
    }

    RandomPlace place_;
};

/// Sets the scales of the strengths.
struct Pull {
    BeamStem stem;
    double tip_deflection = 0.0; ///< m
    double hold_time = 10.0;     ///< before the release, s
    measure::GravityDirection gravity = measure::GravityDirection::None;
};

/// The effect `name` with random parameters. Throws core::InputError for an unknown name.
[[nodiscard]] HiddenEffect random_effect(std::string_view name, const Pull& pull, Dice& dice);

} // namespace culm::beam
