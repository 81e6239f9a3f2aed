// SPDX-License-Identifier: BSD-3-Clause
#include "fit/noise/whitening.hpp"

#include <cmath>
#include <cstddef>
#include <utility>

namespace culm::fit {

ReadingWeights::ReadingWeights(std::vector<double> noise, std::shared_ptr<const NoiseModel> model,
                               std::vector<bool> is_seen)
    : noise_(std::move(noise)), model_(std::move(model)), is_seen_(std::move(is_seen)) {}

void ReadingWeights::apply(std::span<double> values) const {
    const bool is_relative = model_ && !model_->relative.empty();
    for (std::size_t at = 0; at < values.size(); ++at) {
        const double noise =
            noise_[at % noise_.size()] * (is_relative ? model_->relative[at] : 1.0);
        values[at] = is_seen_[at] && std::isfinite(values[at]) ? values[at] / noise : 0.0;
    }
    if (model_ && model_->common_share > 0.0)
        separate_rows(values);
    if (model_ && model_->correlation > 0.0)
        separate_frames(values);
}

// The covariance of m rows is (1 − c) I + c 1 1ᵀ: 1 + (m − 1) c along their mean, 1 − c across it.
void ReadingWeights::separate_rows(std::span<double> values) const {
    const double share = model_->common_share;
    const std::size_t rows = noise_.size();
    for (std::size_t first = 0; first < values.size(); first += rows) {
        double sum = 0.0;
        double seen = 0.0;
        for (std::size_t at = first; at < first + rows; ++at)
            if (is_seen_[at]) {
                sum += values[at];
                seen += 1.0;
            }
        if (seen == 0.0)
            continue;
        const double along = std::sqrt((1.0 - share) / (1.0 + (seen - 1.0) * share));
        for (std::size_t at = first; at < first + rows; ++at)
            if (is_seen_[at])
                values[at] = (values[at] - (1.0 - along) * sum / seen) / std::sqrt(1.0 - share);
    }
}

// The last reading predicts the one k frames later with the variance 1 − ρ²ᵏ.
void ReadingWeights::separate_frames(std::span<double> values) const {
    for (std::size_t row = 0; row < noise_.size(); ++row) {
        double last = 0.0;
        double carried = 0.0; // correlation with the last reading that was seen
        for (std::size_t at = row; at < values.size(); at += noise_.size()) {
            carried *= model_->correlation;
            if (!is_seen_[at])
                continue;
            const double own = values[at];
            values[at] = (own - carried * last) / std::sqrt(1.0 - carried * carried);
            last = own;
            carried = 1.0;
        }
    }
}

} // namespace culm::fit
