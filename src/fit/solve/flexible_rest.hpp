// SPDX-License-Identifier: BSD-3-Clause
// Residuals without what lies at the frequencies of the motion: their rest is noise.
#pragma once

#include "fit/solve/fit.hpp"
#include "run/modes.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <span>
#include <vector>

#include <Eigen/QR>
#include <unsupported/Eigen/FFT>

namespace culm::fit {

/// A frequency at which the motion, or what a model lacks of it, may have power.
struct Line {
    double frequency = 0.0;  ///< Hz
    double decay_rate = 0.0; ///< 1/s, positive
    int degree = 0;          ///< of the polynomial in time on top of the decay
};

/// The modes and what drifts; those that matter most first.
inline std::vector<Line> lines_of(const RecordingFit& fit, double half_rate) {
    std::vector<Line> lines;
    const auto modes = run::chain_modes(case_beside_errors(fit.model), 3);
    if (modes.empty())
        return lines;
    const double first = modes.front().frequency;
    const double decay = std::max(-modes.front().decay_rate, 0.0);
    lines.push_back({first, decay, 6});
    lines.push_back({0.0, 0.0, 4});
    // A material whose loss is not the chain's lets a higher mode decay at any rate between these.
    for (std::size_t k = 1; k < modes.size(); ++k) {
        const double own = std::max(-modes[k].decay_rate, decay);
        for (const double rate : {decay, std::sqrt(decay * own), own})
            lines.push_back({modes[k].frequency, rate, 1});
    }
    std::erase_if(lines, [&](const Line& line) { return line.frequency >= half_rate; });
    return lines;
}

inline void add_columns(const Line& line, std::span<const double> times,
                        std::vector<Eigen::VectorXd>& columns) {
    const double duration = times.back() - times.front();
    const auto frames = static_cast<Eigen::Index>(times.size());
    for (int power = 0; power <= line.degree; ++power) {
        Eigen::VectorXd cosine(frames);
        Eigen::VectorXd sine(frames);
        for (Eigen::Index i = 0; i < frames; ++i) {
            const double time = times[static_cast<std::size_t>(i)] - times.front();
            const double place = 2.0 * time / duration - 1.0;
            // Chebyshev's polynomials: powers would hardly be independent.
            const double size = std::exp(-line.decay_rate * time) *
                                std::cos(power * std::acos(std::clamp(place, -1.0, 1.0)));
            const double phase = 2.0 * std::numbers::pi * line.frequency * time;
            cosine(i) = size * std::cos(phase);
            sine(i) = size * std::sin(phase);
        }
        columns.push_back(cosine);
        if (line.frequency > 0.0)
            columns.push_back(sine);
    }
}

/// Residuals over the noise without what lies at the modes and what drifts: the most flexible
/// fit, whose rest is noise whatever the model lacks.
class FlexibleRest {
  public:
    /// From frame `first` on.
    FlexibleRest(const RecordingFit& fit, std::size_t first) {
        const auto frames = static_cast<Eigen::Index>(fit.times.size() - first);
        const double duration = fit.times.back() - fit.times[first];
        const double rate = static_cast<double>(frames - 1) / duration;
        std::vector<Eigen::VectorXd> columns;
        for (const Line& line : lines_of(fit, 0.5 * rate)) {
            // A quarter of the frames at most: what is left has to tell the noise.
            const auto more = 2 * (static_cast<std::size_t>(line.degree) + 1);
            if (columns.size() + more > static_cast<std::size_t>(frames) / 4)
                break;
            add_columns(line, std::span(fit.times).subspan(first), columns);
        }
        Eigen::MatrixXd basis(frames, static_cast<Eigen::Index>(columns.size()));
        for (std::size_t k = 0; k < columns.size(); ++k)
            basis.col(static_cast<Eigen::Index>(k)) = columns[k].normalized();
        Eigen::ColPivHouseholderQR<Eigen::MatrixXd> solver(basis);
        solver.setThreshold(1e-6);
        basis_ = solver.householderQ() * Eigen::MatrixXd::Identity(frames, solver.rank());
    }

    /// What of a series lies at the lines.
    [[nodiscard]] Eigen::VectorXd smooth(const Eigen::VectorXd& values) const {
        return basis_ * (basis_.transpose() * values);
    }

    /// Share of the frames that the lines leave free.
    [[nodiscard]] double free_share() const {
        return 1.0 - static_cast<double>(basis_.cols()) / static_cast<double>(basis_.rows());
    }

    /// (frames) share of white noise's power that is left there.
    [[nodiscard]] Eigen::VectorXd free_of_frames() const {
        return (1.0 - basis_.rowwise().squaredNorm().array()).matrix();
    }

    /// (Fourier frequencies from 0 to half the rate) share of white noise's power that is left
    /// there.
    [[nodiscard]] Eigen::ArrayXd left_of_noise() const {
        Eigen::FFT<double> transform;
        Eigen::ArrayXd left = Eigen::ArrayXd::Ones(basis_.rows() / 2 + 1);
        for (Eigen::Index c = 0; c < basis_.cols(); ++c) {
            const std::vector<double> values(basis_.col(c).begin(), basis_.col(c).end());
            std::vector<std::complex<double>> found;
            transform.fwd(found, values);
            for (Eigen::Index k = 0; k < left.size(); ++k)
                left(k) -= std::norm(found[static_cast<std::size_t>(k)]) /
                           static_cast<double>(basis_.rows());
        }
        return left;
    }

  private:
    Eigen::MatrixXd basis_; ///< (frames, columns), orthonormal
};

} // namespace culm::fit
