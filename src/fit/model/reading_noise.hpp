// SPDX-License-Identifier: BSD-3-Clause
// Standard deviation of the readings of a measurement, stated or estimated.
#pragma once

#include "measure/folder/measurement.hpp"

#include <cstddef>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace culm::fit {

struct ReadingNoise {
    std::vector<double> by_row; ///< (rows), m; empty: only the residuals of a fit can tell
    std::string source;         ///< "stated", or from what it was estimated
};

/// The noise that the measurement states, for each reading (the mean square of a row) or each row;
/// else the scatter about each row's mean while the stem was
/// held, over at least 20 degrees of freedom of all rows together; else the scatter of the second
/// differences over the last tenth of the record if what is left of the motion there is below the
/// noise; else none.
[[nodiscard]] ReadingNoise reading_noise(const measure::Measurement& measurement);

/// Of each reading, (times, rows), m: what is stated for it, else that of its row.
[[nodiscard]] std::vector<double> noise_of_readings(const measure::Measurement& measurement,
                                                    const std::vector<double>& by_row);
/// Of each reading over that of its row, (times, rows); empty where only that is stated.
[[nodiscard]] std::vector<double> relative_noise(const measure::Measurement& measurement,
                                                 const std::vector<double>& by_row);

/// Makes white what a noise model says hangs together. In a frame in which not every row was seen a
/// rotated model says nothing: such readings count by themselves.
class Whitening {
  public:
    /// `is_seen`: (frames, rows). A null model leaves the readings as they are.
    Whitening(std::shared_ptr<const measure::NoiseModel> model, std::size_t rows,
              const std::vector<bool>& is_seen);

    /// In place: (frames, rows) of readings over the noise of their row, whatever is linear in
    /// them. What was not seen becomes 0.
    void apply(std::span<double> values) const;

    /// The rows' weights as the series have them.
    [[nodiscard]] std::vector<double> turned(const std::vector<double>& weights) const;
    /// The other way round.
    [[nodiscard]] std::vector<double> turned_back(const std::vector<double>& weights) const;

  private:
    /// One step of a Kalman filter, which is the same whatever the values.
    struct Step {
        double carry = 0.0;             ///< of the state since the frame before
        double gain = 0.0;              ///< of the state by what is new in the reading
        double inverse_deviation = 0.0; ///< of what is new; 0: nothing was seen
    };
    void add_series(std::size_t series, const std::vector<bool>& is_seen);
    [[nodiscard]] bool is_turned() const { return model_ && !model_->rotation.empty(); }

    std::shared_ptr<const measure::NoiseModel> model_;
    std::size_t rows_;
    std::vector<bool> is_seen_;
    std::vector<bool> is_complete_; ///< (frames)
    std::vector<Step> steps_;       ///< (frames, series)
};

/// Student's t of noise over its scale.
struct Tails {
    double degrees = std::numeric_limits<double>::infinity();
    double scale = 1.0; ///< over the noise
    double slope = 1.0; ///< mean derivative of the score
    bool is_heavy = false;

    /// Of an error over the noise: scale ψ(z)/ψ̄′ with ψ(z) = (ν + 1) z/(ν + z²) of z = error/scale;
    /// the error itself where the tails are not heavy.
    [[nodiscard]] double scored(double error) const;
};

/// Tails of noise, `values` over its size, by maximum likelihood against a Gaussian. Heavy ones are
/// such as a Gaussian shows in one recording of a thousand.
[[nodiscard]] Tails tails_of(const std::vector<double>& values);

/// Power of the series over its variance at Fourier frequencies `bins` of so many frames, (bins).
[[nodiscard]] Eigen::ArrayXd spectrum_of(const measure::NoiseModel::Series& series,
                                         const std::vector<Eigen::Index>& bins,
                                         Eigen::Index frames);

/// The series that explains the power best, (bins), each the mean of `copies` independent ones;
/// white unless correlation is significant, at one in a thousand.
[[nodiscard]] measure::NoiseModel::Series series_of(const Eigen::ArrayXd& power, double copies,
                                                    const std::vector<Eigen::Index>& bins,
                                                    Eigen::Index frames);

} // namespace culm::fit
