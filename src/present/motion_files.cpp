// SPDX-License-Identifier: BSD-3-Clause
#include "present/motion_files.hpp"

#include "archive/hdf5/array_file.hpp"
#include "present/files.hpp"
#include "present/parameters.hpp"

#include <limits>
#include <ranges>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace culm::present {
namespace {

using archive::GroupTexts;
using archive::NamedArray;

/// An array of one dimension.
NamedArray series(std::string path, std::string unit, std::string description,
                  std::vector<double> values) {
    const std::size_t count = values.size();
    return {std::move(path), std::move(unit), std::move(description), {count}, std::move(values)};
}

/// `place`time, `place`height and `place`measured (time, height): the frames that `fit` used.
void add_measured(std::vector<NamedArray>& arrays, const std::string& place,
                  const fit::RecordingFit& fit, const measure::Measurement& measurement) {
    // With --window a fit has fewer frames than the recording.
    const std::size_t frames = fit.times.size();
    const std::size_t rows = measurement.heights.size();
    arrays.push_back(series(place + "time", "s", "0 is the release", fit.times));
    arrays.push_back(series(place + "height", "m", "above the clamp", measurement.heights));
    arrays.push_back(
        {place + "measured",
         "m",
         "deflection (time, height); NaN where nothing was seen",
         {frames, rows},
         {measurement.deflections.begin(),
          measurement.deflections.begin() + static_cast<std::ptrdiff_t>(frames * rows)}});
}

/// `group`/predicted and `group`/residual (time, height).
void add_predicted(std::vector<NamedArray>& arrays, const std::string& group,
                   const fit::RecordingFit& fit) {
    const std::vector<std::size_t> map{fit.times.size(), fit.prediction.rows};
    arrays.push_back(
        {group + "/predicted", "m", "deflection (time, height)", map,
         std::vector<double>(fit.prediction.readings.begin(), fit.prediction.readings.end())});
    arrays.push_back({group + "/residual", "m",
                      "measured - predicted (time, height); NaN where nothing was seen", map,
                      fit.residuals});
}

/// The fits of Eq. 1 in the windows, measured or modelled; NaN where a fit failed.
void add_windows(std::vector<NamedArray>& arrays, const std::string& group,
                 const std::vector<residuals::SwingWindow>& windows,
                 std::optional<residuals::WindowFit> residuals::SwingWindow::*side) {
    using residuals::WindowFit;
    const auto add = [&](const std::string& name, const char* unit, const char* description,
                         const auto& get) {
        std::vector<double> values;
        for (const residuals::SwingWindow& window : windows)
            values.push_back(window.*side ? get(*(window.*side))
                                          : std::numeric_limits<double>::quiet_NaN());
        arrays.push_back(series(group + '/' + name, unit, description, std::move(values)));
    };
    const auto add_estimate = [&add](const std::string& name, const char* unit,
                                     const char* description,
                                     reduce::Estimate WindowFit::*quantity) {
        add(name, unit, description, [=](const auto& fit) { return (fit.*quantity).value; });
        add(name + "_stderr", unit, "",
            [=](const auto& fit) { return (fit.*quantity).standard_error; });
    };
    add("amplitude", "m", "in the middle of the window", std::mem_fn(&WindowFit::amplitude));
    add_estimate("frequency", "Hz", "", &WindowFit::frequency);
    add_estimate("decay_per_cycle", "1", "b1 per cycle", &WindowFit::decay_per_cycle);
    add_estimate("rest", "m", "position of rest", &WindowFit::rest);
}

/// A group of comparison.h5: the motion of a model, the spectrum of its residuals, and the swing of
/// both in windows.
void add_model(std::vector<NamedArray>& arrays, const std::string& group,
               const fit::RecordingFit& fit, const diagnose::Comparison& comparison) {
    add_predicted(arrays, group, fit);
    const fit::ResidualSpectrum& spectrum = comparison.spectrum;
    arrays.push_back(series(group + "/spectrum/frequency", "Hz", "", spectrum.frequencies));
    arrays.push_back(series(group + "/spectrum/power_over_noise", "1",
                            "of the residuals, mean over the heights; 1: white noise",
                            spectrum.power));
    arrays.push_back(series(group + "/spectrum/mode_frequency", "Hz", "of the fitted chain",
                            spectrum.mode_frequencies));
    const auto add_times = [&](const char* name, double residuals::SwingWindow::*time) {
        const auto times = comparison.windows | std::views::transform(time);
        arrays.push_back(series(group + name, "s", "", {times.begin(), times.end()}));
    };
    add_times("/windows/begin", &residuals::SwingWindow::begin);
    add_times("/windows/end", &residuals::SwingWindow::end);
    add_windows(arrays, group + "/windows/measured", comparison.windows,
                &residuals::SwingWindow::measured);
    add_windows(arrays, group + "/windows/modelled", comparison.windows,
                &residuals::SwingWindow::modelled);
}

} // namespace

