// SPDX-License-Identifier: BSD-3-Clause
#include "core/decimal_text.hpp"
#include "core/units.hpp"
#include "measure/folder/measurement_files.hpp"
#include "measure/folder/stem_section.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace culm::measure {

namespace {

constexpr core::Interval stem_length = StemLimits::length;
constexpr core::Interval stem_width = StemLimits::width;
constexpr core::Interval positive{0.0, 1e12, true};
constexpr core::Interval masses{0.0, 1e3, true}; // kg
constexpr double largest_start = 1e10;           // s, also since 1970
constexpr core::Interval longest_hold{0.0, 1e7}; // s, that of the effect relaxation

/// The enumerator, from the first to `last`, whose word the key has; empty if it has none.
template <class Value>
std::optional<Value> read_choice(const core::TomlTable& table, const std::string& key, Value last) {
    std::vector<std::string> words;
    for (int k = 0; k <= static_cast<int>(last); ++k)
        words.emplace_back(to_string(static_cast<Value>(k)));
    const auto index = table.word(key, words);
    return index ? std::optional(static_cast<Value>(*index)) : std::nullopt;
}

void read_stem(const core::TomlTable& table, bool has_other_section, Measurement& measurement) {
    MeasuredStem& stem = measurement.stem;
    stem.id = table.text("id").value_or("");
    table.missing("id", "a name for this stem, in quotes");
    stem.length =
        table.required_quantity("length_mm", stem_length, "free length from the clamp to the tip");
    stem.poissons_ratio = table.number("poissons_ratio", {-1.0, 0.5, true});
    if (const auto spheres = table.whole_number("spheres", {3, 4096}))
        stem.spheres = static_cast<int>(*spheres);
    read_round_section(table, has_other_section, stem);
    measurement.uncertainties.length =
        read_uncertainty(table, "length_mm", stem.length, stem_length.high);
    measurement.uncertainties.diameter = read_uncertainty(
        table, "diameter_mm", std::get<CircularSection>(stem.section).diameter, stem_width.high);
    if (has_other_section && measurement.uncertainties.diameter)
        table.fault("diameter_uncertainty_mm", "a stem with a [section] has no diameter");
    const auto* const circle = std::get_if<CircularSection>(&stem.section);
    const double wall = circle != nullptr ? circle->wall.value_or(0.0) : 0.0;
    measurement.uncertainties.wall = read_uncertainty(table, "wall_mm", wall, stem_width.high);
    if (wall == 0.0 && measurement.uncertainties.wall)
        table.fault("wall_uncertainty_mm", "the file states no wall");
    measurement.specimen = table.text("specimen").value_or("");
    measurement.rig = table.text("rig").value_or("");
}

AddedMass read_added_mass(const core::TomlTable& table, const MeasuredStem& stem) {
    AddedMass added;
    added.height = table.required_quantity("height_mm", {0.0, stem_length.high},
                                           "of its centre above the clamp");
    added.mass = table.required_quantity("mass_g", masses, "of the added body");
    added.mass_last_digit = table.last_digit_of("mass_g");
    added.mass_uncertainty = read_uncertainty(table, "mass_g", added.mass, masses.high);
    check_is_on_stem(table, added.height, stem);
    return added;
}

void read_added_masses(const core::TomlTable& root, MeasuredStem& stem) {
    static_cast<void>(read_added_mass(root.absent("added_mass"), stem));
    for (const core::TomlTable& table : root.tables("added_mass"))
        stem.added_masses.push_back(read_added_mass(table, stem));
    std::ranges::stable_sort(stem.added_masses, {}, &AddedMass::height);
}

/// Numbers of `noise`, `offset_uncertainty` and `drift_uncertainty_per_s` are in the column's unit.
Sensor read_sensor(const core::TomlTable& table, Measurement& measurement) {
    Sensor sensor;
    sensor.column = table.text("column").value_or("");
    table.missing("column", "the name of its column in the table");
    const std::optional<Quantity> quantity = read_choice(table, "quantity", Quantity::Strain);
    table.missing("quantity", "\"displacement\", \"velocity\", \"acceleration\" or \"strain\"");
    sensor.quantity = quantity.value_or(Quantity::Displacement);
    sensor.unit = table.text("unit").value_or("");
    const std::string units = unit_names(sensor.quantity);
    table.missing("unit", "of the column: " + units);
    const std::optional<double> size = unit_size(sensor.quantity, sensor.unit);
    if (quantity && !size && table.is_text("unit"))
        table.fault("unit",
                    fmt::format("must be a unit of {}: {}", to_string(sensor.quantity), units));
    sensor.height = table.required_quantity("height_mm", {0.0, stem_length.high},
                                            "of the sensor above the clamp");
    const core::Interval distances{-stem_width.high, stem_width.high};
    sensor.distance_from_axis = table.quantity("distance_from_axis_mm", distances).value_or(0.0);
    if (quantity == Quantity::Strain && sensor.distance_from_axis == 0.0)
        table.missing("distance_from_axis_mm",
                      "of the fibre whose strain is measured, toward positive deflection");
    constexpr core::Interval cut_offs{0.0, 1e6, true};
    sensor.high_pass = table.number("high_pass_hz", cut_offs).value_or(0.0);
    sensor.low_pass = table.number("low_pass_hz", cut_offs).value_or(0.0);
    const auto in_si = [&](std::optional<double> value) {
        return value ? std::optional(*value * size.value_or(1.0)) : std::nullopt;
    };
    sensor.noise = in_si(table.number("noise", positive));
    sensor.scale_uncertainty = table.number("scale_uncertainty", {0.0, 1.0});
    sensor.offset_uncertainty = in_si(table.number("offset_uncertainty", {0.0, 1e12}));
    sensor.drift_uncertainty = in_si(table.number("drift_uncertainty_per_s", {0.0, 1e12}));
    MeasuredStem& stem = measurement.stem;
    if (table.has("mass_g") || table.has("mass_kg"))
        stem.added_masses.push_back(read_added_mass(table, stem));
    else
        check_is_on_stem(table, sensor.height, stem);
    return sensor;
}

void read_sensors(const core::TomlTable& root, Measurement& measurement) {
    static_cast<void>(read_sensor(root.absent("sensor"), measurement));
    static_cast<void>(read_added_mass(root.absent("sensor"), measurement.stem));
    for (const core::TomlTable& table : root.tables("sensor")) {
        Sensor sensor = read_sensor(table, measurement);
        if (std::ranges::find(measurement.sensors, sensor.column, &Sensor::column) !=
            measurement.sensors.end())
            table.fault("column", "is the column of two sensors");
        measurement.sensors.push_back(std::move(sensor));
    }
    std::ranges::stable_sort(measurement.stem.added_masses, {}, &AddedMass::height);
}

void read_camera(const core::TomlTable& table, Measurement& measurement) {
    constexpr core::Interval relative{0.0, 1.0, true};
    StatedUncertainties& stated = measurement.uncertainties;
    measurement.frames_per_second = table.number("fps", {0.0, 1e8, true});
    // 0 for a rate from a crystal.
    stated.frames_per_second = table.number("fps_uncertainty", {0.0, 1.0});
    stated.scale = table.number("scale_uncertainty", relative);
    stated.clamp = table.quantity("clamp_uncertainty_mm", {0.0, stem_length.high, true});
    if (const auto exposure = table.number("exposure_ms", StemLimits::frame_time_ms))
        measurement.exposure = core::with_point_moved(*exposure, -3);
    if (const auto row_time = table.number("row_time_us", {-1e3, 1e3}))
        measurement.row_time = core::with_point_moved(*row_time, -6);
    measurement.row_height = table.quantity("row_height_mm", {0.0, stem_length.high, true});
}

void read_measurement_table(const core::TomlTable& table, Measurement& measurement) {
    const core::Interval noise{0.0, 1.0, true};
    measurement.noise = table.quantity("noise_mm", noise);
    const std::string noise_key = table.spelling_of("noise_by_height_mm");
    const int power = noise_key.ends_with("_mm") ? -3 : 0;
    for (const double value : table.numbers(noise_key, {0.0, 1e3, true}))
        measurement.noise_by_height.push_back(core::with_point_moved(value, power));
    measurement.noise_source = table.text("noise_source").value_or("");
    measurement.noise_correlation = table.number("noise_correlation", {0.0, 0.99});
    measurement.uncertainties.row = table.quantity("row_uncertainty_mm", noise);
    measurement.gravity_direction =
        read_choice(table, "gravity_direction", GravityDirection::Transverse)
            .value_or(measurement.gravity_direction);
    measurement.reading =
        read_choice(table, "reading", Reading::Material).value_or(measurement.reading);
    measurement.hold_time = table.number("hold_time_s", longest_hold);
}

/// Does a number of the file give this value bit for bit? The TOML parser rounds it to a double
/// before its point is moved. A computed value may need SI units.
bool survives(double value, const core::Unit& unit) {
    const double parsed =
        core::parse_decimal(core::decimal_text(value, -unit.power_of_ten)).value_or(0.0);
    return unit.to_si(parsed) == value;
}

std::string line(const std::string& key, double value) {
    const core::Unit unit = core::split_key(key).unit.value_or(core::dimensionless);
    if (survives(value, unit))
        return fmt::format("{} = {}\n", key, core::decimal_text(value, -unit.power_of_ten));
    return fmt::format("{} = {}\n", core::si_key(key), core::decimal_text(value));
}

/// Keeps the trailing zeros of a mass, which state its precision.
std::string mass_line(const AddedMass& added) {
    std::string text = line("mass_g", added.mass);
    if (added.mass_last_digit <= 0.0 || !survives(added.mass, core::gram))
        return text;
    const double digit = core::with_point_moved(added.mass_last_digit, 3); // g
    const auto places = static_cast<std::size_t>(std::max(0.0, std::round(-std::log10(digit))));
    text.pop_back();
    if (const std::size_t point = text.find('.'); point == std::string::npos && places > 0)
        text += "." + std::string(places, '0');
    else if (places > 0 && text.size() - point - 1 < places)
        text.append(places - (text.size() - point - 1), '0');
    return text + "\n";
}

std::string noise_line(const std::vector<double>& noise) {
    const bool in_millimetres =
        std::ranges::all_of(noise, [](double value) { return survives(value, core::millimetre); });
    std::vector<std::string> list;
    list.reserve(noise.size());
    for (const double value : noise)
        list.push_back(core::decimal_text(value, in_millimetres ? 3 : 0));
    return fmt::format("noise_by_height_{} = [{}]\n", in_millimetres ? "mm" : "m",
                       fmt::join(list, ", "));
}

std::string uncertainty_line(const std::string& key, const std::optional<double>& value) {
    return value ? line(uncertainty_key(key), *value) : "";
}

std::string number_line(const std::string& key, const std::optional<double>& value, int power = 0) {
    return value ? fmt::format("{} = {}\n", key, core::decimal_text(*value, power)) : "";
}

std::string section_text(const Section& section, const StatedUncertainties& stated) {
    if (const auto* rectangle = std::get_if<RectangularSection>(&section))
        return "\n[section]\nshape = \"rectangle\"\n" + line("width_mm", rectangle->width) +
               uncertainty_line("width_mm", stated.section_width) +
               line("height_mm", rectangle->height) +
               uncertainty_line("height_mm", stated.section_height);
    if (const auto* general = std::get_if<GeneralSection>(&section))
        return "\n[section]\nshape = \"general\"\n" + line("area_mm2", general->area) +
               uncertainty_line("area_mm2", stated.section_area) +
               line("second_moment_mm4", general->second_moment) +
               uncertainty_line("second_moment_mm4", stated.second_moment);
    return "";
}

std::string quoted(const std::string& text) {
    std::string result = "\"";
    for (const char c : text) {
        if (c == '"' || c == '\\')
            result += '\\';
        if (static_cast<unsigned char>(c) < 0x20U)
            result += fmt::format("\\u{:04X}", static_cast<unsigned>(c));
        else
            result += c;
    }
    return result + '"';
}

std::string text_line(const std::string& key, const std::string& text) {
    return text.empty() ? "" : key + " = " + quoted(text) + "\n";
}

std::string stem_text(const Measurement& measurement) {
    const MeasuredStem& stem = measurement.stem;
    const StatedUncertainties& stated = measurement.uncertainties;
    std::string text = "[stem]\nid = " + quoted(stem.id) + "\n" + line("length_mm", stem.length) +
                       uncertainty_line("length_mm", stated.length);
    if (const auto* circle = std::get_if<CircularSection>(&stem.section)) {
        text += line("diameter_mm", circle->diameter) +
                uncertainty_line("diameter_mm", stated.diameter);
        if (circle->wall)
            text += line("wall_mm", *circle->wall) + uncertainty_line("wall_mm", stated.wall);
    }
    if (stem.is_density_of_spheres) {
        text += number_line("density_kg_m3", stem.density) +
                number_line("density_uncertainty_kg_m3", stated.density);
    } else {
        text += fmt::format("linear_density_kg_m = {:.12g}\n", mass_per_length(stem));
        if (stated.density)
            text += fmt::format("linear_density_uncertainty_kg_m = {:.12g}\n",
                                mass_per_length(stem) / stem.density * *stated.density);
    }
    text += number_line("poissons_ratio", stem.poissons_ratio);
    if (stem.spheres)
        text += fmt::format("spheres = {}\n", *stem.spheres);
    text += text_line("specimen", measurement.specimen) + text_line("rig", measurement.rig) +
            section_text(stem.section, stated);
    for (const AddedMass& mass : stem.added_masses)
        text += "\n[[added_mass]]\n" + line("height_mm", mass.height) + mass_line(mass) +
                uncertainty_line("mass_g", mass.mass_uncertainty);
    return text;
}

std::string camera_text(const Measurement& measurement) {
    const StatedUncertainties& stated = measurement.uncertainties;
    const std::string text = number_line("fps", measurement.frames_per_second) +
                             number_line("fps_uncertainty", stated.frames_per_second) +
                             number_line("scale_uncertainty", stated.scale) +
                             uncertainty_line("clamp_mm", stated.clamp) +
                             number_line("exposure_ms", measurement.exposure, 3) +
                             number_line("row_time_us", measurement.row_time, 6) +
                             number_line("row_height_mm", measurement.row_height, 3);
    return text.empty() ? "" : "\n[camera]\n" + text;
}

void read_release(const core::TomlTable& table, Measurement& measurement) {
    measurement.release =
        read_choice(table, "kind", ReleaseKind::Moving).value_or(measurement.release);
    if (const auto uncertainty = table.number("time_uncertainty_ms", {0.0, 1e6, true}))
        measurement.release_uncertainty = core::with_point_moved(*uncertainty, -3);
    if (measurement.release_uncertainty && measurement.release == ReleaseKind::Moving)
        table.fault("time_uncertainty_ms", "the release was not recorded (kind = \"moving\")");
    const auto start = table.number("start_s", {-largest_start, largest_start, true});
    measurement.start = start.value_or(0.0);
    if (start && measurement.release != ReleaseKind::Moving)
        table.fault("start_s", "only a release of kind = \"moving\" has a start");
}

} // namespace

