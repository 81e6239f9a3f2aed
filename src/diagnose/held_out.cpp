// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/held_out.hpp"

#include "core/error.hpp"
#include "fit/coarse_image.hpp"
#include "physics/effects/stem_scales.hpp"
#include "reduce/distributions.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>

#include <fmt/core.h>

namespace culm::diagnose {
namespace {

constexpr int most_iterations = 10; ///< of a refit

/// Which readings a part consists of.
using IsHeldOut = std::function<bool(std::size_t part, std::size_t frame, std::size_t row)>;

/// Mean squares of readings, all together and in blocks of time.
class PartSum {
  public:
    void begin_recording(const HoldOut& hold_out) {
        end_block();
        hold_out_ = &hold_out;
        block_begin_ = 0.0;
    }
    void begin_frame(double time) {
        if (time - block_begin_ > hold_out_->block_length) {
            end_block();
            block_begin_ = time;
        }
    }
    void add(double residual, std::size_t row) {
        squares_ += residual * residual;
        const double over_noise = std::pow(residual / hold_out_->noise[row], 2);
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
        part_.readings = count_;
        return part_;
    }

  private:
    void end_block() {
        if (block_count_ > 0)
            part_.blocks.push_back(block_sum_ / static_cast<double>(block_count_));
        block_sum_ = 0.0;
        block_count_ = 0;
    }

    const HoldOut* hold_out_ = nullptr;
    HeldOutPart part_;
    double squares_ = 0.0;
    double whitened_ = 0.0;
    std::size_t count_ = 0;
    double block_begin_ = 0.0;
    double block_sum_ = 0.0;
    std::size_t block_count_ = 0;
};

/// One model of one or several recordings, of which it does not see everything.
class Holder {
  public:
    Holder(std::span<const fit::RecordingFit> parts, std::span<const HoldOut> hold_out,
           std::span<const fit::ObservedRecording> recordings)
        : parts_(parts), hold_out_(hold_out), recordings_(recordings) {}

    /// The last third of each recording.
    [[nodiscard]] IsHeldOut late_ones() const {
        return [this](std::size_t part, std::size_t frame, std::size_t) {
            return parts_[part].times[frame] > parts_[part].times.back() * 2.0 / 3.0;
        };
    }
    [[nodiscard]] IsHeldOut those_in_row() const {
        return [this](std::size_t part, std::size_t, std::size_t row) {
            return row == hold_out_[part].row;
        };
    }

    /// The model's own predictions.
    [[nodiscard]] HeldOutPart of_fit(const IsHeldOut& is_held_out) const {
        PartSum sum;
        for (std::size_t m = 0; m < parts_.size(); ++m)
            add(m, parts_[m].prediction, is_held_out, sum);
        return sum.part();
    }

    /// By a fit to what is not held out.
    [[nodiscard]] HeldOutPart of_refit(const IsHeldOut& is_held_out,
                                       const fit::BelongsToRecording& belongs_to_recording,
                                       const fit::FitOptions& options) const {
        HeldOutPart failed;
        try {
            fit::JointOptions joint;
            joint.chain.window = options.window;
            joint.chain.is_first_guess = false;
            // From the fit to all readings it is not far; what wanders on in a flat valley predicts
            // no better at its end.
            joint.chain.largest_iterations = most_iterations;
            joint.chain.heartbeat = options.heartbeat;
            joint.belongs_to_recording = belongs_to_recording;
            std::vector<fit::StemModel> models;
            for (const fit::RecordingFit& part : parts_)
                models.push_back(part.model);
            const fit::Fit again = fit::fit_jointly(models, what_is_seen(is_held_out), joint);
            PartSum sum;
            for (std::size_t m = 0; m < parts_.size(); ++m)
                add(m,
                    fit::predict_readings(again.parts[m].model, parts_[m].times, options.heartbeat),
                    is_held_out, sum);
            return sum.part();
        } catch (const core::NumericalError& error) {
            failed.failure = error.what();
        }
        return failed;
    }

  private:
    [[nodiscard]] std::vector<fit::ObservedRecording>
    what_is_seen(const IsHeldOut& is_held_out) const {
        std::vector<fit::ObservedRecording> seen(recordings_.begin(), recordings_.end());
        for (std::size_t m = 0; m < seen.size(); ++m)
            for (std::size_t i = 0; i < parts_[m].times.size(); ++i)
                for (std::size_t j = 0; j < seen[m].heights.size(); ++j)
                    if (is_held_out(m, i, j))
                        seen[m].deflections[i * seen[m].heights.size() + j] =
                            std::numeric_limits<double>::quiet_NaN();
        return seen;
    }

    void add(std::size_t part, const fit::ChainPrediction& prediction, const IsHeldOut& is_held_out,
             PartSum& sum) const {
        const measure::Measurement& recording = recordings_[part];
        sum.begin_recording(hold_out_[part]);
        for (std::size_t i = 0; i < prediction.frames; ++i) {
            sum.begin_frame(recording.times[i]);
            for (std::size_t j = 0; j < prediction.rows; ++j) {
                const double residual =
                    recording.deflection(i, j) - prediction.readings[i * prediction.rows + j];
                if (!std::isnan(residual) && is_held_out(part, i, j))
                    sum.add(residual, j);
            }
        }
    }

