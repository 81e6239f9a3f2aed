// SPDX-License-Identifier: BSD-3-Clause
#include "present/files.hpp"

#include "core/user_files.hpp"

namespace culm::present {

void write_json(const std::string& file, const nlohmann::json& json) {
    // Names from damaged or foreign files need not be UTF-8.
    const std::string text =
        json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + '\n';
    if (file == "-")
        fmt::print("{}", text);
    else
        core::write_text(file, text);
}

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

} // namespace culm::present
