// SPDX-License-Identifier: BSD-3-Clause
#include "core/toml/table.hpp"
#include "core/user_files.hpp"
#include "measure/folder/delimited_text.hpp"
#include "measure/folder/measurement_files.hpp"
#include "measure/import/import_recording.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace culm::measure {

namespace {

constexpr core::Interval any_time{-1e9, 1e9};
/// Largest number of columns or markers whose mean is one height.
constexpr std::size_t most_names = 1000;

/// "tip" and ["tip", "top"] are both lists of names. `key` is "markers" or "columns".
std::vector<std::string> names(const core::TomlTable& table, const std::string& key) {
    const std::string other = key == "markers" ? "columns" : "markers";
    if (table.has(other)) {
        static_cast<void>(table.is_text(other) ? std::vector{table.text(other).value_or("")}
                                               : table.texts(other));
        table.fault(other, key == "markers"
                               ? "belongs to tables; of markers give markers"
                               : "belongs to files with markers; of a table give columns");
    }
    return table.is_text(key) ? std::vector{table.text(key).value_or("")} : table.texts(key);
}

void read_source(const core::TomlTable& table, const std::filesystem::path& folder,
                 bool is_named_elsewhere, ImportMapping& mapping) {
    const auto file = table.text("file");
    if (!is_named_elsewhere) {
        table.missing("file", "the recording, relative to this file");
        if (const std::string fault = core::named_path_fault(file.value_or("."));
            !fault.empty() && table.is_text("file"))
            table.fault("file", fault + "; `culm import --recording` takes any file");
        mapping.source = folder / file.value_or("");
    }
    const std::array<std::string, 4> delimiters{",", ";", "tab", "space"};
    constexpr std::array<char, 4> characters{',', ';', '\t', ' '};
    if (const auto index = table.word("delimiter", delimiters))
        mapping.delimiter = characters[*index];
    const std::array<std::string, 2> decimals{".", ","};
    mapping.has_decimal_comma = table.word("decimal", decimals).value_or(0) == 1;
    if (mapping.has_decimal_comma && mapping.delimiter == ',')
        table.fault("decimal", "the delimiter is a comma too");
    mapping.skipped_lines =
        static_cast<std::size_t>(table.whole_number("skip_lines", {0, 100000}).value_or(0));
}

void read_time(const core::TomlTable& table, ImportMapping& mapping) {
    const std::array<std::string, 4> units{"s", "ms", "us", "frame"};
    mapping.time_column = table.text("column").value_or(mapping.has_markers ? "t" : "");
    if (mapping.has_markers && table.has("column"))
        table.fault("column", "a file with markers has its own times");
    if (!mapping.has_markers)
        table.missing("column", "the name or the number of the time column, in quotes");
    mapping.time_unit = static_cast<TimeUnit>(table.word("unit", units).value_or(0));
    if (mapping.time_unit == TimeUnit::Frame && !mapping.measurement.frames_per_second)
        table.fault("unit", "frame numbers need [camera] fps");
    if (!table.is_text("release_s"))
        mapping.release = table.number("release_s", any_time);
    else if (table.text("release_s") != "detect")
        table.fault("release_s", "must be a number or \"detect\"");
    if (mapping.measurement.release != ReleaseKind::Moving)
        table.missing("release_s", "time of the release in the recording, or \"detect\"");
    else if (table.has("release_s"))
        table.fault("release_s", "the release was not recorded ([release] kind = \"moving\")");
    mapping.before = table.number("before_s", {0.0, 1e6});
    mapping.after = table.number("after_s", {0.0, 1e6, true});
}

void read_motion(const core::TomlTable& table, ImportMapping& mapping) {
    const std::array<std::string, 5> units{"mm", "cm", "m", "um", "px"};
    constexpr std::array powers{-3, -2, 0, -6, -3};
    const auto unit = table.word("unit", units);
    if (unit && mapping.has_markers)
        table.fault("unit", "a file with markers says its own");
    mapping.power_of_ten = mapping.has_markers ? 0 : powers[unit.value_or(0)];
    if (unit && units[*unit] == "px") {
        table.missing("mm_per_px", "the scale of the picture");
        mapping.scale = table.number("mm_per_px", {0.0, 1e3, true}).value_or(1.0);
    }
    if (!mapping.has_markers)
        table.missing("unit", "of the deflections: \"mm\", \"cm\", \"m\", \"um\" or \"px\"");
    const std::array<std::string, 3> zeros{"before_release", "at_rest", "as_given"};
    table.missing("zero", "\"before_release\" (held straight), \"at_rest\" or \"as_given\"");
    mapping.zero = static_cast<ZeroDeflection>(table.word("zero", zeros).value_or(2));
    const auto axis = table.numbers("axis", {-1e9, 1e9});
    const double length = axis.size() == 3 ? std::hypot(axis[0], axis[1], axis[2]) : 0.0;
    if (mapping.has_markers) {
        table.missing("axis", "direction of positive deflection, [x, y, z]");
        if (table.has("axis") && length == 0.0)
            table.fault("axis", "must be three numbers, not all 0");
        for (std::size_t i = 0; length > 0.0 && i < 3; ++i)
            mapping.axis[i] = axis[i] / length;
        if (table.has("sign"))
            table.fault("sign", "belongs to tables; turn the axis round instead");
    }
    const auto sign = table.whole_number("sign", {-1, 1});
    if (sign == 0)
        table.fault("sign", "must be 1 or -1");
    mapping.sign = static_cast<double>(sign.value_or(1));
}

MappedHeight read_height(const core::TomlTable& table, const std::string& key,
                         const ImportMapping& mapping) {
    MappedHeight mapped;
    mapped.height = table.required_length("height", {0.0, 100.0}, "above the clamp");
    table.missing(key, fmt::format("the {} of the recording at this height; of several the mean is "
                                   "taken",
                                   key));
    mapped.names = names(table, key);
    if (mapped.names.size() > most_names)
        table.fault(
            key, fmt::format("{} names; at most {} are allowed", mapped.names.size(), most_names));
    check_is_on_stem(table, mapped.height, mapping.measurement.stem);
    for (const MappedHeight& other : mapping.heights)
        if (other.height == mapped.height)
            table.fault(table.key_of("height", core::length_unit), "is given twice");
    return mapped;
}

void read_heights(const core::TomlTable& root, const std::string& key, ImportMapping& mapping) {
    static_cast<void>(read_height(root.absent("height"), key, mapping));
    if (mapping.measurement.sensors.empty())
        root.missing("height", fmt::format("write a table [[height]] with height_mm and {} for "
                                           "each height, or [[sensor]] tables",
                                           key));
    const std::vector<core::TomlTable> tables = root.tables("height");
    if (tables.size() > most_heights) {
        root.fault("height",
                   fmt::format("{} tables; at most {} are allowed", tables.size(), most_heights));
        return;
    }
    for (const core::TomlTable& table : tables)
        mapping.heights.push_back(read_height(table, key, mapping));
}

} // namespace

