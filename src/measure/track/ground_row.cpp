// SPDX-License-Identifier: BSD-3-Clause
#include "measure/track/matched_row.hpp"

#include <algorithm>
#include <cmath>

namespace culm::measure {

void GroundRow::add(const PixelRow& row, double axis, double hidden) {
    sums_.resize(std::size_t(row.width));
    counts_.resize(std::size_t(row.width));
    if (std::isnan(axis) || std::isnan(hidden))
        return;
    for (int c = 0; c < row.width; ++c)
        if (std::abs(c - axis) > hidden) {
            sums_[std::size_t(c)] += row.values[c];
            ++counts_[std::size_t(c)];
        }
}

std::vector<float> GroundRow::mean(double noise) const {
    std::vector<double> known = between_well_seen();
    const double texture = texture_of(noise);
    std::vector<float> mean;
    for (std::size_t c = 0; c < sums_.size(); ++c) {
        const double count = counts_[c];
        const double share = count < fewest ? count * texture / (count * texture + noise) : 0.0;
        mean.push_back(static_cast<float>(share > 0.0 ? std::lerp(known[c], sums_[c] / count, share)
                                                      : known[c]));
    }
    return mean;
}

std::vector<double> GroundRow::between_well_seen() const {
    std::vector<double> mean(sums_.size(), 0.0);
    std::optional<std::size_t> last;
    for (std::size_t c = 0; c < sums_.size(); ++c) {
        if (counts_[c] < fewest)
            continue;
        mean[c] = sums_[c] / counts_[c];
        const std::size_t before = last.value_or(c);
        for (std::size_t k = last ? before + 1 : 0; k < c; ++k)
            mean[k] = std::lerp(mean[before], mean[c],
                                c == before ? 1.0 : double(k - before) / double(c - before));
        last = c;
    }
    if (last)
        std::fill(mean.begin() + std::ptrdiff_t(*last), mean.end(), mean[*last]);
    return mean;
}

double GroundRow::texture_of(double noise) const {
    const std::size_t reach = widest_gap() / 2 + 1;
    double sum = 0.0;
    double count = 0.0;
    for (std::size_t c = reach; c + reach < sums_.size(); ++c) {
        if (std::min({counts_[c - reach], counts_[c], counts_[c + reach]}) < fewest)
            continue;
        const auto mean = [&](std::size_t k) { return sums_[k] / counts_[k]; };
        sum += std::pow(mean(c) - 0.5 * (mean(c - reach) + mean(c + reach)), 2) -
               1.5 * noise / counts_[c];
        count += 1.0;
    }
    return count > 0.0 ? std::max(0.0, sum / count) : 0.0;
}

std::size_t GroundRow::widest_gap() const {
    std::size_t widest = 0;
    std::optional<std::size_t> last;
    for (std::size_t c = 0; c < counts_.size(); ++c)
        if (counts_[c] >= fewest) {
            widest = std::max(widest, c - last.value_or(c - 1) - 1);
            last = c;
        }
    return widest;
}

} // namespace culm::measure
