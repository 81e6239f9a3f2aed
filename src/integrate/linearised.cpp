// SPDX-License-Identifier: BSD-3-Clause
#include "integrate/linearised.hpp"

#include "core/error.hpp"
#include "integrate/bond_jacobian.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

namespace culm::integrate {
namespace {

/// Mass-normalised matrices in units of a reference angular frequency: z̈ + C z' + K z = 0.
struct NormalisedChain {
    Eigen::MatrixXd damping;
    Eigen::MatrixXd stiffness;
    double angular_frequency; ///< 1/s, the unit of time's inverse
};

NormalisedChain normalised(const LinearisedChain& chain, double angular_frequency) {
    const Eigen::VectorXd scale = chain.mass.cwiseSqrt().cwiseInverse();
    const auto diagonal = scale.asDiagonal();
    return {diagonal * chain.damping * diagonal / angular_frequency,
            diagonal * chain.stiffness * diagonal / (angular_frequency * angular_frequency),
            angular_frequency};
}

std::vector<std::complex<double>> eigenvalues_of(const Eigen::MatrixXd& matrix) {
    const Eigen::EigenSolver<Eigen::MatrixXd> solver(matrix, false);
    if (solver.info() != Eigen::Success)
        throw core::NumericalError(core::FailureKind::SolverFailed,
                                   "the eigenvalues of the linearised chain did not converge");
    const auto& values = solver.eigenvalues();
    return {values.data(), values.data() + values.size()};
}

/// [0 I; −K −C]: its eigenvalues are λ.
Eigen::MatrixXd companion(const NormalisedChain& chain) {
    const Eigen::Index n = chain.stiffness.rows();
    Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(2 * n, 2 * n);
    matrix.topRightCorner(n, n).setIdentity();
    matrix.bottomLeftCorner(n, n) = -chain.stiffness;
    matrix.bottomRightCorner(n, n) = -chain.damping;
    return matrix;
}

/// The inverse of the companion matrix, [−K⁻¹C −K⁻¹; I 0]: its eigenvalues are 1/λ.
Eigen::MatrixXd inverse_companion(const NormalisedChain& chain) {
    const Eigen::Index n = chain.stiffness.rows();
    const Eigen::PartialPivLU<Eigen::MatrixXd> factorised(chain.stiffness);
    Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(2 * n, 2 * n);
    matrix.topLeftCorner(n, n) = -factorised.solve(chain.damping);
    matrix.topRightCorner(n, n) = -factorised.inverse();
    matrix.bottomLeftCorner(n, n).setIdentity();
    return matrix;
}

bool slower(const std::complex<double>& a, const std::complex<double>& b) {
    return std::abs(a) < std::abs(b);
}

/// Angular frequency of the slowest undamped mode, about: 1/√‖K⁻¹M‖.
double reference_angular_frequency(const LinearisedChain& chain) {
    const NormalisedChain unit = normalised(chain, 1.0);
    const Eigen::MatrixXd inverse = unit.stiffness.partialPivLu().inverse();
    return 1.0 / std::sqrt(inverse.norm());
}

/// Spectral radius of one velocity-Verlet step of length `step` (in the chain's unit of time).
double spectral_radius(const NormalisedChain& chain, double step) {
    const Eigen::Index n = chain.stiffness.rows();
    Eigen::MatrixXd map(2 * n, 2 * n);
    map.topLeftCorner(n, n).setIdentity();
    map.topRightCorner(n, n) = step * Eigen::MatrixXd::Identity(n, n);
    map.bottomLeftCorner(n, n) = -step * chain.stiffness;
    map.bottomRightCorner(n, n) =
        Eigen::MatrixXd::Identity(n, n) - step * chain.damping - step * step * chain.stiffness;
    const auto values = eigenvalues_of(map);
    return std::abs(*std::max_element(values.begin(), values.end(), slower));
}

/// The degrees of freedom `wanted` (of axial 0, lateral 1, rotation 2) of every moving sphere, and
/// the clamp's rotation if it turns.
LinearisedChain straight_chain(const physics::Chain<2, double>& chain,
                               const std::vector<int>& wanted) {
    const LinearisedChain full = linearise(chain, chain.straight_state());
    std::vector<int> keep;
    if (chain.base_turns())
        keep.push_back(0);
    const int first = static_cast<int>(keep.size());
    for (int sphere = 0; sphere < chain.layout().bond_count(); ++sphere)
        for (const int freedom : wanted)
            keep.push_back(first + 3 * sphere + freedom);
    return {full.mass(keep), full.damping(keep, keep), full.stiffness(keep, keep)};
}

/// What one bond adds to C and K: (forces and torques on both spheres) by (their displacements and
/// rotations), with the sign of a resistance.
template <int Dim>
struct BondMatrices {
    static constexpr int block = Dim + physics::rotation_dimension<Dim>;
    using Pair = Eigen::Matrix<double, 2 * block, 2 * block>;
    Pair damping;
    Pair stiffness;
};

/// Rows (force, torque_1, torque_2) of a bond spread over its spheres, which receive (force,
/// torque_1) and (−force, torque_2); the resistance is minus that.
template <int Dim, class Rows>
typename BondMatrices<Dim>::Pair resistance(const Rows& rows) {
    constexpr int rotation = physics::rotation_dimension<Dim>;
    typename BondMatrices<Dim>::Pair pair;
    pair.template topRows<Dim>() = -rows.template topRows<Dim>();
    pair.template middleRows<rotation>(Dim) = -rows.template middleRows<rotation>(Dim);
    pair.template middleRows<Dim>(BondMatrices<Dim>::block) = rows.template topRows<Dim>();
    pair.template bottomRows<rotation>() = -rows.template bottomRows<rotation>();
    return pair;
}

template <int Dim>
BondMatrices<Dim> bond_matrices(const BondJacobian<Dim>& jacobian) {
    using L = BondJacobianLayout<Dim>;
    constexpr int block = BondMatrices<Dim>::block;
    // Columns of velocity and spins, rearranged to v1, ω1, v2, ω2 (relative velocity v2 − v1).
    Eigen::Matrix<double, L::outputs, 2 * block> by_motion;
    by_motion.template leftCols<Dim>() = -jacobian.template middleCols<Dim>(L::velocity);
    by_motion.template middleCols<L::rotation>(Dim) =
        jacobian.template middleCols<L::rotation>(L::spin_1);
    by_motion.template middleCols<Dim>(block) = jacobian.template middleCols<Dim>(L::velocity);
    by_motion.template rightCols<L::rotation>() =
        jacobian.template middleCols<L::rotation>(L::spin_2);

    // Small displacements change what is local to the bond by its rates' derivatives.
    Eigen::Matrix<double, L::local_rate, 2 * block> by_displacement =
        jacobian.template block<L::local_rate, L::local_size>(0, L::local) *
        by_motion.template bottomRows<L::local_size>();

    const Eigen::Matrix<double, L::local_rate, 2 * block> by_velocity =
        by_motion.template topRows<L::local_rate>();
    return {resistance<Dim>(by_velocity), resistance<Dim>(by_displacement)};
}

/// Adds a bond's matrix where its first sphere is the `position`-th moving one; −1 when that
/// sphere is clamped.
template <int Dim>
void add_bond(const typename BondMatrices<Dim>::Pair& pair, int position, Eigen::MatrixXd& matrix) {
    constexpr int block = BondMatrices<Dim>::block;
    const Eigen::Index start = static_cast<Eigen::Index>(block) * position;
    if (position < 0)
        matrix.topLeftCorner(block, block) += pair.bottomRightCorner(block, block);
    else
        matrix.block(start, start, 2 * block, 2 * block) += pair;
}

/// Resistance of the air, users' forces, and the clamp's moment.
template <int Dim>
void add_outer_forces(const physics::Chain<Dim, double>& chain, const std::vector<double>& state,
                      int first, LinearisedChain& result) {
    constexpr int block = BondMatrices<Dim>::block;
    const auto& layout = chain.layout();
    for (int i = first; i < layout.sphere_count(); ++i) {
        const Eigen::Index place = static_cast<Eigen::Index>(block) * (i - first);
        const auto load = chain.node_load(i, layout.sphere(state.data(), i), {}, 0.0, true);
        for (int column = 0; column < Dim; ++column)
            for (int row = 0; row < Dim; ++row)
                result.damping(place + row, place + column) -=
                    load.by_velocity[static_cast<std::size_t>(column)][row];
        result.stiffness(place + 1, place + 1) -= load.by_deflection;
    }
    if (!chain.base_turns())
        return;
    constexpr int axis = physics::bending_axis<Dim>;
    const auto clamp = chain.clamp_moment(state[layout.base_rotation_offset()],
                                          layout.sphere(state.data(), 0).spin[axis], 0.0, true);
    result.damping(Dim + axis, Dim + axis) -= clamp.by_rate;
    result.stiffness(Dim + axis, Dim + axis) -= clamp.by_rotation;
}

/// Strikes out what a clamp that turns in the plane of bending still holds.
template <int Dim>
LinearisedChain with_turning_base(const LinearisedChain& full) {
    constexpr int block = BondMatrices<Dim>::block;
    std::vector<int> keep{Dim + physics::bending_axis<Dim>};
    for (int k = block; k < static_cast<int>(full.mass.size()); ++k)
        keep.push_back(k);
    return {full.mass(keep), full.damping(keep, keep), full.stiffness(keep, keep)};
}

} // namespace

template <int Dim>
LinearisedChain linearise(const physics::Chain<Dim, double>& chain,
                          const std::vector<double>& state) {
    constexpr int block = BondMatrices<Dim>::block;
    const auto& layout = chain.layout();
    // Sphere 0 takes part if it only turns; its other freedoms are struck out in the end.
    const int first = chain.base_turns() ? 0 : chain.first_moving_sphere();
    const Eigen::Index dof = static_cast<Eigen::Index>(block) * (layout.sphere_count() - first);
    LinearisedChain result{Eigen::VectorXd(dof), Eigen::MatrixXd::Zero(dof, dof),
                           Eigen::MatrixXd::Zero(dof, dof)};
    for (Eigen::Index k = 0; k < dof; ++k)
        result.mass(k) = k % block < Dim
                             ? chain.sphere_inertia(first + static_cast<int>(k) / block).mass
                             : chain.sphere_inertia(first + static_cast<int>(k) / block).moment;

    BondDifferentiator<Dim> differentiator(chain);
    BondJacobian<Dim> jacobian;
    for (int j = 0; j < layout.bond_count(); ++j) {
        differentiator.evaluate(state.data(), j, 0.0, jacobian);
        const BondMatrices<Dim> bond = bond_matrices<Dim>(jacobian);
        add_bond<Dim>(bond.damping, j - first, result.damping);
        add_bond<Dim>(bond.stiffness, j - first, result.stiffness);
    }
    if (!chain.is_plain())
        add_outer_forces(chain, state, first, result);
    return chain.base_turns() && chain.first_moving_sphere() > 0 ? with_turning_base<Dim>(result)
                                                                 : result;
}

template LinearisedChain linearise<2>(const physics::Chain<2, double>&, const std::vector<double>&);
template LinearisedChain linearise<3>(const physics::Chain<3, double>&, const std::vector<double>&);

LinearisedChain linearise_transverse(const physics::StemParameters<double>& stem,
                                     const physics::BondLawOptions& law) {
    return linearise_transverse(physics::Chain<2, double>(stem, law));
}

LinearisedChain linearise_transverse(const physics::Chain<2, double>& chain) {
    return straight_chain(chain, {1, 2});
}

LinearisedChain linearise_axial(const physics::StemParameters<double>& stem,
                                const physics::BondLawOptions& law) {
    return straight_chain(physics::Chain<2, double>(stem, law), {0});
}

std::vector<std::complex<double>> eigenvalues(const LinearisedChain& chain) {
    const NormalisedChain scaled = normalised(chain, reference_angular_frequency(chain));
    std::vector<std::complex<double>> fast = eigenvalues_of(companion(scaled));
    std::vector<std::complex<double>> slow = eigenvalues_of(inverse_companion(scaled));
    for (auto& value : slow)
        value = 1.0 / value;
    std::sort(fast.begin(), fast.end(), slower);
    std::sort(slow.begin(), slow.end(), slower);
    // Each set is accurate at its own end; they meet where both are, in the middle of the spectrum.
    std::copy(slow.begin(), slow.begin() + static_cast<std::ptrdiff_t>(slow.size() / 2),
              fast.begin());
    for (auto& value : fast)
        value *= scaled.angular_frequency;
    return fast;
}

std::vector<VibrationMode> vibration_modes(const LinearisedChain& chain, std::size_t count) {
    const NormalisedChain scaled = normalised(chain, reference_angular_frequency(chain));
    std::vector<std::complex<double>> values = eigenvalues_of(inverse_companion(scaled));
    for (auto& value : values)
        value = scaled.angular_frequency / value;
    std::sort(values.begin(), values.end(), slower);
    std::vector<VibrationMode> modes;
    for (const std::complex<double>& value : values) {
        if (modes.size() == count)
            break;
        if (value.imag() <= 0.0 || !std::isfinite(value.imag()))
            continue;
        const double frequency = value.imag() / (2.0 * std::numbers::pi);
        modes.push_back({frequency, value.real(), value.real() / frequency});
    }
    return modes;
}

double lowest_natural_frequency(const LinearisedChain& chain) {
    constexpr int most_iterations = 100; // each divides the error by (f2/f1)², some 39 for a stem
    constexpr double tolerance = 1e-13;
    const auto stiffness = chain.stiffness.partialPivLu();
    Eigen::VectorXd shape = stiffness.solve(chain.mass);
    double square = 0.0;
    for (int k = 0; k < most_iterations; ++k) {
        const Eigen::VectorXd next = stiffness.solve(chain.mass.cwiseProduct(shape));
        const double last = square;
        square =
            shape.dot(chain.mass.cwiseProduct(shape)) / next.dot(chain.mass.cwiseProduct(shape));
        shape = next / next.norm();
        if (std::abs(square - last) <= tolerance * std::abs(square))
            break;
    }
    return std::sqrt(square) / (2.0 * std::numbers::pi); // NaN of a negative one
}

double largest_stable_step(const LinearisedChain& chain) {
    const NormalisedChain scaled = normalised(
        chain, std::sqrt(chain.stiffness.diagonal().cwiseQuotient(chain.mass).maxCoeff()));
    // An eigenvalue of the one-step map reaches −1 where 4M − 2hC − h²K is singular: with s = 1/h
    // that is s² = K/4 + s C/2, whose largest real root is the limit.
    const Eigen::Index n = scaled.stiffness.rows();
    Eigen::MatrixXd pencil = Eigen::MatrixXd::Zero(2 * n, 2 * n);
    pencil.topRightCorner(n, n).setIdentity();
    pencil.bottomLeftCorner(n, n) = 0.25 * scaled.stiffness;
    pencil.bottomRightCorner(n, n) = 0.5 * scaled.damping;
    double inverse_step = 0.0;
    for (const std::complex<double>& root : eigenvalues_of(pencil))
        if (std::abs(root.imag()) <= 1e-9 * std::abs(root))
            inverse_step = std::max(inverse_step, root.real());
    double step = 1.0 / inverse_step;
    // A complex pair may leave the unit circle earlier where C is not symmetric.
    constexpr double tolerance = 1e-9;
    if (spectral_radius(scaled, step * (1.0 - 1e-6)) > 1.0 + tolerance) {
        double stable = 0.0;
        for (int i = 0; i < 40; ++i) {
            const double middle = 0.5 * (stable + step);
            (spectral_radius(scaled, middle) > 1.0 + tolerance ? step : stable) = middle;
        }
        step = stable;
    }
    return step / scaled.angular_frequency;
}

} // namespace culm::integrate
