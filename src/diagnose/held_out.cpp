// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/held_out.hpp"

#include "core/error.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>

namespace culm::diagnose {
namespace {

constexpr double normal_quantile = 1.959964;
constexpr std::size_t fewest_blocks = 4;
constexpr double clear_fall = 0.9; ///< of the mean square, with fewer blocks

/// Which readings a part consists of.
using IsHeldOut = std::function<bool(std::size_t frame, std::size_t row)>;

/// Mean squares of readings, all together and in blocks of time.
class PartSum {
  public:
    PartSum(double block_length, const std::vector<double>& noise)
        : block_length_(block_length), noise_(noise) {}

    void begin_frame(double time) {
        if (time - block_begin_ > block_length_) {
            end_block();
            block_begin_ = time;
        }
    }
    void add(double residual, std::size_t row) {
        squares_ += residual * residual;
        const double over_noise = std::pow(residual / noise_[row], 2);
        whitened_ += over_noise;
        block_sum_ += over_noise;
        ++count_;
        ++block_count_;
    }
    [[nodiscard]] HeldOutPart part() {
        end_block();
        if (count_ == 0) {
            part_.failure = "nothing was measured there";
            return part_;
        }
        part_.rms = std::sqrt(squares_ / static_cast<double>(count_));
        part_.over_noise = std::sqrt(whitened_ / static_cast<double>(count_));
        return part_;
    }

  private:
    void end_block() {
        if (block_count_ > 0)
            part_.blocks.push_back(block_sum_ / static_cast<double>(block_count_));
        block_sum_ = 0.0;
        block_count_ = 0;
    }

    double block_length_;
    const std::vector<double>& noise_;
    HeldOutPart part_;
    double squares_ = 0.0;
    double whitened_ = 0.0;
    std::size_t count_ = 0;
    double block_begin_ = 0.0;
    double block_sum_ = 0.0;
    std::size_t block_count_ = 0;
};

class Holder {
  public:
    Holder(const calibrate::ChainFit& fit, const HoldOut& hold_out,
           const measure::Measurement& measurement, const CandidateOptions& options)
        : fit_(fit), hold_out_(hold_out), measurement_(measurement), options_(options) {}

    [[nodiscard]] HeldOutPart of_prediction(const calibrate::ChainPrediction& prediction,
                                            const IsHeldOut& is_held_out) const {
        PartSum sum(hold_out_.block_length, hold_out_.noise);
        for (std::size_t i = 0; i < prediction.frames; ++i) {
            sum.begin_frame(measurement_.times[i]);
            for (std::size_t j = 0; j < prediction.rows; ++j) {
                const double residual =
                    measurement_.deflection(i, j) - prediction.readings[i * prediction.rows + j];
                if (!std::isnan(residual) && is_held_out(i, j))
                    sum.add(residual, j);
            }
        }
        return sum.part();
    }

    /// By a fit to `seen` up to `window`.
    [[nodiscard]] HeldOutPart of_refit(const measure::Measurement& seen,
                                       std::optional<double> window,
                                       const IsHeldOut& is_held_out) const {
        HeldOutPart failed;
        try {
            calibrate::ChainFitOptions options;
            options.window = window;
            options.is_first_guess = false;
            options.heartbeat = options_.heartbeat;
            const calibrate::ChainFit again = calibrate::fit_chain(fit_.model, seen, options);
            if (again.has_converged)
                return of_prediction(
                    calibrate::predict_readings(again.model, fit_.times, options_.heartbeat),
                    is_held_out);
            failed.failure = again.reason;
        } catch (const core::NumericalError& error) {
            failed.failure = error.what();
        }
        return failed;
    }

  private:
    const calibrate::ChainFit& fit_;
    const HoldOut& hold_out_;
    const measure::Measurement& measurement_;
    const CandidateOptions& options_;
};

measure::Measurement without_row(measure::Measurement measurement, std::size_t row) {
    for (std::size_t i = 0; i < measurement.times.size(); ++i)
        measurement.deflections[i * measurement.heights.size() + row] =
            std::numeric_limits<double>::quiet_NaN();
    return measurement;
}

double mean(const std::vector<double>& values) {
    return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

} // namespace

std::size_t row_to_leave_out(const calibrate::ChainFit& baseline) {
    std::size_t worst = baseline.prediction.rows - 1;
    double largest = -1.0;
    for (std::size_t j = baseline.prediction.rows / 2; j < baseline.prediction.rows; ++j) {
        double sum = 0.0;
        for (std::size_t i = 0; i < baseline.times.size(); ++i)
            if (const double r = baseline.residuals[i * baseline.prediction.rows + j];
                !std::isnan(r))
                sum += std::pow(r / baseline.noise[j], 2);
        if (sum > largest) {
            largest = sum;
            worst = j;
        }
    }
    return worst;
}

HeldOut predict_held_out(const CandidateFit& candidate, const HoldOut& hold_out,
                         const measure::Measurement& measurement, const CandidateOptions& options) {
    const calibrate::ChainFit& fit = *candidate.fit;
    const double last_seen = fit.times.back() * 2.0 / 3.0;
    const Holder holder(fit, hold_out, measurement, options);
    const IsHeldOut is_late = [&](std::size_t frame, std::size_t) {
        return fit.times[frame] > last_seen;
    };
    const IsHeldOut is_in_row = [&](std::size_t, std::size_t j) { return j == hold_out.row; };
    if (!candidate.moves)
        return {holder.of_prediction(fit.prediction, is_late),
                holder.of_prediction(fit.prediction, is_in_row)};
    HeldOut result;
    result.last_third = holder.of_refit(measurement, last_seen, is_late);
    if (measurement.heights.size() < 2)
        result.one_height.failure = "there is only one height";
    else
        result.one_height =
            holder.of_refit(without_row(measurement, hold_out.row), options.window, is_in_row);
    return result;
}

bool predicts_better(const HeldOutPart& larger, const HeldOutPart& smaller) {
    if (!larger.failure.empty() || !smaller.failure.empty() || larger.blocks.empty() ||
        larger.blocks.size() != smaller.blocks.size())
        return false;
    if (larger.blocks.size() < fewest_blocks)
        return mean(larger.blocks) < clear_fall * mean(smaller.blocks);
    std::vector<double> differences;
    for (std::size_t k = 0; k < larger.blocks.size(); ++k)
        differences.push_back(larger.blocks[k] - smaller.blocks[k]);
    const double average = mean(differences);
    double squares = 0.0;
    for (const double difference : differences)
        squares += (difference - average) * (difference - average);
    const auto count = static_cast<double>(differences.size());
    return average < -normal_quantile * std::sqrt(squares / (count * (count - 1.0)));
}

} // namespace culm::diagnose
