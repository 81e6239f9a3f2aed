// SPDX-License-Identifier: BSD-3-Clause
// Held stems against closed-form beam theory and the elastica.
#include "integrate/statics.hpp"

#include "core/error.hpp"

#include <array>
#include <cmath>
#include <fstream>
#include <sstream>

#include <gtest/gtest.h>

namespace culm::integrate {
namespace {

/// So slender (d/L = 1/300) that shear is negligible: 3EI/(GA L²) = 1e-5 of the deflection.
physics::StemParameters<double> statics_stem(int spheres) {
    physics::StemParameters<double> stem;
    stem.sphere_count = spheres;
    stem.bond_length = 0.15 / (spheres - 1);
    stem.sphere_diameter = stem.bond_length;
    stem.bond_outer_diameter = 0.5e-3;
    return stem;
}

TEST(HeldStem, NeedsTheTipForceOfACantileverAtSmallDeflection) {
    const auto stem = statics_stem(57);
    const double length = stem.free_length();
    const double bending = stem.bond_youngs_modulus * stem.second_moment_of_area();
    const double deflection = 1e-4 * length;
    const physics::Chain<2, double> chain(stem, physics::schramm2019_law());
    const auto held = deflected_equilibrium(chain, deflection);
    const double beam = 3 * bending * deflection / std::pow(length, 3);
    // A chain of rotation springs of n bonds has the compliance Σ(s_i)² l with the springs at the
    // bonds' middles: relative error 1/(4n²) = 8e-5; shear 1e-5; geometry (δ/L)² = 1e-8.
    const int bonds = stem.sphere_count - 1;
    const double discrete = beam / (1.0 - 0.25 / (bonds * bonds));
    EXPECT_NEAR(held.holding_force / discrete, 1.0, 2e-5);
}

TEST(HeldStem, YieldsToShearAsATimoshenkoCantileverWhereItIsStocky) {
    physics::StemParameters<double> stem;
    stem.sphere_count = 41;
    stem.bond_length = 0.05 / 40;
    stem.sphere_diameter = stem.bond_length;
    stem.bond_outer_diameter = 0.02;
    const double length = stem.free_length();
    const double bending = stem.bond_youngs_modulus * stem.second_moment_of_area();
    const double shear = stem.shear_modulus() * stem.section_area();
    const double deflection = 1e-5 * length;
    const physics::Chain<2, double> chain(stem, physics::consistent_law());
    const double compliance = deflection / deflected_equilibrium(chain, deflection).holding_force;
    const double bending_part = std::pow(length, 3) / (3 * bending) * (1.0 - 0.25 / (40.0 * 40.0));
    // Shear is a thirteenth of the compliance here. The geometric error is (δ/L)²; the
    // discretisation has none.
    EXPECT_NEAR(compliance / (bending_part + length / shear), 1.0, 1e-6);
    EXPECT_GT(length / shear, 0.07 * bending_part);
}

/// Tip force and tip coordinates of the inextensible elastica EI θ'' = −F cos θ, θ(0) = 0,
/// θ'(L) = 0, for a given force (classical Runge-Kutta, shooting on θ'(0) by bisection).
struct ElasticaTip {
    double axial;
    double lateral;
};
ElasticaTip elastica(double bending, double length, double force) {
    const auto integrate = [&](double slope, double& end_slope) {
        const int steps = 4000;
        const double h = length / steps;
        std::array<double, 4> y{0.0, slope, 0.0, 0.0}; // θ, θ', x, y
        const auto rate = [&](const std::array<double, 4>& v) {
            return std::array<double, 4>{v[1], -force / bending * std::cos(v[0]), std::cos(v[0]),
                                         std::sin(v[0])};
        };
        for (int i = 0; i < steps; ++i) {
            const auto add = [](const std::array<double, 4>& a, const std::array<double, 4>& b,
                                double s) {
                std::array<double, 4> c{};
                for (std::size_t k = 0; k < 4; ++k)
                    c[k] = a[k] + s * b[k];
                return c;
            };
            const auto k1 = rate(y);
            const auto k2 = rate(add(y, k1, h / 2));
            const auto k3 = rate(add(y, k2, h / 2));
            const auto k4 = rate(add(y, k3, h));
            for (std::size_t k = 0; k < 4; ++k)
                y[k] += h / 6 * (k1[k] + 2 * k2[k] + 2 * k3[k] + k4[k]);
        }
        end_slope = y[1];
        return ElasticaTip{y[2], y[3]};
    };
    double low = 0.0;
    double high = 10.0 / length;
    ElasticaTip tip{};
    for (int i = 0; i < 80; ++i) {
        const double middle = 0.5 * (low + high);
        double end_slope = 0.0;
        tip = integrate(middle, end_slope);
        (end_slope > 0.0 ? high : low) = middle;
    }
    return tip;
}

TEST(HeldStem, FollowsTheElasticaAtThreeTenthsOfItsLength) {
    std::vector<double> force_errors;
    for (const int spheres : {57, 113}) {
        const auto stem = statics_stem(spheres);
        const double length = stem.free_length();
        const double bending = stem.bond_youngs_modulus * stem.second_moment_of_area();
        const physics::Chain<2, double> chain(stem, physics::consistent_law());
        const auto held = deflected_equilibrium(chain, 0.3 * length);
        const auto tip = elastica(bending, length, held.holding_force);
        force_errors.push_back(std::abs(tip.lateral / (0.3 * length) - 1.0));
        const auto sphere = chain.layout().sphere(held.state.data(), spheres - 1);
        // Discretisation 1/(4n²) = 8e-5 for 56 bonds, path error of the load steps below 1e-5,
        // stretch under the axial part of the force 1e-6.
        EXPECT_LT(force_errors.back(), 1.5e-4);
        EXPECT_NEAR(sphere.position[0] / tip.axial, 1.0, 1e-4);
        // The force of a linear cantilever differs by 3 %: the test covers large deflections.
        const double linear = 3 * bending * 0.3 / (length * length);
        EXPECT_GT(std::abs(held.holding_force / linear - 1.0), 0.02);
    }
    EXPECT_LT(force_errors[1], 0.5 * force_errors[0]) << "does not converge with the spheres";
}

TEST(HeldStem, IsTheSameToEitherSideAndInSpace) {
    physics::StemParameters<double> stem;
    stem.sphere_count = 20;
    const physics::Chain<2, double> chain(stem, physics::schramm2019_law());
    const auto left = deflected_equilibrium(chain, -5e-3);
    const auto right = deflected_equilibrium(chain, 5e-3);
    EXPECT_NEAR(left.holding_force / right.holding_force, -1.0, 1e-10);
    const physics::Chain<3, double> spatial(stem, physics::schramm2019_law());
    const auto in_space = deflected_equilibrium(spatial, 5e-3);
    EXPECT_NEAR(in_space.holding_force / right.holding_force, 1.0, 1e-10);
    for (int i = 0; i < 20; ++i) {
        const auto a = chain.layout().sphere(right.state.data(), i);
        const auto b = spatial.layout().sphere(in_space.state.data(), i);
        EXPECT_NEAR(a.position[1], b.position[1], 1e-13);
        EXPECT_NEAR(b.position[2], 0.0, 1e-15);
    }
}

TEST(HeldStem, HasTheShapeThatThePublicCodeSettledTo) {
    // Reference: rest positions from the damped dynamics of another code, nine digits (mm).
    for (const auto& [name, gravity] :
         {std::pair{"Y1_b5", 0.0}, std::pair{"Y1_b5_gravity", -9.81}}) {
        physics::StemParameters<double> stem;
        stem.axial_acceleration_of_gravity = gravity;
        const physics::Chain<2, double> chain(stem, physics::schramm2019_law());
        const auto held = deflected_equilibrium(chain, 14.99924e-3);
        std::ifstream file(std::string(CULM_TEST_DATA_DIR) + "/peer-liggghts/static/" + name +
                           ".csv");
        ASSERT_TRUE(file.good());
        std::string line;
        std::getline(file, line);
        int rows = 0;
        while (std::getline(file, line)) {
            std::replace(line.begin(), line.end(), ',', ' ');
            std::istringstream in(line);
            int sphere = 0;
            double x = 0.0;
            double z = 0.0;
            in >> sphere >> x >> z;
            const auto at = chain.layout().sphere(held.state.data(), sphere - 1);
            // The README rounds the tip's deflection to 5e-9 m. The path error of the load steps is
            // 1e-5 of the rotation, that is 1e-7 m at the tip.
            EXPECT_NEAR(at.position[0], x * 1e-3, 5e-8) << name << " sphere " << sphere;
            EXPECT_NEAR(at.position[1], z * 1e-3, 5e-8) << name << " sphere " << sphere;
            ++rows;
        }
        EXPECT_EQ(rows, 56);
    }
}

TEST(HeldStem, FailsWithTheDeflectionReachedIfNoEquilibriumIsFound) {
    physics::StemParameters<double> stem;
    stem.sphere_count = 20;
    stem.bond_youngs_modulus = std::nan("");
    const physics::Chain<2, double> chain(stem, physics::consistent_law());
    try {
        (void)deflected_equilibrium(chain, 5e-3);
        FAIL() << "a stem without a modulus was accepted";
    } catch (const core::NumericalError& error) {
        EXPECT_EQ(error.kind(), core::FailureKind::StaticFailed);
        EXPECT_NE(std::string(error.what())
                      .find("no equilibrium found beyond a tip deflection of 0 "
                            "mm (5 mm were asked for"),
                  std::string::npos)
            << error.what();
    }
}

} // namespace
} // namespace culm::integrate
