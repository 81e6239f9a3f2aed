// SPDX-License-Identifier: BSD-3-Clause
// The positions of all spheres of an integrated chain at equidistant times.
#pragma once

#include "integrate/history_sampler.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace culm::integrate {

/// (samples)(Dim × spheres): the positions of all spheres, m.
using History = std::vector<std::vector<double>>;

template <int Dim>
class Recording {
  public:
    Recording(const physics::ChainLayout<Dim>& layout, double interval, std::size_t count)
        : samples_(count),
          sampler_(layout, 0, layout.bond_count(), interval, count, false,
                   [this](std::size_t k, const auto& rates) { samples_[k] = rates[0]; }) {}
    Recording(const Recording&) = delete;
    Recording& operator=(const Recording&) = delete;

    HistorySampler<Dim>& sampler() { return sampler_; }
    [[nodiscard]] const History& finished() {
        sampler_.finish();
        return samples_;
    }

  private:
    History samples_;
    HistorySampler<Dim> sampler_;
};

inline double largest_difference(const History& a, const History& b) {
    double largest = 0.0;
    for (std::size_t k = 0; k < a.size(); ++k)
        for (std::size_t i = 0; i < a[k].size(); ++i)
            largest = std::max(largest, std::abs(a[k][i] - b[k][i]));
    return largest;
}

} // namespace culm::integrate
