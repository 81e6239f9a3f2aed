// SPDX-License-Identifier: BSD-3-Clause
#include "beam_generator/demo_beam.hpp"

#include "beam_generator/recording.hpp"

#include <iterator>
#include <vector>

#include <fmt/core.h>

namespace culm::beam {
namespace {

constexpr double frames_per_second = 960.0;
constexpr double release_frame = 7.6; // between two frames, as in a real video
constexpr int frames = 199;
constexpr int points = 41;

RecordingSpec demo_spec() {
    RecordingSpec spec;
    spec.stem = {0.156, 2.83e-3, 125.0, demo_youngs_modulus, demo_damping_time};
    spec.tip_deflection = 20e-3;
    return spec;
}

} // namespace

std::string demo_axis_table() {
    std::vector<double> times;
    for (int frame = 0; frame < frames; ++frame)
        times.push_back((frame - release_frame) / frames_per_second);
    std::string table = "time_s";
    for (int point = 0; point < points; ++point)
        fmt::format_to(std::back_inserter(table), ",height_{0}_mm,deflection_{0}_mm", point);
    table += '\n';
    const auto positions = axis_positions(demo_spec(), times, points);
    for (std::size_t frame = 0; frame < times.size(); ++frame) {
        fmt::format_to(std::back_inserter(table), "{:.6f}", times[frame]);
        for (const AxisPoint& point : positions[frame])
            fmt::format_to(std::back_inserter(table), ",{:.3f},{:.3f}", 1e3 * point.height,
                           1e3 * point.deflection);
        table += '\n';
    }
    return table;
}

} // namespace culm::beam
