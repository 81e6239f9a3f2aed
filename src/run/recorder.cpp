// SPDX-License-Identifier: BSD-3-Clause
#include "run/recorder.hpp"

#include "physics/chain_model.hpp"

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

/// The history, `interval` seconds apart from the release on, read `delay` seconds later by cubic
/// interpolation.
/// Before the release the stem is at rest. The last samples, which have no later ones, repeat the
/// last one.
std::vector<double> read_late(const std::vector<double>& history, double delay, double interval) {
    std::vector<double> late(history.size());
    for (std::size_t k = 0; k < history.size(); ++k)
        late[k] = interpolated(history, static_cast<double>(k) + delay / interval);
    return late;
}

/// Replaces each column of `table`, (samples)(columns), by `changed(its history, its number)`.
template <class Change>
void change_columns(std::vector<double>& table, std::size_t columns, const Change& changed) {
    std::vector<double> history(columns > 0 ? table.size() / columns : 0);
    for (std::size_t column = 0; column < columns; ++column) {
        for (std::size_t k = 0; k < history.size(); ++k)
            history[k] = table[k * columns + column];
        const std::vector<double> other = changed(history, column);
        for (std::size_t k = 0; k < other.size(); ++k)
            table[k * columns + column] = other[k];
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

bool Recorder::needs_rates() const {
    return std::ranges::any_of(spec_.sensors, &measure::Sensor::needs_rates);
}

measure::SensorSurroundings Recorder::surroundings_at(double time) const {
    const physics::ChainModel<double>& chain = model_.chain;
    measure::SensorSurroundings out;
    out.gravity = {chain.gravity[0], chain.gravity[1]};
    if (chain.base_motion) {
        const physics::BaseMotion<double>& base = *chain.base_motion;
        out.support_velocity = base.amplitude * base.angular_frequency *
                               std::cos(base.angular_frequency * time + base.phase);
        out.support_acceleration = -physics::base_acceleration(base, time);
    }
    return out;
}

void Recorder::record(std::size_t index, const measure::ChainSample& sample) {
    const std::span<const double> positions = sample.positions;
    const auto dimensions = static_cast<std::size_t>(dimensions_);
    const auto& base = model_.chain.base_motion;
    const double time = static_cast<double>(index) * spec_.sample_interval;
    const double support = base ? physics::base_position(*base, time) : 0.0;
    result_.tip_deflection[index] = (positions[positions.size() - dimensions + 1] + support) *
                                    camera_scale(spec_.stem.free_length());
    if (spec_.store >= StoreLevel::Heights && !spec_.heights.empty())
        read_heights(index, sample, support);
    if (spec_.store == StoreLevel::Full && index < spec_.sample_count()) {
        const auto spheres = static_cast<std::size_t>(spec_.stem.sphere_count);
        double* frame = result_.positions.data() + index * spheres * 3;
        for (std::size_t i = 0; i < spheres; ++i)
            std::copy_n(positions.data() + i * dimensions, dimensions, frame + 3 * i);
    }
}

void Recorder::read_heights(std::size_t index, const measure::ChainSample& sample, double support) {
    double* const frame = result_.height_deflection.data() + index * spec_.heights.size();
    measure::SensorSurroundings surroundings;
    if (!spec_.sensors.empty())
        surroundings = surroundings_at(static_cast<double>(index) * spec_.sample_interval);
    for (std::size_t row = 0; row < spec_.heights.size(); ++row) {
        const double height = spec_.heights[row];
        const bool is_camera = measure::is_of_camera(spec_.sensors, row);
        const bool is_displacement =
            is_camera || spec_.sensors[row].quantity == measure::Quantity::Displacement;
        const bool is_in_row = is_displacement && spec_.reading == measure::Reading::Row;
        if (is_in_row)
            frame[row] = measure::deflection_in_row(sample.positions, dimensions_, height);
        else if (is_camera)
            frame[row] = measure::deflection_of_mark(sample.positions, dimensions_,
                                                     spec_.stem.bond_length, height);
        else
            frame[row] = measure::reading_of_sensor(spec_.sensors[row], sample, dimensions_,
                                                    spec_.stem.bond_length, height, surroundings);
        if (is_displacement)
            frame[row] += support;
        if (is_camera)
            frame[row] *= camera_scale(height);
    }
}

void Recorder::finish() {
    if (model_.camera.readout_time != 0.0) {
        const double per_height = model_.camera.readout_time / spec_.stem.free_length();
        change_columns(result_.height_deflection, spec_.heights.size(),
                       [&](const std::vector<double>& history, std::size_t row) {
                           return measure::is_of_camera(spec_.sensors, row)
                                      ? read_late(history, per_height * spec_.heights[row],
                                                  spec_.sample_interval)
                                      : history;
                       });
        result_.tip_deflection = read_late(
            result_.tip_deflection, per_height * spec_.stem.free_length(), spec_.sample_interval);
    }
    if (!spec_.sensors.empty())
        change_columns(result_.height_deflection, spec_.heights.size(),
                       [&](std::vector<double> history, std::size_t row) {
                           measure::filter(spec_.sensors[row], spec_.sample_interval, history);
                           return history;
                       });
    result_.tip_deflection.resize(spec_.sample_count());
    if (spec_.store >= StoreLevel::Heights)
        result_.height_deflection.resize(spec_.sample_count() * spec_.heights.size());
}

} // namespace culm::run
