// SPDX-License-Identifier: BSD-3-Clause
// Laws of the noise and their maximum likelihood: outliers, correlation in time and over the rows,
// uncertain time stamps.
//
// A law with one more number is used only if noise without it shows as large a gain of likelihood
// in one recording of a thousand.
#pragma once

#include "fit/chain/observed_recording.hpp"

#include <limits>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace culm::fit {

/// Student's t of noise over its scale.
struct Tails {
    double degrees = std::numeric_limits<double>::infinity();
    double scale = 1.0; ///< over the noise
    double slope = 1.0; ///< mean derivative of the score
    double gain = 0.0;  ///< of log-likelihood over a Gaussian's
    bool is_heavy = false;

    /// Score of an error over the noise: scale ψ(z)/ψ̄′ with ψ(z) = (ν + 1) z/(ν + z²) of z =
    /// error/scale; the error itself where the tails are not heavy.
    [[nodiscard]] double scored(double error) const;
};

/// Fits the tails of noise, `values` over its size, by maximum likelihood against a Gaussian. Tails
/// are heavy if a Gaussian shows such tails in one recording of a thousand.
[[nodiscard]] Tails tails_of(const std::vector<double>& values);
/// Fourier coefficients of `rest`, (n frames, rows), over √n at the bins, (bins, rows), corrected
/// for lines that leave the share `left` of white noise's power, (all bins).
[[nodiscard]] Eigen::MatrixXcd fourier_coefficients(const Eigen::MatrixXd& rest,
                                                    const std::vector<Eigen::Index>& bins,
                                                    const Eigen::ArrayXd& left);

/// Correlation of two rows in one frame, from their Fourier coefficients over the root of their
/// spectrum, (frequencies, rows); 0 if independent rows show as much in one recording of a
/// thousand.
[[nodiscard]] double common_share_of(const Eigen::MatrixXcd& found);

/// Number of independent rows with the same scatter about a spectrum as `rows` of this common
/// share: (Σ λ)²/Σ λ² of the eigenvalues λ of their covariance.
[[nodiscard]] double independent_rows(double common_share, double rows);

/// Power of a first-order autoregression over its variance at the Fourier frequencies `bins` of a
/// record of `frames` frames, (bins).
[[nodiscard]] Eigen::ArrayXd spectrum_of(double correlation, const std::vector<Eigen::Index>& bins,
                                         Eigen::Index frames);

/// A first-order autoregression.
struct SlowNoise {
    double variance = 1.0;
    double correlation = 0.0; ///< from frame to frame
};
/// The autoregression of maximum likelihood (Whittle 1953) for the power, (bins), of which each
/// entry is the mean of `copies` independent ones. It is white unless white noise shows as much
/// correlation in one recording of a thousand.
[[nodiscard]] SlowNoise slow_noise_of(const Eigen::ArrayXd& power, double copies,
                                      const std::vector<Eigen::Index>& bins, Eigen::Index frames);

/// Noise of a constant part and a part in proportion to the rate of the reading.
struct TimingNoise {
    double deviation = 1.0;        ///< of the constant part
    double time_uncertainty = 0.0; ///< of a time stamp, s
};
/// The noise of maximum likelihood, variance σ² + τ² rate². τ is 0 unless constant noise shows as
/// much growth in one recording of a thousand.
[[nodiscard]] TimingNoise timing_noise_of(const std::vector<double>& errors,
                                          const std::vector<double>& rates);

/// Describes the noise, of typical size `noise`, SI; `source` is that of the stated noise.
[[nodiscard]] std::string in_words(const NoiseModel& model, const Tails& tails, double noise,
                                   const measure::ReadingUnit& unit, const std::string& source);

} // namespace culm::fit
