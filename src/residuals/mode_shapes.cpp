// SPDX-License-Identifier: BSD-3-Clause
#include "residuals/mode_shapes.hpp"

#include "run/modes.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include <Eigen/QR>

namespace culm::residuals {
namespace {

constexpr double shape_cycles = 5.0;
constexpr std::size_t mode_count = 3;

std::vector<std::size_t> frames_within(const fit::RecordingFit& fit, double last) {
    std::vector<std::size_t> frames;
    for (std::size_t i = 0; i < fit.times.size(); ++i)
        if (fit.times[i] >= 0.0 && fit.times[i] <= last)
            frames.push_back(i);
    return frames;
}

/// Columns: a constant, then the real and imaginary part of each mode.
Eigen::MatrixXd mode_basis(const fit::RecordingFit& fit, const std::vector<std::size_t>& frames,
                           const std::vector<integrate::VibrationMode>& modes) {
    Eigen::MatrixXd basis(static_cast<Eigen::Index>(frames.size()),
                          static_cast<Eigen::Index>(1 + 2 * modes.size()));
    for (Eigen::Index i = 0; i < basis.rows(); ++i) {
        const double time = fit.times[frames[static_cast<std::size_t>(i)]];
        basis(i, 0) = 1.0;
        for (std::size_t k = 0; k < modes.size(); ++k) {
            const double decay = std::exp(modes[k].decay_rate * time);
            const double phase = 2.0 * std::numbers::pi * modes[k].frequency * time;
            basis(i, static_cast<Eigen::Index>(1 + 2 * k)) = decay * std::cos(phase);
            basis(i, static_cast<Eigen::Index>(2 + 2 * k)) = decay * std::sin(phase);
        }
    }
    return basis;
}

/// Amplitudes in one row's readings.
struct RowAmplitudes {
    Eigen::VectorXd coefficients;
    Eigen::VectorXd standard_errors;
};

RowAmplitudes row_amplitudes(const Eigen::MatrixXd& basis, const Eigen::VectorXd& readings,
                             double noise) {
    std::vector<Eigen::Index> seen;
    for (Eigen::Index i = 0; i < readings.size(); ++i)
        if (!std::isnan(readings(i)))
            seen.push_back(i);
    const Eigen::Index count = basis.cols();
    if (static_cast<Eigen::Index>(seen.size()) < 2 * count)
        return {Eigen::VectorXd::Zero(count), Eigen::VectorXd::Zero(count)};
    const Eigen::MatrixXd part = basis(seen, Eigen::all);
    const Eigen::MatrixXd inverse =
        (part.transpose() * part).completeOrthogonalDecomposition().pseudoInverse();
    return {inverse * (part.transpose() * readings(seen)),
            noise * inverse.diagonal().cwiseMax(0.0).cwiseSqrt()};
}

} // namespace

std::vector<ModeShape> mode_shapes(const fit::RecordingFit& fit,
                                   const measure::Measurement& measurement) {
    std::vector<integrate::VibrationMode> modes = run::chain_modes(fit.model.spec, mode_count);
    const std::vector<std::size_t> after = frames_within(fit, fit.times.back());
    if (modes.empty() || after.size() < 2)
        return {};
    const double half_rate =
        0.5 * static_cast<double>(after.size() - 1) / (fit.times.back() - fit.times[after.front()]);
    // Above half the frame rate a mode is aliased; close to it sine and cosine are one column.
    std::erase_if(modes, [&](const auto& mode) { return mode.frequency > 0.9 * half_rate; });
    if (modes.empty())
        return {};
    const std::vector<std::size_t> frames =
        frames_within(fit, shape_cycles / modes.front().frequency);
    if (frames.size() < 4 * (1 + 2 * modes.size()))
        return {};
    const Eigen::MatrixXd basis = mode_basis(fit, frames, modes);
    const std::size_t rows = fit.prediction.rows;
    std::vector<RowAmplitudes> measured;
    std::vector<RowAmplitudes> modelled;
    for (std::size_t j = 0; j < rows; ++j) {
        Eigen::VectorXd readings(basis.rows());
        Eigen::VectorXd predicted(basis.rows());
        for (Eigen::Index i = 0; i < basis.rows(); ++i) {
            const std::size_t place = frames[static_cast<std::size_t>(i)] * rows + j;
            readings(i) = measurement.deflections[place];
            predicted(i) = std::isnan(readings(i)) ? readings(i) : fit.prediction.readings[place];
        }
        measured.push_back(row_amplitudes(basis, readings, fit.noise[j]));
        modelled.push_back(row_amplitudes(basis, predicted, 0.0));
    }
    std::vector<ModeShape> shapes;
    for (std::size_t k = 0; k < modes.size(); ++k) {
        const auto cosine = static_cast<Eigen::Index>(1 + 2 * k);
        // a cos φ + b sin φ is the real part of (a − i b) exp(iφ).
        const auto complex_of = [cosine](const RowAmplitudes& row) {
            return std::complex(row.coefficients(cosine), -row.coefficients(cosine + 1));
        };
        // All rows are turned by the phase of the model's largest row. A real mode then has a real
        // shape, and a wrong phase of the recording makes the shape smaller.
        std::complex<double> largest = 0.0;
        for (const RowAmplitudes& row : modelled)
            if (std::abs(complex_of(row)) > std::abs(largest))
                largest = complex_of(row);
        const std::complex<double> turn =
            largest == 0.0 ? 1.0 : std::conj(largest) / std::abs(largest);
        ModeShape& shape = shapes.emplace_back();
        shape.frequency = modes[k].frequency;
        for (std::size_t j = 0; j < rows; ++j) {
            shape.measured.push_back((complex_of(measured[j]) * turn).real());
            shape.modelled.push_back((complex_of(modelled[j]) * turn).real());
            shape.standard_error.push_back(measured[j].standard_errors(cosine));
        }
    }
    return shapes;
}

} // namespace culm::residuals