void check_is_on_stem(const core::TomlTable& table, double height, const MeasuredStem& stem) {
    if (stem.length > 0.0 && height > stem.length)
        table.fault(table.spelling_of("height_mm"),
                    fmt::format("lies above the stem, which is {} mm long",
                                core::decimal_text(stem.length, 3)));
}

void read_stem_tables(const core::TomlTable& root, Measurement& measurement) {
    const core::TomlTable section = root.table("section");
    root.missing("stem", "write a table [stem] with id, length_mm, diameter_mm, density_kg_m3");
    read_stem(root.table("stem"), section.exists(), measurement);
    read_section(section, measurement);
    read_density(root.table("stem"), measurement);
    read_added_masses(root, measurement.stem);
    read_sensors(root, measurement);
    read_release(root.table("release"), measurement);
    read_camera(root.table("camera"), measurement);
    read_measurement_table(root.table("measurement"), measurement);
    if (measurement.row_time.value_or(0.0) != 0.0 && !measurement.row_height)
        measurement.remarks.push_back(fmt::format(
            "{}: no fit uses row_time_us without row_height_mm, the height of an image row on the "
            "stem; --with rolling_shutter fits the whole read-out time",
            root.file()));
}

Measurement read_stem_file(const std::filesystem::path& file) {
    core::TomlDocument document(file);
    Measurement measurement;
    read_stem_tables(document.root(), measurement);
    document.finish();
    return measurement;
}

std::string stem_file_text(const Measurement& measurement) {
    std::string text = stem_text(measurement);
    text += fmt::format("\n[release]\nkind = \"{}\"\n", to_string(measurement.release));
    if (measurement.start != 0.0)
        text += fmt::format("start_s = {}\n", measurement.start);
    text += number_line("time_uncertainty_ms", measurement.release_uncertainty, 3);
    text += camera_text(measurement);
    text += "\n[measurement]\n";
    if (measurement.noise)
        text += line("noise_mm", *measurement.noise);
    if (!measurement.noise_by_height.empty())
        text += noise_line(measurement.noise_by_height);
    text += text_line("noise_source", measurement.noise_source) +
            number_line("noise_correlation", measurement.noise_correlation) +
            uncertainty_line("row_mm", measurement.uncertainties.row);
    text += fmt::format("gravity_direction = \"{}\"\nreading = \"{}\"\n",
                        to_string(measurement.gravity_direction), to_string(measurement.reading));
    return text + number_line("hold_time_s", measurement.hold_time);
}

} // namespace culm::measure
