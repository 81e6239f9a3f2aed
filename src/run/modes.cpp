// SPDX-License-Identifier: BSD-3-Clause
#include "run/modes.hpp"

#include "core/error.hpp"
#include "measure/folder/observation.hpp"
#include "run/case_model.hpp"

#include <algorithm>

#include <Eigen/Eigenvalues>
#include <fmt/core.h>

namespace culm::run {
namespace {

/// The case's chain in the plane of the pull, without the effects that leave it and without dry
/// friction.
physics::Chain<2, double> planar_chain(CaseSpec spec) {
    std::erase_if(spec.effects, [](const auto& active) { return active.effect->dimensions > 2; });
    physics::ChainModel<double> model = case_model(spec).chain;
    if (model.hinge) // the damping of dry friction at rest is far above that in a swing
        model.hinge->friction_moment = 0.0;
    return {spec.stem.sphere_count, model, spec.law};
}

constexpr double small_deflection = 1e-6; ///< of the tip, bond lengths

/// The reading of a sensor per deflection of the tip; `shape` (spheres).
double reading_of_shape(const measure::Sensor& sensor, const std::vector<double>& shape,
                        const physics::StemParameters<double>& stem, double height) {
    const double unit = small_deflection * stem.bond_length;
    std::vector<double> positions;
    std::vector<double> rates;
    for (std::size_t i = 0; i < shape.size(); ++i) {
        positions.insert(positions.end(),
                         {static_cast<double>(i) * stem.bond_length, unit * shape[i]});
        rates.insert(rates.end(), {0.0, unit * shape[i]});
    }
    return measure::reading_of_sensor(sensor, {positions, rates, rates}, 2, stem.bond_length,
                                      height, {}) /
           unit;
}

} // namespace

std::vector<integrate::VibrationMode> chain_modes(const CaseSpec& spec, std::size_t count) {
    return integrate::transverse_modes(planar_chain(spec), count);
}

std::vector<ShapedMode> shaped_modes(const CaseSpec& spec, std::size_t count) {
    const integrate::LinearisedChain chain = integrate::linearise_transverse(planar_chain(spec));
    const Eigen::VectorXd scale = chain.mass.cwiseSqrt().cwiseInverse();
    const Eigen::MatrixXd stiffness = scale.asDiagonal() *
                                      (0.5 * (chain.stiffness + chain.stiffness.transpose())) *
                                      scale.asDiagonal();
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(stiffness);
    // The rotation of a clamp comes first, then a displacement and a rotation of each sphere.
    const Eigen::Index spheres = spec.stem.sphere_count - 1;
    const Eigen::Index first = chain.mass.size() - 2 * spheres;
    // A force at the tip deflects it by φ(tip)²/ω² in each mode of unit modal mass.
    const Eigen::Index tip = chain.mass.size() - 2;
    const Eigen::VectorXd compliance = (scale(tip) * solver.eigenvectors().row(tip))
                                           .cwiseAbs2()
                                           .transpose()
                                           .cwiseQuotient(solver.eigenvalues());
    std::vector<ShapedMode> shaped;
    for (const integrate::VibrationMode& mode : chain_modes(spec, count)) {
        const auto k = static_cast<Eigen::Index>(shaped.size());
        const Eigen::VectorXd vector = scale.cwiseProduct(solver.eigenvectors().col(k));
        const auto at = [&](Eigen::Index sphere) {
            return sphere <= 0 ? 0.0 : vector(first + 2 * (sphere - 1));
        };
        ShapedMode& out =
            shaped.emplace_back(ShapedMode{mode, compliance(k) / compliance.sum(), {}});
        for (std::size_t j = 0; j < spec.heights.size(); ++j) {
            if (!measure::is_of_camera(spec.sensors, j)) {
                std::vector<double> shape;
                for (Eigen::Index i = 0; i <= spheres; ++i)
                    shape.push_back(at(i) / at(spheres));
                out.reading.push_back(
                    reading_of_shape(spec.sensors[j], shape, spec.stem, spec.heights[j]));
                continue;
            }
            const double place = spec.heights[j] / spec.stem.bond_length;
            const auto below = std::min(static_cast<Eigen::Index>(place), spheres - 1);
            const double share = place - static_cast<double>(below);
            out.reading.push_back(((1.0 - share) * at(below) + share * at(below + 1)) /
                                  at(spheres));
        }
    }
    return shaped;
}

integrate::VibrationMode first_mode(const CaseSpec& spec) {
    CaseSpec bare = spec;
    bare.effects.clear();
    const auto modes =
        integrate::vibration_modes(integrate::linearise_transverse(planar_chain(bare)), 1);
    if (modes.empty())
        throw core::NumericalError(
            core::FailureKind::FitFailed,
            fmt::format("the chain with Y = {:.6g} Pa and beta = {:.6g} does not vibrate",
                        bare.stem.bond_youngs_modulus, bare.stem.bond_damping));
    return modes.front();
}

integrate::VibrationMode lightly_damped_mode(const CaseSpec& spec) {
    return integrate::lightly_damped_mode(planar_chain(spec));
}

double undamped_period(const CaseSpec& spec) {
    physics::StemParameters<double> stem = spec.stem;
    stem.bond_damping = 0.0;
    const auto modes =
        integrate::vibration_modes(integrate::linearise_transverse(stem, spec.law), 1);
    return 1.0 / modes.front().frequency;
}

} // namespace culm::run