    std::span<const fit::RecordingFit> parts_;
    std::span<const HoldOut> hold_out_;
    std::span<const fit::ObservedRecording> recordings_;
};

HeldOutPart arrived(std::optional<HeldOutPart> part) {
    HeldOutPart lost;
    lost.failure = "the rank that computed it was lost";
    return std::move(part).value_or(std::move(lost));
}

double mean(const std::vector<double>& values) {
    return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

} // namespace

std::size_t row_to_leave_out(const fit::RecordingFit& baseline) {
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

HoldOut hold_out_of(std::size_t row, const fit::RecordingFit& fit, const Policy& policy) {
    return {row, fit.noise, policy.block_periods / physics::first_frequency(fit.model.spec.stem)};
}

HeldOutPart predict_held_out(HeldOutReadings which, std::span<const fit::RecordingFit> parts,
                             std::span<const HoldOut> hold_out,
                             std::span<const fit::ObservedRecording> recordings,
                             const fit::BelongsToRecording& belongs_to_recording,
                             const fit::FitOptions& options) {
    const Holder holder(parts, hold_out, recordings);
    if (which == HeldOutReadings::LastThird)
        return holder.of_refit(holder.late_ones(), belongs_to_recording, options);
    const bool has_rows = std::ranges::all_of(
        recordings, [](const auto& recording) { return recording.heights.size() > 1; });
    if (has_rows)
        return holder.of_refit(holder.those_in_row(), belongs_to_recording, options);
    HeldOutPart none;
    none.failure = "there is only one height";
    return none;
}

HeldOut predict_held_out(const fit::Fit& candidate, const HoldOut& hold_out,
                         const fit::ObservedRecording& measurement,
                         const fit::FitOptions& options) {
    const std::span<const fit::RecordingFit> part(candidate.parts.data(), 1);
    const std::span<const HoldOut> held(&hold_out, 1);
    const std::span<const fit::ObservedRecording> recording(&measurement, 1);
    if (candidate.moves())
        return {predict_held_out(HeldOutReadings::LastThird, part, held, recording, {}, options),
                predict_held_out(HeldOutReadings::OneHeight, part, held, recording, {}, options)};
    const Holder holder(part, held, recording);
    return {holder.of_fit(holder.late_ones()), holder.of_fit(holder.those_in_row())};
}

bool predicts_better(const HeldOutPart& larger, const HeldOutPart& smaller, const Policy& policy) {
    if (!larger.failure.empty() || !smaller.failure.empty() || larger.blocks.empty() ||
        larger.blocks.size() != smaller.blocks.size())
        return false;
    if (larger.blocks.size() < policy.fewest_blocks)
        return mean(larger.blocks) < policy.clear_fall * mean(smaller.blocks);
    // A paired test over blocks: both models face the same blocks, and beyond some periods their
    // residuals are independent.
    std::vector<double> differences;
    for (std::size_t k = 0; k < larger.blocks.size(); ++k)
        differences.push_back(larger.blocks[k] - smaller.blocks[k]);
    const double average = mean(differences);
    double squares = 0.0;
    for (const double difference : differences)
        squares += (difference - average) * (difference - average);
    const auto count = static_cast<double>(differences.size());
    return average < -reduce::normal_quantile_95 * std::sqrt(squares / (count * (count - 1.0)));
}

bool is_predicted_better(const HeldOutPart& larger, const HeldOutPart& smaller,
                         const Policy& policy) {
    if (!larger.failure.empty() || !smaller.failure.empty())
        return false;
    const double square = larger.over_noise * larger.over_noise;
    // Divided by what the better model leaves where that is above the noise: a misfit that both
    // have makes χ² scatter by as much.
    const double fall = static_cast<double>(larger.readings) *
                        (smaller.over_noise * smaller.over_noise - square) / std::max(1.0, square);
    return fall > policy.held_out_gain || predicts_better(larger, smaller, policy);
}

HeldOutPair hold_out_from_both(const fit::Fit& smaller, const fit::Fit& larger,
                               std::span<const fit::ObservedRecording> recordings,
                               const fit::FitOptions& options, const core::ItemMap& map) {
    std::vector<HoldOut> hold_out;
    for (std::size_t m = 0; m < recordings.size(); ++m)
        hold_out.push_back(hold_out_of(row_to_leave_out(smaller.parts[m]), larger.parts[m]));
    const fit::CoarseImage smaller_image(smaller, recordings, options);
    const fit::CoarseImage larger_image(larger, recordings, options);
    const auto work = [&](std::size_t item, const run::Heartbeat& heartbeat) {
        fit::FitOptions own = options;
        own.heartbeat = heartbeat;
        const fit::CoarseImage& image = item < 2 ? smaller_image : larger_image;
        return predict_held_out(
            item % 2 == 0 ? HeldOutReadings::LastThird : HeldOutReadings::OneHeight,
            image.fit().parts, hold_out, image.recordings(), fit::belongs_to_recording, own);
    };
    std::vector<std::optional<HeldOutPart>> answers = map.values({1.0, 1.0, 2.0, 2.0}, work);
    return {{arrived(std::move(answers[2])), arrived(std::move(answers[3]))},
            {arrived(std::move(answers[0])), arrived(std::move(answers[1]))}};
}

} // namespace culm::diagnose
