// SPDX-License-Identifier: BSD-3-Clause
#include "cli/compare_json.hpp"
#include "present/json.hpp"

#include <cmath>

namespace culm::cli {

using present::number;
namespace {

using nlohmann::json;

constexpr double millimetres = 1e3;

/// To a nanometre: residuals and shapes hold no more, and the file stays readable.
json millimetres_of(double metres) {
    return std::isfinite(metres) ? json(std::round(metres * 1e9) * 1e-6) : json(nullptr);
}

json millimetres_of(const std::vector<double>& metres) {
    json out = json::array();
    for (const double value : metres)
        out.push_back(millimetres_of(value));
    return out;
}

json estimate(const reduce::Estimate& found, double scale = 1.0) {
    return {{"value", number(scale * found.value)},
            {"stderr", number(scale * found.standard_error)}};
}

json group(const fit::ResidualGroup& found) {
    return {{"readings", found.readings},
            {"rms_mm", number(millimetres * found.rms)},
            {"mean_mm", number(millimetres * found.mean)},
            {"rms_over_noise", number(found.over_noise)}};
}

json groups(const std::vector<fit::ResidualGroup>& found, const char* lower, const char* upper,
            double scale) {
    json out = json::array();
    for (const fit::ResidualGroup& each : found) {
        out.push_back(group(each));
        out.back()[lower] = number(scale * each.lower);
        if (*upper != '\0')
            out.back()[upper] = number(scale * each.upper);
    }
    return out;
}

json spectrum(const fit::ResidualSpectrum& found) {
    json bands = json::array();
    for (const fit::SpectrumBand& band : found.bands)
        bands.push_back({{"name", band.name},
                         {"lower_hz", band.lower},
                         {"upper_hz", band.upper},
                         {"share", number(band.share)}});
    return {{"frequency_hz", found.frequencies},
            {"power_over_noise", found.power},
            {"mode_frequencies_hz", found.mode_frequencies},
            {"bands", bands}};
}

json window_fit(const std::optional<diagnose::WindowFit>& found) {
    if (!found)
        return nullptr;
    return {{"amplitude_mm", number(millimetres * found->amplitude)},
            {"frequency_hz", estimate(found->frequency)},
            {"b1_per_cycle", estimate(found->decay_per_cycle)},
            {"rest_mm", estimate(found->rest, millimetres)}};
}

json windows(const std::vector<diagnose::SwingWindow>& found) {
    json out = json::array();
    for (const diagnose::SwingWindow& window : found)
        out.push_back({{"begin_s", window.begin},
                       {"end_s", window.end},
                       {"measured", window_fit(window.measured)},
                       {"modelled", window_fit(window.modelled)}});
    return out;
}

json modes(const std::vector<diagnose::ModeShape>& found) {
    json out = json::array();
    for (const diagnose::ModeShape& mode : found)
        out.push_back({{"frequency_hz", number(mode.frequency)},
                       {"measured_mm", millimetres_of(mode.measured)},
                       {"modelled_mm", millimetres_of(mode.modelled)},
                       {"stderr_mm", millimetres_of(mode.standard_error)}});
    return out;
}

json slope(const reduce::StemRingDowns& stem) {
    if (!stem.banding)
        return nullptr;
    return {{"slope", number(stem.banding->slope)}, {"p_value", number(stem.banding->p_value)}};
}

/// b1 per cycle at every height.
json banding(const diagnose::Comparison& comparison) {
    json heights = json::array();
    const auto& measured = comparison.measured_ring_downs.heights;
    const auto& modelled = comparison.modelled_ring_downs.heights;
    for (std::size_t j = 0; j < measured.size(); ++j) {
        const auto b1 = [](const reduce::HeightRingDown& height) {
            return height.fit ? estimate(height.fit->decay_per_cycle) : json(nullptr);
        };
        heights.push_back({{"height_mm", millimetres * measured[j].height},
                           {"measured", b1(measured[j])},
                           {"modelled", b1(modelled[j])}});
    }
    return {{"heights", heights},
            {"measured", slope(comparison.measured_ring_downs)},
            {"modelled", slope(comparison.modelled_ring_downs)}};
}

json structure(const diagnose::ResidualStructure& found) {
    json thirds = json::array();
    for (const diagnose::SwingError& error : found.thirds)
        thirds.push_back({{"amplitude", number(error.amplitude)},
                          {"amplitude_stderr", number(error.amplitude_error)},
                          {"lag_rad", number(error.lag)},
                          {"lag_stderr_rad", number(error.lag_error)},
                          {"rest_mm", number(millimetres * error.rest)},
                          {"rest_stderr_mm", number(millimetres * error.rest_error)},
                          {"measured_over_noise", number(error.measured_over_noise)},
                          {"modelled_over_noise", number(error.modelled_over_noise)}});
    return {{"thirds", thirds},
            {"shares",
             {{"amplitude", found.amplitude_share},
              {"phase", found.phase_share},
              {"rest", found.rest_share},
              {"other_motion", found.other_motion_share},
              {"other_shape", found.other_shape_share}}}};
}

json residual_map(const fit::RecordingFit& fit) {
    json heights = json::array();
    for (const double height : fit.model.spec.heights)
        heights.push_back(millimetres * height);
    json rows = json::array();
    for (std::size_t i = 0; i < fit.times.size(); ++i) {
        json row = json::array();
        for (std::size_t j = 0; j < fit.prediction.rows; ++j)
            row.push_back(millimetres_of(fit.residuals[i * fit.prediction.rows + j]));
        rows.push_back(std::move(row));
    }
    return {{"time_s", fit.times}, {"height_mm", heights}, {"residual_mm", rows}};
}

} // namespace

json where_json(const diagnose::Comparison& comparison, const fit::RecordingFit& of) {
    return {
        {"by_height", groups(comparison.by_height, "height_mm", "", millimetres)},
        {"by_time", groups(comparison.by_time, "begin_s", "end_s", 1.0)},
        {"by_amplitude", groups(comparison.by_amplitude, "smallest_mm", "largest_mm", millimetres)},
        {"spectrum", spectrum(comparison.spectrum)},
        {"against_amplitude", windows(comparison.windows)},
        {"modes", modes(comparison.modes)},
        {"banding", banding(comparison)},
        {"structure", structure(comparison.structure)},
        {"pattern_over_heights",
         {{"share", number(comparison.verdict.spatial_share)},
          {"rms_mm", millimetres_of(comparison.verdict.spatial_pattern)}}},
        {"residual_map", residual_map(of)}};
}

} // namespace culm::cli
