// SPDX-License-Identifier: BSD-3-Clause
// Where, when and how a fit fails: the member "where" of comparisons and diagnoses.
#pragma once

#include "core/describe.hpp"
#include "diagnose/ladder.hpp"
#include "fit/solve/fit_result.hpp"

#include <cmath>
#include <optional>
#include <span>
#include <vector>

namespace culm::present {

/// Millimetres, rounded to a nanometre: residuals and shapes are less accurate, and the file stays
/// readable.
[[nodiscard]] inline std::vector<double> rounded_millimetres(std::span<const double> metres) {
    std::vector<double> rounded;
    for (const double value : metres)
        rounded.push_back(std::round(value * 1e9) * 1e-6);
    return rounded;
}

/// Includes the residual over noise, which is comparable between heights and times. `lower` and
/// `upper` are keys; heights have no upper end.
template <class To>
void describe_groups(To& to, const char* key, const std::vector<fit::ResidualGroup>& groups,
                     const char* lower, const char* upper) {
    to.list(key, groups, [&](const fit::ResidualGroup& group) {
        to("readings", group.readings);
        to("rms_mm", group.rms);
        to("mean_mm", group.mean);
        to("rms_over_noise", group.over_noise);
        to(lower, group.lower);
        if (upper != nullptr)
            to(upper, group.upper);
    });
}

/// b1 per cycle at every height, and its slope along the stem (the paper's "banding").
template <class To>
void describe_banding(To& to, const diagnose::Comparison& comparison) {
    const auto& measured = comparison.measured_ring_downs;
    const auto& modelled = comparison.modelled_ring_downs;
    const auto b1 = [](const residuals::HeightRingDown& height) {
        return height.fit ? std::optional(height.fit->decay_per_cycle) : std::nullopt;
    };
    const auto heights = [&] { return std::views::iota(std::size_t{0}, measured.heights.size()); };
    to.list("heights", heights, [&](std::size_t j) {
        to("height_mm", [&] { return measured.heights[j].height; });
        to("measured", [&] { return b1(measured.heights[j]); });
        to("modelled", [&] { return b1(modelled.heights[j]); });
    });
    to("measured", measured.banding);
    to("modelled", modelled.banding);
}

template <class To>
void describe_residual_map(To& to, const fit::RecordingFit& fit) {
    to("time_s", fit.times);
    to("height_mm", fit.model.spec.heights);
    to.as_it_is("residual_mm", [&] {
        std::vector<std::vector<double>> rows;
        for (std::size_t i = 0; i < fit.times.size(); ++i)
            rows.push_back(rounded_millimetres(
                std::span(fit.residuals).subspan(i * fit.prediction.rows, fit.prediction.rows)));
        return rows;
    });
}

template <class To>
void describe_where(To& to, const diagnose::Comparison& comparison, const fit::RecordingFit& fit) {
    describe_groups(to, "by_height", comparison.by_height, "height_mm", nullptr);
    describe_groups(to, "by_time", comparison.by_time, "begin_s", "end_s");
    to("spectrum", comparison.spectrum);
    to("backbone", comparison.backbones);
    to.object("banding", [&] { describe_banding(to, comparison); });
    to.object("residual_map", [&] { describe_residual_map(to, fit); });
}

} // namespace culm::present
