// SPDX-License-Identifier: BSD-3-Clause
#include "integrate/modes.hpp"

#include "core/error.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <optional>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

namespace culm::integrate {
namespace {

using Complex = std::complex<double>;

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

std::vector<Complex> eigenvalues_of(const Eigen::MatrixXd& matrix) {
    const Eigen::EigenSolver<Eigen::MatrixXd> solver(matrix, false);
    if (solver.info() != Eigen::Success)
        throw core::NumericalError(core::FailureKind::SolverFailed,
                                   "the eigenvalues of the linearised chain did not converge");
    const auto& values = solver.eigenvalues();
    return {values.data(), values.data() + values.size()};
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

bool slower(const Complex& a, const Complex& b) {
    return std::abs(a) < std::abs(b);
}

/// Spectral radius of one velocity-Verlet step of length `step` (in the chain's unit of time).
double spectral_radius(const NormalisedChain& chain, double step) {
    const Eigen::Index n = chain.stiffness.rows();
    // x' = x + h v, then v' = v − h (K x' + C v): the mass is 1 in this chain's units.
    Eigen::MatrixXd map(2 * n, 2 * n);
    map.topLeftCorner(n, n).setIdentity();
    map.topRightCorner(n, n) = step * Eigen::MatrixXd::Identity(n, n);
    map.bottomLeftCorner(n, n) = -step * chain.stiffness;
    map.bottomRightCorner(n, n) =
        Eigen::MatrixXd::Identity(n, n) - step * chain.damping - step * step * chain.stiffness;
    return std::abs(std::ranges::max(eigenvalues_of(map), slower));
}

constexpr int most_newton_steps = 12;
constexpr double mode_tolerance =
    1e-7; ///< of the last change of λ, relative; the error is its square
/// Largest distance of λ/ω from the start; beyond, it belongs to another mode.
constexpr double farthest = 0.5;
constexpr std::size_t few_modes = 4; ///< for more, computing all of them costs less

struct UndampedMode {
    double angular_frequency; ///< 1/s; NaN where none vibrates
    Eigen::VectorXd shape;    ///< mass-normalised, of length 1
};

UndampedMode lowest_undamped(const LinearisedChain& chain) {
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
    return {std::sqrt(square), chain.mass.cwiseSqrt().cwiseProduct(shape).normalized()};
}

/// Newton's method on the mode near an undamped one of angular frequency ω and of that shape
/// (mass-normalised, length 1), in units of ω, with displacements and rotations scaled alike:
/// (z²M + zC/ω + K/ω²) u = 0.
std::optional<Complex> newton(const LinearisedChain& chain, double angular_frequency,
                              const Eigen::VectorXd& undamped) {
    const NormalisedChain unit = normalised(chain, angular_frequency);
    const Eigen::MatrixXcd stiffness = unit.stiffness.cast<Complex>();
    const Eigen::MatrixXcd damping = unit.damping.cast<Complex>();
    // The start assumes that damping does not change the shape.
    const double half_damping = 0.5 * undamped.dot(damping.real() * undamped);
    const Complex start(-half_damping, std::sqrt(1.0 - half_damping * half_damping));
    Complex z = start;
    Eigen::VectorXcd shape = undamped.cast<Complex>();
    Eigen::VectorXcd normal = shape; // of the shape's length, kept at 1
    for (int k = 0; k < most_newton_steps; ++k) {
        Eigen::MatrixXcd pencil = stiffness + z * damping;
        pencil.diagonal().array() += z * z;
        const Eigen::VectorXcd slope = damping * shape + 2.0 * z * shape;
        const Eigen::VectorXcd next = pencil.partialPivLu().solve(slope);
        // T(z) u = 0 with nᵀu = 1: one Newton step is u ← T⁻¹T'u and z ← z − nᵀu/nᵀT⁻¹T'u.
        const Complex change = normal.dot(shape) / normal.dot(next);
        if (!std::isfinite(std::abs(change)))
            return std::nullopt;
        shape = next / next.norm();
        normal = shape;
        // The first steps adapt the shape to that of the damped mode.
        if (k == 0)
            continue;
        z -= change;
        if (!(std::abs(z - start) < farthest)) // a NaN of aperiodic damping too
            return std::nullopt;
        if (std::abs(change) < mode_tolerance)
            return z;
    }
    return std::nullopt;
}

VibrationMode mode_of(const Complex& eigenvalue) {
    const double frequency = eigenvalue.imag() / (2.0 * std::numbers::pi);
    return {frequency, eigenvalue.real(), eigenvalue.real() / frequency};
}

/// The slowest modes without damping. One alone costs much less than several.
std::vector<UndampedMode> undamped_modes(const LinearisedChain& chain, std::size_t count) {
    if (count == 1)
        return {lowest_undamped(chain)};
    const NormalisedChain unit = normalised(chain, 1.0);
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(
        0.5 * (unit.stiffness + unit.stiffness.transpose()));
    std::vector<UndampedMode> modes;
    for (Eigen::Index k = 0; k < static_cast<Eigen::Index>(count); ++k)
        modes.push_back({std::sqrt(solver.eigenvalues()(k)), solver.eigenvectors().col(k)});
    return modes;
}

/// The slowest modes, each computed from an undamped one; empty if one of the undamped modes leads
/// to no separate mode.
std::vector<VibrationMode> modes_near_undamped(const LinearisedChain& chain, std::size_t count) {
    std::vector<VibrationMode> modes;
    for (const UndampedMode& undamped : undamped_modes(chain, count)) {
        if (!(undamped.angular_frequency > 0.0))
            return {};
        const auto z = newton(chain, undamped.angular_frequency, undamped.shape);
        if (!z)
            return {};
        const VibrationMode mode = mode_of(undamped.angular_frequency * *z);
        if (!modes.empty() && !(mode.frequency > (1.0 + mode_tolerance) * modes.back().frequency))
            return {};
        modes.push_back(mode);
    }
    return modes;
}

/// Relative bending stiffness that the branches add at a frequency ω: Σ g (ωτ)²/(1 + (ωτ)²).
double branch_stiffening(const physics::ChainModel<double>& model, double angular_frequency) {
    double sum = 0.0;
    for (const physics::MaxwellBranch<double>& branch : model.branches) {
        const double square = std::pow(angular_frequency * branch.relaxation_time, 2);
        sum += branch.relative_stiffness * square / (1.0 + square);
    }
    return sum;
}

/// Frequency of a motion over that with relaxed branches; `relaxed`: 1/s.
double frequency_ratio(const physics::ChainModel<double>& model, double relaxed) {
    constexpr int passes = 4; // each multiplies the error by a small part of the stiffening
    double ratio = 1.0;
    for (int pass = 0; pass < passes; ++pass)
        ratio = std::sqrt(1.0 + branch_stiffening(model, ratio * relaxed));
    return ratio;
}

} // namespace

double VibrationMode::damping_ratio() const {
    const double decay = -decay_per_cycle / (2.0 * std::numbers::pi);
    return decay / std::hypot(1.0, decay);
}

double VibrationMode::natural_frequency() const {
    return frequency * std::hypot(1.0, -decay_per_cycle / (2.0 * std::numbers::pi));
}

std::vector<VibrationMode> vibration_modes(const LinearisedChain& chain, std::size_t count) {
    if (count <= few_modes && static_cast<Eigen::Index>(count) <= chain.mass.size())
        if (std::vector<VibrationMode> modes = modes_near_undamped(chain, count); !modes.empty())
            return modes;
    const Eigen::MatrixXd compliance = normalised(chain, 1.0).stiffness.partialPivLu().inverse();
    // 1/√‖K⁻¹M‖: about the slowest undamped mode's angular frequency.
    const NormalisedChain scaled = normalised(chain, 1.0 / std::sqrt(compliance.norm()));
    std::vector<Complex> values = eigenvalues_of(inverse_companion(scaled));
    for (Complex& value : values)
        value = scaled.angular_frequency / value;
    std::ranges::sort(values, slower);
    std::vector<VibrationMode> modes;
    for (const Complex& value : values)
        if (modes.size() < count && value.imag() > 0.0 && std::isfinite(value.imag()))
            modes.push_back(mode_of(value));
    return modes;
}

VibrationMode lightly_damped_mode(const physics::Chain<2, double>& chain) {
    const LinearisedChain linear = linearise_transverse(chain);
    const UndampedMode relaxed = lowest_undamped(linear);
    const double omega =
        relaxed.angular_frequency * frequency_ratio(chain.model(), relaxed.angular_frequency);
    const Eigen::VectorXd shape = relaxed.shape.cwiseQuotient(linear.mass.cwiseSqrt());
    // A branch takes Im E*(ω)/E of the elastic energy of the bonds in each radian.
    double loss = 0.0;
    for (const physics::MaxwellBranch<double>& branch : chain.model().branches) {
        const double phase = omega * branch.relaxation_time;
        loss += branch.relative_stiffness * phase / (1.0 + phase * phase);
    }
    const double decay = 0.5 * shape.dot(linear.damping * shape) +
                         0.5 * loss * relaxed.angular_frequency * relaxed.angular_frequency / omega;
    const double frequency = omega / (2.0 * std::numbers::pi);
    return {frequency, -decay, -decay / frequency};
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
    for (const Complex& root : eigenvalues_of(pencil))
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

std::vector<VibrationMode> transverse_modes(const physics::Chain<2, double>& chain,
                                            std::size_t count) {
    const LinearisedChain linear = linearise_transverse(chain);
    std::vector<VibrationMode> modes = vibration_modes(linear, count);
    if (modes.empty())
        return modes;
    const double factor =
        frequency_ratio(chain.model(), 2.0 * std::numbers::pi * modes.front().frequency);
    for (VibrationMode& mode : modes) {
        mode.frequency *= factor;
        mode.decay_per_cycle /= factor;
    }
    return modes;
}

} // namespace culm::integrate
