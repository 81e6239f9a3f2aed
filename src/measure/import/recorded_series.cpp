// SPDX-License-Identifier: BSD-3-Clause
#include "core/decimal_text.hpp"
#include "core/error.hpp"
#include "core/nearest_name.hpp"
#include "core/user_files.hpp"
#include "measure/folder/delimited_text.hpp"
#include "measure/import/import_recording.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace culm::measure {

namespace {

/// Every column or marker that the mapping uses, each once.
std::vector<std::string> names_used(const ImportMapping& mapping) {
    std::vector<std::string> names = mapping.clamp;
    for (const MappedHeight& height : mapping.heights)
        names.insert(names.end(), height.names.begin(), height.names.end());
    for (const Sensor& sensor : mapping.measurement.sensors)
        names.push_back(sensor.column);
    std::ranges::sort(names);
    names.erase(std::unique(names.begin(), names.end()), names.end());
    return names;
}

[[noreturn]] void refuse_name(const std::string& file, const std::string& kind,
                              const std::string& name, std::vector<std::string> valid) {
    const std::string nearest = core::nearest_name(name, valid);
    if (valid.size() > 20)
        valid.resize(20);
    throw core::InputError(
        fmt::format("{}: there is no {} \"{}\"{}; it has \"{}\"", file, kind, name,
                    nearest.empty() ? "" : fmt::format(" (did you mean \"{}\"?)", nearest),
                    fmt::join(valid, "\", \"")));
}

char guessed_delimiter(std::string_view text, bool has_decimal_comma) {
    const std::vector<DelimitedLine> lines = split_table(text.substr(0, 4096), '\n');
    const std::string line = lines.empty() ? "" : lines.front().cells.front();
    constexpr std::array candidates{';', '\t', ',', ' '};
    for (const char candidate : candidates)
        if (line.find(candidate) != std::string::npos && !(candidate == ',' && has_decimal_comma))
            return candidate;
    return ',';
}

std::string_view without_lines(std::string_view text, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) {
        const std::size_t end = text.find('\n');
        text = end == std::string_view::npos ? std::string_view{} : text.substr(end + 1);
    }
    return text;
}

/// Replaces runs of spaces by one space.
std::string with_single_spaces(std::string_view text) {
    std::string result;
    for (const char c : text)
        if (c != ' ' || (!result.empty() && result.back() != ' ' && result.back() != '\n'))
            result += c;
    return result;
}

std::size_t column_of(const std::string& file, const std::vector<std::string>& header,
                      const std::string& name) {
    if (const auto found = std::ranges::find(header, name); found != header.end())
        return static_cast<std::size_t>(found - header.begin());
    std::size_t number = 0;
    const char* const end = name.data() + name.size();
    const auto read = std::from_chars(name.data(), end, number);
    if (read.ec == std::errc{} && read.ptr == end && number >= 1 && number <= header.size())
        return number - 1;
    refuse_name(file, "column", name, header);
}

/// One cell of a table; NaN and a fault if it is not a number, only NaN if it is empty.
double read_cell(const DelimitedLine& line, std::size_t column, int power, bool has_decimal_comma,
                 core::FileFaults& faults) {
    constexpr double gap = std::numeric_limits<double>::quiet_NaN();
    std::string cell = column < line.cells.size() ? line.cells[column] : "";
    if (cell.empty() || cell == "NaN" || cell == "nan")
        return gap;
    if (has_decimal_comma)
        std::ranges::replace(cell, ',', '.');
    const auto value = core::parse_decimal(cell, power);
    if (!value)
        faults.add(line.number,
                   fmt::format("column {}: \"{}\" {}", column + 1, cell, why_not_a_number(cell)));
    return value.value_or(gap);
}

/// A column of the table, and its share of a series in SI units.
struct Part {
    std::size_t column = 0;
    int power_of_ten = 0;
    double factor = 1.0;
};

