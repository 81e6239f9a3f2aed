// SPDX-License-Identifier: BSD-3-Clause
#include "measure/stem_contrast.hpp"

#include <algorithm>
#include <cmath>

namespace culm::measure {
namespace {

constexpr double window_in_stem_widths = 8.0;

/// Median of a row around nodes that are `spacing` apart, linear in between.
class RowBackground {
  public:
    RowBackground(int width, double stem_width)
        : width_(width), window_(std::clamp(int(std::lround(window_in_stem_widths * stem_width)), 3,
                                            std::max(3, width))),
          spacing_(std::max(2, int(stem_width / 2.0))), stride_(std::max(1, int(stem_width / 5.0))),
          nodes_(std::size_t((width - 1) / spacing_ + 2)) {}

    void find(const float* row) {
        for (std::size_t k = 0; k < nodes_.size(); ++k) {
            // At the border the window keeps its size: a narrower one would hold too much stem.
            const int centre = std::min(int(k) * spacing_, width_ - 1);
            const int begin = std::clamp(centre - window_ / 2, 0, std::max(0, width_ - window_));
            const int end = std::min(width_, begin + window_);
            sample_.clear();
            for (int c = begin; c < end; c += stride_)
                sample_.push_back(row[c]);
            const auto middle = sample_.begin() + std::ptrdiff_t(sample_.size() / 2);
            std::nth_element(sample_.begin(), middle, sample_.end());
            nodes_[k] = *middle;
        }
    }
    [[nodiscard]] float at(int column) const {
        const auto k = std::size_t(column / spacing_);
        const float fraction = float(column % spacing_) / float(spacing_);
        return nodes_[k] + fraction * (nodes_[k + 1] - nodes_[k]);
    }

  private:
    int width_;
    int window_;
    int spacing_;
    int stride_;
    std::vector<float> nodes_;
    std::vector<float> sample_;
};

} // namespace

BandImage stem_contrast(const BandImage& image, int sign, double stem_width) {
    BandImage contrast(image.width, image.height);
    RowBackground background(image.width, stem_width);
    const auto factor = static_cast<float>(sign);
    for (int r = 0; r < image.height; ++r) {
        const float* row = image.row(r);
        background.find(row);
        for (int c = 0; c < image.width; ++c)
            contrast.row(r)[c] = factor * (row[c] - background.at(c));
    }
    return contrast;
}

double contrast_noise(const BandImage& contrast) {
    // A sample is enough: every seventh pixel, a stride that no column width repeats.
    std::vector<float> sizes;
    sizes.reserve(contrast.values.size() / 7 + 1);
    for (std::size_t i = 0; i < contrast.values.size(); i += 7)
        sizes.push_back(std::abs(contrast.values[i]));
    const std::size_t kept = sizes.size() * 9 / 10;
    if (kept == 0)
        return 0.25;
    std::nth_element(sizes.begin(), sizes.begin() + std::ptrdiff_t(kept), sizes.end());
    double sum = 0.0;
    for (std::size_t i = 0; i < kept; ++i)
        sum += double(sizes[i]) * double(sizes[i]);
    // A normal law cut at ±1.645 standard deviations has 0.789 of its standard deviation.
    return std::max(0.25, std::sqrt(sum / double(kept)) / 0.789);
}

} // namespace culm::measure
