// SPDX-License-Identifier: BSD-3-Clause
#include "core/decimal_text.hpp"
#include "core/order_statistics.hpp"
#include "core/user_files.hpp"
#include "measure/folder/delimited_text.hpp"
#include "measure/folder/measurement.hpp"
#include "measure/folder/measurement_files.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>

namespace culm::measure {

namespace {

struct DeflectionHeader {
    std::vector<Sensor> columns; ///< in their order; a camera's row has its height only
    std::vector<double> sizes;   ///< SI units per unit of the column; 0: a camera's
    int power_of_ten = -3;   ///< of the unit of a camera's heights and deflections: mm −3, m 0
    std::size_t unnamed = 0; ///< columns without a name at the end
};

std::string without_spaces(std::string_view text) {
    std::string result(text);
    std::erase_if(result, [](char c) { return c == ' ' || c == '\t'; });
    return result;
}

/// The parts of "h=14mm".
struct HeightName {
    std::string number;
    std::string unit;
};

std::optional<HeightName> split_height(std::string_view name) {
    const std::string text = without_spaces(name);
    if (!text.starts_with("h="))
        return std::nullopt;
    const std::size_t end = text.find_last_of("0123456789.");
    if (end == std::string::npos || end < 2)
        return std::nullopt;
    return HeightName{text.substr(2, end - 1), text.substr(end + 1)};
}

std::string column_hint(std::string_view name) {
    if (name.find(',') != std::string_view::npos)
        return "has a decimal comma; write a decimal point";
    const std::string lower = lower_case(without_spaces(name));
    if (core::parse_decimal(lower))
        return fmt::format("must be a height with its unit: write \"h={}mm\"", lower);
    if (lower.starts_with("h="))
        return fmt::format("must be a height with its unit, mm or m: write \"{}\"",
                           lower.find("mm") == std::string::npos ? "h=14mm" : lower);
    return "must be \"h=<height>mm\" (or m), for example \"h=14mm\", or the column of a "
           "[[sensor]] in stem.toml; remove other columns (`culm import` picks columns from any "
           "table)";
}

void check_time_name(const DelimitedLine& line, core::FileFaults& faults) {
    const std::string& name = line.cells.front();
    if (name == "time_s")
        return;
    const std::string text = without_spaces(name);
    std::string hint = "the first column must be \"time_s\", the time in s from the release";
    if (text == "time_ms" || text == "time[ms]" || text == "t_ms")
        hint = "time must be in s: divide by 1000 and name the column \"time_s\"";
    else if (core::parse_decimal(text))
        hint = "the file has no header: the first line must be \"time_s,h=<height>mm,...\"";
    else if (text.starts_with("h="))
        hint = "the column \"time_s\" must be the first";
    faults.add(line.number, fmt::format("\"{}\": {}", name, hint));
}

struct Column {
    double height = 0.0; // m
    int power = -3;
};

/// One height column; empty after a fault has been recorded.
std::optional<Column> read_column(const std::string& name, std::size_t line,
                                  core::FileFaults& faults) {
    const std::optional<HeightName> parts = split_height(name);
    const bool known_unit = parts && (parts->unit == "mm" || parts->unit == "m");
    if (parts && !known_unit) {
        faults.add(line,
                   fmt::format(
                       "column \"{}\": {}", name,
                       parts->unit.empty()
                           ? fmt::format("the unit is missing: write \"h={}mm\"", parts->number)
                           : fmt::format("\"{}\" is not a unit known here; mm or m", parts->unit)));
        return std::nullopt;
    }
    const int power = parts && parts->unit == "m" ? 0 : -3;
    const std::optional<double> height =
        parts ? core::parse_decimal(parts->number, power) : std::nullopt;
    if (!height) {
        faults.add(line, fmt::format("column \"{}\" {}", name, column_hint(name)));
        return std::nullopt;
    }
    return Column{*height, power};
}

void check_height(const std::string& name, const DeflectionHeader& header, std::size_t line,
                  const MeasuredStem& stem, core::FileFaults& faults) {
    const double height = header.columns.back().height;
    if (height < 0.0)
        faults.add(line, fmt::format("column \"{}\" lies below the clamp", name));
    // The height of a mark at the tip may differ from the length by a rounding error.
    if (height > stem.length * (1.0 + 1e-9))
        faults.add(line, fmt::format("column \"{}\" lies above the stem, which is {} mm long", name,
                                     core::decimal_text(stem.length, 3)));
    const auto first = std::ranges::find_if(header.columns, [&](const Sensor& each) {
        return each.is_camera() && each.height == height;
    });
    if (first + 1 != header.columns.end())
        faults.add(line, fmt::format("column \"{}\": column {} has the same height", name,
                                     first - header.columns.begin() + 2));
}

/// True if the whole line is in one cell, or if the first cell contains another separator.
bool has_other_delimiter(const DelimitedLine& line, core::FileFaults& faults) {
    const std::string& first = line.cells.front();
    const bool is_other = !first.starts_with("h=") &&
                          (first.find_first_of(";\t|=") != std::string::npos ||
                           (line.cells.size() == 1 && first.find(' ') != std::string::npos));
    if (is_other)
        faults.add(line.number,
                   "cells are not separated by commas; write commas, and decimal points "
                   "in the numbers (`culm import` reads tables of any form)");
    return is_other;
}

/// Every sensor of stem.toml must have a column.
void check_sensors(const DelimitedLine& line, const std::vector<Sensor>& sensors,
                   core::FileFaults& faults) {
    for (const Sensor& sensor : sensors)
        if (!sensor.is_camera() && std::ranges::find(line.cells, sensor.column) == line.cells.end())
            faults.add(
                line.number,
                fmt::format("there is no column \"{}\", which a [[sensor]] of stem.toml names",
                            sensor.column));
}

/// Reads "time_s,h=<height><unit>,…" and the columns of sensors. The unit of the heights, mm or m,
/// is the same in all columns and applies to the deflections too. Records faults; the result is
/// complete only if there are none.
DeflectionHeader read_deflection_header(const DelimitedLine& line, const Measurement& measurement,
                                        core::FileFaults& faults) {
    DeflectionHeader header;
    if (has_other_delimiter(line, faults))
        return header;
    check_time_name(line, faults);
    std::size_t named = line.cells.size();
    while (named > 1 && line.cells[named - 1].empty())
        --named;
    header.unnamed = line.cells.size() - named;
    if (named == 1)
        faults.add(line.number, "there is no height: the columns after time_s must be "
                                "\"h=<height>mm\"");
    if (named > most_heights + 1) {
        faults.add(line.number,
                   fmt::format("{} heights; at most {} are allowed", named - 1, most_heights));
        return header;
    }
    check_sensors(line, measurement.sensors, faults);
    std::optional<int> power;
    for (std::size_t i = 1; i < named; ++i) {
        if (const auto sensor =
                std::ranges::find(measurement.sensors, line.cells[i], &Sensor::column);
            sensor != measurement.sensors.end() && !sensor->is_camera()) {
            header.columns.push_back(*sensor);
            header.sizes.push_back(unit_size(sensor->quantity, sensor->unit).value_or(1.0));
            continue;
        }
        const std::optional<Column> column = read_column(line.cells[i], line.number, faults);
        if (!column)
            continue;
        if (power && column->power != *power)
            faults.add(line.number, fmt::format("column \"{}\": all heights must have one unit, "
                                                "which is that of the deflections as well",
                                                line.cells[i]));
        power = column->power;
        header.columns.emplace_back().height = column->height;
        header.sizes.push_back(0.0);
        check_height(line.cells[i], header, line.number, measurement.stem, faults);
    }
    header.power_of_ten = power.value_or(-3);
    return header;
}

constexpr double nothing_seen = std::numeric_limits<double>::quiet_NaN();

bool is_gap(const std::string& cell) {
    return cell.empty() || cell == "nan" || cell == "NaN" || cell == "NAN";
}

/// Checks the number of cells of a line.
bool has_right_length(const DelimitedLine& line, std::size_t columns,
                      const DeflectionHeader& header, core::FileFaults& faults) {
    if (line.cells.size() == columns || line.cells.size() == columns + header.unnamed)
        return true;
    faults.add(line.number,
               fmt::format("has {} cells, but the header has {} columns (commas separate "
                           "cells, and are no decimal signs)",
                           line.cells.size(), columns));
    return false;
}

void read_time(const DelimitedLine& line, Measurement& measurement, core::FileFaults& faults) {
    const std::string& cell = line.cells.front();
    const std::optional<double> time = core::parse_decimal(cell);
    if (!time) {
        faults.add(line.number, fmt::format("time \"{}\" {}", cell, why_not_a_number(cell)));
        return;
    }
    if (!measurement.times.empty() && *time <= measurement.times.back())
        faults.add(line.number,
                   fmt::format("time {} s does not come after {} s of the line before: times must "
                               "ascend",
                               cell, core::decimal_text(measurement.times.back())));
    measurement.times.push_back(*time);
}

/// A reading in SI units. A deflection that exceeds the stem's length indicates a wrong unit.
double read_cell(const DelimitedLine& line, std::size_t column, const DeflectionHeader& header,
                 const MeasuredStem& stem, core::FileFaults& faults) {
    const double size = header.sizes[column - 1];
    const bool is_sensor = size > 0.0;
    const std::string& cell = line.cells[column];
    if (is_gap(cell))
        return nothing_seen;
    const std::optional<double> value =
        core::parse_decimal(cell, is_sensor ? 0 : header.power_of_ten);
    if (!value)
        faults.add(line.number,
                   fmt::format("column {}: \"{}\" {}", column + 1, cell, why_not_a_number(cell)));
    else if (!is_sensor && std::abs(*value) > 1.05 * stem.length)
        faults.add(line.number,
                   fmt::format("column {}: a deflection of {} m is more than the stem's length, {} "
                               "m: is the unit in the header right?",
                               column + 1, core::decimal_text(*value),
                               core::decimal_text(stem.length)));
    return value ? *value * (is_sensor ? size : 1.0) : nothing_seen;
}

void read_line(const DelimitedLine& line, const DeflectionHeader& header, Measurement& measurement,
               core::FileFaults& faults) {
    const std::size_t columns = header.columns.size() + 1;
    if (!has_right_length(line, columns, header, faults))
        return;
    const std::size_t before = measurement.times.size();
    read_time(line, measurement, faults);
    for (std::size_t i = columns; i < line.cells.size(); ++i)
        if (!line.cells[i].empty())
            faults.add(line.number, fmt::format("column {} has no name in the header", i + 1));
    for (std::size_t i = 1; i < columns; ++i) {
        const double value = read_cell(line, i, header, measurement.stem, faults);
        // A line without a valid time adds no row, so that the arrays keep their shape. Its cells
        // are checked nevertheless.
        if (measurement.times.size() > before)
            measurement.deflections.push_back(value);
    }
}

/// Another unit or frame numbers instead of seconds are faults. Any other disagreement with the
/// camera's rate is a remark, because the times of the table are used.
void check_frame_rate(Measurement& measurement, core::FileFaults& faults) {
    if (!measurement.frames_per_second || measurement.times.size() < 3)
        return;
    const double rate = *measurement.frames_per_second;
    // The median, because frames may be missing.
    const double step = core::median_interval(measurement.times);
    const double frames = step * rate;
    for (const auto& [unit, size] : {std::pair{"ms", 1e3}, {"us", 1e6}, {"ns", 1e9}, {"ks", 1e-3}})
        if (std::abs(frames / size - 1.0) < 0.02)
            faults.add(0, fmt::format("times advance by {:.4g}, which is a frame in {} at {:g} "
                                      "frames/s: time_s must be in s",
                                      step, unit, rate));
    if (step == 1.0 && rate > 2.0)
        faults.add(0,
                   fmt::format("times advance by 1, as frame numbers: divide them by {:g}", rate));
    else if (std::abs(frames - std::round(frames)) > 0.03 * frames || frames < 0.5)
        measurement.remarks.push_back(
            fmt::format("{}: times advance by {:.6g} s, which counts; [camera] fps = {:g} means "
                        "{:.6g} s",
                        faults.file(), step, rate, 1.0 / rate));
}

void check_times(Measurement& measurement, core::FileFaults& faults) {
    const std::vector<double>& times = measurement.times;
    if (times.empty())
        faults.add(0, "there are no lines after the header");
    else if (times.back() <= 0.0)
        faults.add(0, fmt::format("the last time is {} s: nothing was recorded after the release, "
                                  "which is t = 0",
                                  core::decimal_text(times.back())));
    check_frame_rate(measurement, faults);
}

void check_columns(const DeflectionHeader& header, const Measurement& measurement,
                   core::FileFaults& faults) {
    for (std::size_t j = 0; j < header.columns.size(); ++j) {
        const std::vector<double> history = measurement.history(j);
        if (std::ranges::all_of(history, [](double value) { return std::isnan(value); }))
            faults.add(0, fmt::format("column {} is empty: delete it", j + 2));
    }
    const std::size_t noises = measurement.noise_by_height.size();
    if (noises != 0 && noises != header.columns.size())
        faults.add(0, fmt::format("has {} heights, but stem.toml gives noise_by_height for {}",
                                  header.columns.size(), noises));
}

/// The noise of the sensors is that of their columns, if all of them state one.
void take_sensor_noise(Measurement& measurement) {
    std::vector<double> noise;
    for (const Sensor& sensor : measurement.sensors)
        if (const auto& stated = sensor.is_camera() ? measurement.noise : sensor.noise)
            noise.push_back(*stated);
    if (noise.size() == measurement.sensors.size() && measurement.noise_by_height.empty())
        measurement.noise_by_height = std::move(noise);
}

void sort_columns(Measurement& measurement) {
    const Measurement unsorted = measurement;
    std::vector<std::size_t> order(measurement.heights.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::ranges::stable_sort(order, {}, [&](std::size_t j) { return unsorted.heights[j]; });
    for (std::size_t j = 0; j < order.size(); ++j) {
        measurement.heights[j] = unsorted.heights[order[j]];
        if (!unsorted.sensors.empty())
            measurement.sensors[j] = unsorted.sensors[order[j]];
        if (!unsorted.noise_by_height.empty())
            measurement.noise_by_height[j] = unsorted.noise_by_height[order[j]];
        for (std::size_t i = 0; i < measurement.times.size(); ++i)
            measurement.deflections[i * order.size() + j] = unsorted.deflection(i, order[j]);
    }
}

} // namespace

void read_deflection_file(const std::filesystem::path& file, Measurement& measurement) {
    const std::vector<DelimitedLine> lines = split_table(read_text_file(file), ',');
    core::FileFaults faults(file.string());
    if (lines.empty())
        faults.add(0, "there is no header: the first line must be \"time_s,h=<height>mm,...\"");
    faults.throw_if_any();
    const DeflectionHeader header = read_deflection_header(lines.front(), measurement, faults);
    // Lines cannot be checked without a header.
    faults.throw_if_any();
    for (const Sensor& column : header.columns)
        measurement.heights.push_back(column.height);
    if (!measurement.sensors.empty()) {
        measurement.sensors = header.columns;
        take_sensor_noise(measurement);
    }
    for (std::size_t i = 1; i < lines.size(); ++i)
        read_line(lines[i], header, measurement, faults);
    faults.throw_if_any();
    check_times(measurement, faults);
    check_columns(header, measurement, faults);
    faults.throw_if_any();
    sort_columns(measurement);
}

std::string deflection_file_text(const Measurement& measurement) {
    std::string text = "time_s";
    for (const double height : measurement.heights)
        text += fmt::format(",h={}mm", core::decimal_text(height, 3));
    text += '\n';
    for (std::size_t i = 0; i < measurement.times.size(); ++i) {
        text += core::decimal_text(measurement.times[i]);
        for (std::size_t j = 0; j < measurement.heights.size(); ++j) {
            const double value = measurement.deflection(i, j);
            text += ',';
            if (!std::isnan(value))
                text += core::decimal_text(value, 3);
        }
        text += '\n';
    }
    return text;
}

} // namespace culm::measure