bool needs_conversion(const std::filesystem::path& recording) {
    constexpr std::array<std::string_view, 5> formats{".c3d", ".trk", ".mat", ".npy", ".npz"};
    return std::ranges::find(formats, lower_case(recording.extension().string())) != formats.end();
}

ImportMapping read_import_mapping(const std::filesystem::path& file,
                                  const std::filesystem::path& source) {
    core::TomlDocument document(file);
    const core::TomlTable& root = document.root();
    ImportMapping mapping;
    mapping.source = source;
    read_stem_tables(root, mapping.measurement);
    if (source.empty())
        root.missing("source", "write a table [source] with file");
    read_source(root.table("source"), file.parent_path(), !source.empty(), mapping);
    mapping.has_markers = lower_case(mapping.source.extension().string()) == ".c3d" ||
                          root.table("motion").has("axis");
    root.missing("time", "write a table [time] with release_s (and column for a table)");
    read_time(root.table("time"), mapping);
    if (mapping.measurement.sensors.empty() || root.has("height"))
        root.missing("motion",
                     "write a table [motion] with zero (and unit, or axis for a C3D file)");
    if (mapping.measurement.sensors.empty() || root.has("motion") || root.has("height"))
        read_motion(root.table("motion"), mapping);
    const std::string key = mapping.has_markers ? "markers" : "columns";
    mapping.clamp = names(root.table("clamp"), key);
    read_heights(root, key, mapping);
    if (mapping.has_markers && root.has("sensor"))
        root.fault("sensor", "belongs to tables; of a C3D file give [[height]] tables");
    document.finish();
    return mapping;
}

} // namespace culm::measure