std::string
deflections_csv(const measure::Measurement& measurement,
                const std::vector<std::pair<std::string, const fit::RecordingFit*>>& models) {
    std::string text = "time_s";
    for (const double height : measurement.heights) {
        text += fmt::format(",measured h={:.10g}mm", 1e3 * height);
        for (const auto& [label, fit] : models)
            text += fmt::format(",{} h={:.10g}mm", label, 1e3 * height);
    }
    text += '\n';
    const std::size_t rows = measurement.heights.size();
    for (std::size_t i = 0; !models.empty() && i < models.front().second->times.size(); ++i) {
        text += fmt::format("{:.9g}", measurement.times[i]);
        for (std::size_t j = 0; j < rows; ++j) {
            text += csv_cell(1e3 * measurement.deflection(i, j));
            for (const auto& [label, fit] : models)
                text += csv_cell(1e3 * fit->prediction.readings[i * rows + j]);
        }
        text += '\n';
    }
    return text;
}

void write_comparison_arrays(const std::filesystem::path& file, const diagnose::Ladder& ladder,
                             const measure::Measurement& measurement) {
    std::vector<GroupTexts> groups{{"",
                                    {{"format", "culm comparison arrays"},
                                     {"version", "1.0"},
                                     {"measurement", measurement.stem.id}}}};
    std::vector<NamedArray> arrays;
    for (std::size_t k = 0; k < ladder.models.size(); ++k) {
        const fit::Fit& fit = ladder.models[k].fit;
        if (fit.failed())
            continue;
        if (arrays.empty()) // all fits have the same frames
            add_measured(arrays, "", fit.parts.front(), measurement);
        const std::string group = fmt::format("model_{}", k);
        groups.push_back({group, {{"model", model_name(fit.names())}}});
        add_model(arrays, group, fit.parts.front(), *ladder.models[k].comparison);
    }
    archive::write_array_file(file, groups, arrays);
}

void write_diagnosis_arrays(const std::filesystem::path& file, const diagnose::Diagnosis& diagnosis,
                            std::span<const measure::Measurement> recordings) {
    std::vector<const fit::Fit*> models{&diagnosis.baseline};
    if (const fit::Fit& last = diagnosis.final_fit;
        !last.failed() && last.names() != diagnosis.baseline.names())
        models.push_back(&last);
    std::vector<GroupTexts> groups{{"", {{"format", "culm diagnosis arrays"}, {"version", "1.0"}}}};
    std::vector<NamedArray> arrays;
    for (std::size_t k = 0; k < recordings.size(); ++k) {
        const std::string recording = fmt::format("recording_{}", k);
        groups.push_back({recording, {{"id", recordings[k].stem.id}}});
        for (std::size_t m = 0; m < models.size(); ++m) {
            if (k >= models[m]->parts.size())
                continue;
            const fit::RecordingFit& fit = models[m]->parts[k];
            if (m == 0)
                add_measured(arrays, recording + "/", fit, recordings[k]);
            const std::string group = fmt::format("{}/model_{}", recording, m);
            groups.push_back({group, {{"model", model_name(models[m]->names())}}});
            add_predicted(arrays, group, fit);
        }
    }
    archive::write_array_file(file, groups, arrays);
}

} // namespace culm::present
