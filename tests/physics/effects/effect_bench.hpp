// SPDX-License-Identifier: BSD-3-Clause
// Applies effects to a stem and inspects the resulting model.
#pragma once

#include "physics/effects/library.hpp"

#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace culm::physics {

/// One effect of the library with values for its parameters.
inline ActiveEffect active(const std::string& name, std::vector<double> values) {
    return {effect_named(name), std::move(values)};
}

// Both sides evaluate the same few products and sums; they may differ by rounding.
inline constexpr double rounding = 1e-13;

inline void expect_relative(double value, double expected, double tolerance = rounding) {
    EXPECT_NEAR(value, expected, tolerance * std::abs(expected));
}

/// The model of a stem with effects.
struct EffectBench {
    StemParameters<double> stem;
    BondLawOptions law = consistent_law();
    ChainModel<double> model;
    CameraView camera;

    explicit EffectBench(const std::vector<ActiveEffect>& effects, int sphere_count = 56,
                         const StemParameters<double>& of = {})
        : stem(of) {
        const double length = stem.free_length();
        stem.sphere_count = sphere_count;
        stem.bond_length = length / static_cast<double>(sphere_count - 1);
        model = plain_chain(stem, law);
        EffectTarget target{stem, law, model, camera};
        apply_effects(effects, target);
    }

    [[nodiscard]] BondCoefficients<double> plain_bond() const {
        return make_bond_coefficients(stem, law);
    }
    /// Middle of a bond over the stem's length.
    [[nodiscard]] double place_of_bond(std::size_t j) const {
        return (static_cast<double>(j) + 0.5) / static_cast<double>(stem.sphere_count - 1);
    }
    [[nodiscard]] double mass() const {
        double sum = 0.0;
        for (const SphereInertia<double>& sphere : model.spheres)
            sum += sphere.mass;
        return sum;
    }
};

} // namespace culm::physics
