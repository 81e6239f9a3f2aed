// SPDX-License-Identifier: BSD-3-Clause
// Positions at equidistant sample times from an integrator's own, uneven steps, and their rates.
#pragma once

#include "core/lanes.hpp"
#include "physics/chain_layout.hpp"

#include <algorithm>
#include <array>
#include <functional>
#include <span>
#include <utility>
#include <vector>

namespace culm::integrate {

/// Interpolates positions with the velocities in the state: a quintic through position and velocity
/// at three successive steps, or a cubic through two steps if the lengths of the steps differ too
/// much. With n steps per period T the quintic's error is about
/// (2π/n)^6 · 1.5e-4 of the amplitude: 1e-7 at n = 20. Velocities and accelerations are the
/// derivatives of this polynomial, with an error of (2π/n)^4 · 1e-2 of the acceleration at most.
template <int Dim>
class HistorySampler {
  public:
    /// Derivatives by time of the positions of the watched spheres, Dim numbers for each sphere
    /// from the first to the last: positions, velocities and accelerations, or positions only.
    using Rates = std::array<std::vector<double>, 3>;
    /// Receives sample `index` (time index · interval).
    using Sink = std::function<void(std::size_t index, const Rates& rates)>;

    HistorySampler(const physics::ChainLayout<Dim>& layout, int first_sphere, int last_sphere,
                   double interval, std::size_t count, bool needs_rates, Sink sink)
        : layout_(layout), first_sphere_(first_sphere), last_sphere_(last_sphere),
          interval_(interval), count_(count), sink_(std::move(sink)) {
        const std::size_t size = static_cast<std::size_t>(last_sphere - first_sphere + 1) * Dim;
        for (Node& node : nodes_) {
            node.positions.resize(size);
            node.velocities.resize(size);
        }
        for (std::size_t order = 0; order < (needs_rates ? 3U : 1U); ++order)
            sample_[order].resize(size);
    }

    /// Takes the state at the end of a step; times must increase.
    void observe(double time, std::span<const double> state) { observe(time, state, 0); }

    /// The same for the stem in lane `lane`.
    template <class T>
    void observe(double time, std::span<const T> state, std::size_t lane) {
        std::rotate(nodes_.begin(), nodes_.begin() + 1, nodes_.end());
        Node& node = nodes_.back();
        node.time = time;
        std::size_t k = 0;
        for (int i = first_sphere_; i <= last_sphere_; ++i) {
            const auto sphere = layout_.sphere(state.data(), i);
            for (int d = 0; d < Dim; ++d, ++k) {
                node.positions[k] = core::lane(sphere.position[d], lane);
                node.velocities[k] = core::lane(sphere.velocity[d], lane);
            }
        }
        if (++seen_ >= 3)
            emit_until(nodes_[1].time, 0);
    }

    /// Emits the samples of the last step; call once, after at least two observed states.
    void finish() {
        if (seen_ == 2)
            nodes_[0] = nodes_[1];
        emit_until(nodes_[2].time * (1.0 + 1e-12), 1);
    }

    /// Samples emitted so far.
    [[nodiscard]] std::size_t emitted() const { return next_; }

  private:
    struct Node {
        double time = 0.0;
        std::vector<double> positions;
        std::vector<double> velocities;
    };

    /// Emits samples up to `limit`, which lies in the interval from node `from` to the next.
    void emit_until(double limit, std::size_t from) {
        const double lengths[2] = {nodes_[1].time - nodes_[0].time,
                                   nodes_[2].time - nodes_[1].time};
        // Beyond this ratio the quintic amplifies the integrator's own error.
        constexpr double most_uneven = 8.0;
        const bool even = lengths[0] > 0.0 && lengths[0] < most_uneven * lengths[1] &&
                          lengths[1] < most_uneven * lengths[0];
        const std::size_t begin = even ? 0 : from;
        const std::size_t end = even ? 3 : from + 2;
        while (next_ < count_ && static_cast<double>(next_) * interval_ <= limit) {
            interpolate(static_cast<double>(next_) * interval_, begin, end);
            sink_(next_, sample_);
            ++next_;
        }
    }

    /// Hermite interpolation through the nodes [begin, end).
    void interpolate(double time, std::size_t begin, std::size_t end) {
        for (std::vector<double>& values : sample_)
            std::fill(values.begin(), values.end(), 0.0);
        for (std::size_t i = begin; i < end; ++i) {
            double basis = 1.0; // Lagrange polynomial of node i at `time`, with its derivatives
            double rate = 0.0;
            double bend = 0.0;
            double slope = 0.0; // derivative at node i
            for (std::size_t j = begin; j < end; ++j) {
                if (j == i)
                    continue;
                const double distance = nodes_[i].time - nodes_[j].time;
                const double factor = (time - nodes_[j].time) / distance;
                bend = bend * factor + 2.0 * rate / distance;
                rate = rate * factor + basis / distance;
                basis *= factor;
                slope += 1.0 / distance;
            }
            const double offset = time - nodes_[i].time;
            const double linear = 1.0 - 2.0 * offset * slope;
            const double square = basis * basis; // with its derivatives
            const double square_rate = 2.0 * basis * rate;
            const double square_bend = 2.0 * (rate * rate + basis * bend);
            add(0, i, linear * square, offset * square);
            add(1, i, linear * square_rate - 2.0 * slope * square, square + offset * square_rate);
            add(2, i, linear * square_bend - 4.0 * slope * square_rate,
                2.0 * square_rate + offset * square_bend);
        }
    }

    void add(std::size_t order, std::size_t node, double of_position, double of_velocity) {
        for (std::size_t k = 0; k < sample_[order].size(); ++k)
            sample_[order][k] +=
                of_position * nodes_[node].positions[k] + of_velocity * nodes_[node].velocities[k];
    }

    physics::ChainLayout<Dim> layout_;
    int first_sphere_;
    int last_sphere_;
    double interval_;
    std::size_t count_;
    Sink sink_;
    std::array<Node, 3> nodes_;
    Rates sample_;
    std::size_t seen_ = 0;
    std::size_t next_ = 0;
};

} // namespace culm::integrate
