// SPDX-License-Identifier: BSD-3-Clause
#include "run/recorder.hpp"

#include "measure/folder/observation.hpp"
#include "physics/node_load.hpp"

#include <algorithm>
#include <cmath>

namespace culm::run {
namespace {

/// Cubic through the four samples about `place` (in sample intervals); constant beyond the ends.
double interpolated(const std::vector<double>& samples, double place) {
    const double base = std::floor(place);
    const double u = place - base;
    const auto at = [&](int offset) {
        const double index =
            std::clamp(base + offset, 0.0, static_cast<double>(samples.size() - 1));
        return samples[static_cast<std::size_t>(index)];
    };
    return -u * (u - 1.0) * (u - 2.0) / 6.0 * at(-1) +
           (u + 1.0) * (u - 1.0) * (u - 2.0) / 2.0 * at(0) -
           (u + 1.0) * u * (u - 2.0) / 2.0 * at(1) + (u + 1.0) * u * (u - 1.0) / 6.0 * at(2);
}

/// Samples beyond the end of a history that a shutter with this readout time needs.
std::size_t late_samples(double readout_time, double sample_interval) {
    if (readout_time <= 0.0)
        return 0;
    // Two more for the cubic, which reaches one sample beyond its interval.
    return static_cast<std::size_t>(std::ceil(readout_time / sample_interval)) + 2;
}

/// Replaces each row of `history` ((samples)(heights), `interval` seconds apart, the first at the
/// release) by its values `delay_per_height` × height seconds later, by cubic interpolation.
/// Before the release the stem is at rest. The last samples, which have no later ones, repeat the
/// last one.
void read_late(std::vector<double>& history, std::span<const double> heights,
               double delay_per_height, double interval) {
    if (heights.empty())
        return;
    const std::size_t samples = history.size() / heights.size();
    std::vector<double> column(samples);
    for (std::size_t row = 0; row < heights.size(); ++row) {
        for (std::size_t k = 0; k < samples; ++k)
            column[k] = history[k * heights.size() + row];
        const double shift = delay_per_height * heights[row] / interval;
        for (std::size_t k = 0; k < samples; ++k)
            history[k * heights.size() + row] =
                interpolated(column, static_cast<double>(k) + shift);
    }
}

} // namespace

Recorder::Recorder(const CaseSpec& spec)
    : spec_(spec), dimensions_(dimensions_of(spec)),
      first_watched_(spec.store >= StoreLevel::Heights ? 0 : spec.stem.sphere_count - 1),
      model_(case_model(spec)),
      samples_(spec.sample_count() +
               late_samples(model_.camera.readout_time, spec.sample_interval)) {
    result_.tip_deflection.resize(samples_);
    if (spec.store >= StoreLevel::Heights)
        result_.height_deflection.resize(samples_ * spec.heights.size());
    if (spec.store == StoreLevel::Full)
        result_.positions.assign(
            spec.sample_count() * static_cast<std::size_t>(spec.stem.sphere_count) * 3, 0.0);
}

double Recorder::camera_scale(double height) const {
    return 1.0 + model_.camera.scale_change * height / spec_.stem.free_length();
}

double Recorder::support_position(double time) const {
    return model_.chain.base_motion ? physics::base_position(*model_.chain.base_motion, time) : 0.0;
}

void Recorder::record(std::size_t index, std::span<const double> positions) {
    const auto dimensions = static_cast<std::size_t>(dimensions_);
    const double support = support_position(static_cast<double>(index) * spec_.sample_interval);
    result_.tip_deflection[index] = (positions[positions.size() - dimensions + 1] + support) *
                                    camera_scale(spec_.stem.free_length());
    if (spec_.store >= StoreLevel::Heights && !spec_.heights.empty())
        read_heights(index, positions, support);
    if (spec_.store == StoreLevel::Full && index < spec_.sample_count()) {
        const auto spheres = static_cast<std::size_t>(spec_.stem.sphere_count);
        double* frame = result_.positions.data() + index * spheres * 3;
        for (std::size_t i = 0; i < spheres; ++i)
            std::copy_n(positions.data() + i * dimensions, dimensions, frame + 3 * i);
    }
}

void Recorder::read_heights(std::size_t index, std::span<const double> positions, double support) {
    double* const frame = result_.height_deflection.data() + index * spec_.heights.size();
    for (std::size_t row = 0; row < spec_.heights.size(); ++row) {
        const double height = spec_.heights[row];
        const double deflection = spec_.reading == measure::Reading::Row
                                      ? measure::deflection_in_row(positions, dimensions_, height)
                                      : measure::deflection_of_mark(positions, dimensions_,
                                                                    spec_.stem.bond_length, height);
        frame[row] = (deflection + support) * camera_scale(height);
    }
}

void Recorder::finish() {
    if (model_.camera.readout_time != 0.0) {
        const double per_height = model_.camera.readout_time / spec_.stem.free_length();
        read_late(result_.height_deflection, spec_.heights, per_height, spec_.sample_interval);
        const double tip[] = {spec_.stem.free_length()};
        read_late(result_.tip_deflection, tip, per_height, spec_.sample_interval);
    }
    result_.tip_deflection.resize(spec_.sample_count());
    if (spec_.store >= StoreLevel::Heights)
        result_.height_deflection.resize(spec_.sample_count() * spec_.heights.size());
}

} // namespace culm::run