/// The column "NAME x" of a marker.
std::size_t marker_column(const std::string& file, const std::vector<std::string>& header,
                          const std::string& name, char direction) {
    const auto found = std::ranges::find(header, fmt::format("{} {}", name, direction));
    if (found != header.end())
        return static_cast<std::size_t>(found - header.begin());
    std::vector<std::string> markers;
    for (const std::string& column : header)
        if (column.ends_with(" x"))
            markers.push_back(column.substr(0, column.size() - 2));
    refuse_name(file, "marker", name, markers);
}

/// A marker's series is its position along the axis; others have one column.
std::vector<Part> parts_of(const std::string& name, const ImportMapping& mapping,
                           const std::vector<std::string>& header) {
    const std::string file = mapping.source.string();
    std::vector<Part> parts;
    for (std::size_t k = 0; mapping.has_markers && k < 3; ++k)
        parts.push_back({marker_column(file, header, name, "xyz"[k]), 0, mapping.axis[k]});
    if (mapping.has_markers)
        return parts;
    const std::size_t column = column_of(file, header, name);
    const auto sensor = std::ranges::find(mapping.measurement.sensors, name, &Sensor::column);
    if (sensor != mapping.measurement.sensors.end())
        return {{column, 0, unit_size(sensor->quantity, sensor->unit).value_or(1.0)}};
    return {{column, mapping.power_of_ten, mapping.sign * mapping.scale}};
}

double in_seconds(double time, const ImportMapping& mapping) {
    switch (mapping.time_unit) {
    case TimeUnit::Second:
        return time;
    case TimeUnit::Millisecond:
        return core::with_point_moved(time, -3);
    case TimeUnit::Microsecond:
        return core::with_point_moved(time, -6);
    case TimeUnit::Frame:
        break;
    }
    return time / mapping.measurement.frames_per_second.value_or(1.0);
}

void append_time(const DelimitedLine& line, double time, RecordedSeries& series,
                 core::FileFaults& faults) {
    if (std::isnan(time))
        faults.add(line.number, "the time is missing");
    else if (!series.times.empty() && time <= series.times.back())
        faults.add(line.number, fmt::format("time {:g} s does not come after {:g} s", time,
                                            series.times.back()));
    series.times.push_back(time);
}

} // namespace

const std::vector<double>& RecordedSeries::of(const std::string& name) const {
    return values[static_cast<std::size_t>(std::ranges::find(names, name) - names.begin())];
}

RecordedSeries read_recorded_table(const ImportMapping& mapping) {
    const std::string file = mapping.source.string();
    std::string text(without_lines(read_text_file(mapping.source), mapping.skipped_lines));
    const char delimiter = mapping.delimiter.value_or(
        mapping.has_markers ? ',' : guessed_delimiter(text, mapping.has_decimal_comma));
    if (delimiter == ' ')
        text = with_single_spaces(text);
    const std::vector<DelimitedLine> lines = split_table(text, delimiter);
    core::FileFaults faults(file);
    if (lines.size() < 2)
        throw core::InputError(fmt::format("{}: there is no table below its header", file));
    const std::vector<std::string>& header = lines.front().cells;
    const std::size_t time_column = column_of(file, header, mapping.time_column);
    RecordedSeries series;
    series.names = names_used(mapping);
    std::vector<std::vector<Part>> parts; // (series)
    for (const std::string& name : series.names)
        parts.push_back(parts_of(name, mapping, header));
    series.values.resize(parts.size());
    // If the first line consists of numbers, the table has no header.
    std::string first = header[time_column];
    if (mapping.has_decimal_comma)
        std::ranges::replace(first, ',', '.');
    const bool has_header = !core::parse_decimal(first);
    for (std::size_t i = has_header ? 1 : 0; i < lines.size(); ++i) {
        DelimitedLine line = lines[i];
        line.number += mapping.skipped_lines;
        const double time = read_cell(line, time_column, 0, mapping.has_decimal_comma, faults);
        append_time(line, in_seconds(time, mapping), series, faults);
        for (std::size_t k = 0; k < parts.size(); ++k) {
            double value = 0.0;
            for (const auto& [column, power, factor] : parts[k])
                value += factor * read_cell(line, column, power, mapping.has_decimal_comma, faults);
            series.values[k].push_back(value);
        }
    }
    faults.throw_if_any();
    return series;
}

} // namespace culm::measure
