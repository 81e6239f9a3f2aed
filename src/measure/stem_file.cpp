// SPDX-License-Identifier: BSD-3-Clause
#include "measure/stem_file.hpp"

#include "measure/decimal_text.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace culm::measure {

namespace {

// Widths of what may lie on a bench, m; a length in the wrong unit falls outside or near the ends.
constexpr NumberRange stem_length{1e-3, 100.0};
constexpr NumberRange stem_width{1e-5, 10.0};
constexpr NumberRange positive{0.0, 1e12, true};
constexpr NumberRange longest_hold{0.0, 1e7}; // s, that of the effect relaxation

template <std::size_t N>
std::vector<std::string> words(const std::array<std::string_view, N>& names) {
    return {names.begin(), names.end()};
}

void read_section(TomlTable& table, MeasuredStem& stem) {
    const std::array<std::string, 2> shapes{"rectangle", "general"};
    const auto shape = table.word("shape", shapes);
    table.missing("shape", "must be \"rectangle\" or \"general\"");
    constexpr std::array<std::string_view, 2> of_rectangle{"width", "height"};
    constexpr std::array general_quantities{std::pair{"area", area_unit},
                                            std::pair{"second_moment", second_moment_unit}};
    if (shape && *shape == 0) {
        stem.section = RectangularSection{
            table.required_length("width", stem_width, "across the plane of motion"),
            table.required_length("height", stem_width, "in the direction of the motion")};
        for (const auto& [name, unit] : general_quantities)
            if (table.has(table.key_of(name, unit)))
                table.fault(table.key_of(name, unit), "belongs to shape = \"general\"");
    } else if (shape) {
        stem.section =
            GeneralSection{table.required_quantity("area", area_unit, positive, "of the section"),
                           table.required_quantity("second_moment", second_moment_unit, positive,
                                                   "for bending in the plane of motion")};
        for (const std::string_view name : of_rectangle)
            if (table.has(table.key_of(std::string(name), length_unit)))
                table.fault(table.key_of(std::string(name), length_unit),
                            "belongs to shape = \"rectangle\"");
    }
}

void read_round_section(TomlTable& table, bool has_other_section, MeasuredStem& stem) {
    const auto wall = table.length("wall", {0.0, stem_width.high, true});
    const std::string wall_key = table.key_of("wall", length_unit);
    if (has_other_section) {
        static_cast<void>(table.length("diameter", stem_width));
        // The diameter of a round stem or a section, not both: which would count?
        for (const std::string& key : {table.key_of("diameter", length_unit), wall_key})
            if (table.has(key))
                table.fault(key, "the file also has a [section]: one of them must go");
        return;
    }
    const double diameter = table.required_length(
        "diameter", stem_width, "outer diameter (or a [section] for other shapes)");
    if (diameter > 0.0 && wall && *wall >= 0.5 * diameter)
        table.fault(wall_key, fmt::format("must be below half the diameter, {} mm",
                                          decimal_text(0.5 * diameter, 3)));
    stem.section = CircularSection{diameter, wall};
}

void read_stem(TomlTable& table, bool has_other_section, MeasuredStem& stem) {
    stem.id = table.text("id").value_or("");
    table.missing("id", "a name for this stem, in quotes");
    stem.length =
        table.required_length("length", stem_length, "free length from the clamp to the tip");
    stem.density = table.number("density_kg_m3", {1e-3, 1e5}).value_or(0.0);
    table.missing("density_kg_m3", "in kg/m³");
    stem.poissons_ratio = table.number("poissons_ratio", {-1.0, 0.5, true});
    if (const auto spheres = table.whole_number("spheres", {3, 4096}))
        stem.spheres = static_cast<int>(*spheres);
    read_round_section(table, has_other_section, stem);
}

void read_added_masses(TomlTable& root, MeasuredStem& stem, std::vector<std::string>& remarks) {
    for (TomlTable& table : root.tables("added_mass")) {
        const double height = table.required_length("height", {0.0, stem_length.high},
                                                    "of its centre above the clamp");
        const double mass =
            table.required_quantity("mass", mass_unit, {0.0, 1e3, true}, "of the added body");
        if (stem.length > 0.0 && height > stem.length)
            table.fault(table.key_of("height", length_unit),
                        fmt::format("lies above the stem, which is {} mm long",
                                    decimal_text(stem.length, 3)));
        stem.added_masses.push_back({height, mass});
        table.finish(remarks);
    }
    std::ranges::stable_sort(stem.added_masses, {}, &AddedMass::height);
}

void read_measurement_table(TomlTable& table, Measurement& measurement) {
    const NumberRange noise{0.0, 1.0, true};
    measurement.noise = table.length("noise", noise);
    const std::string noise_key = table.key_of("noise_by_height", length_unit);
    const int power = noise_key.ends_with("_mm") ? -3 : 0;
    for (const double value : table.numbers(noise_key, {0.0, 1e3, true}))
        measurement.noise_by_height.push_back(with_point_moved(value, power));
    measurement.noise_source = table.text("noise_source").value_or("");
    constexpr std::array directions{GravityDirection::None, GravityDirection::Axial,
                                    GravityDirection::Transverse};
    const std::array<std::string, 3> direction_words{"none", "axial", "transverse"};
    if (const auto index = table.word("gravity_direction", direction_words))
        measurement.gravity_direction = directions[*index];
    const std::array<std::string, 2> readings{"row", "material"};
    if (const auto index = table.word("reading", readings))
        measurement.reading = *index == 0 ? Reading::Row : Reading::Material;
    measurement.hold_time = table.number("hold_time_s", longest_hold);
}

/// Whether a number of the file, which the TOML parser rounds to a double before its point is
/// moved, gives this value bit for bit. A computed value may need SI units.
bool survives(double value, const KeyUnit& unit) {
    const double parsed = parse_decimal(decimal_text(value, -unit.power_of_ten)).value_or(0.0);
    return with_point_moved(parsed, unit.power_of_ten) == value;
}

std::string line(const std::string& name, double value, const KeyUnit& unit = length_unit) {
    if (survives(value, unit))
        return fmt::format("{}_{} = {}\n", name, unit.small,
                           decimal_text(value, -unit.power_of_ten));
    return fmt::format("{}_{} = {}\n", name, unit.si, decimal_text(value));
}

std::string noise_line(const std::vector<double>& noise) {
    const bool in_millimetres =
        std::ranges::all_of(noise, [](double value) { return survives(value, length_unit); });
    std::vector<std::string> list;
    list.reserve(noise.size());
    for (const double value : noise)
        list.push_back(decimal_text(value, in_millimetres ? 3 : 0));
    return fmt::format("noise_by_height_{} = [{}]\n", in_millimetres ? "mm" : "m",
                       fmt::join(list, ", "));
}

std::string section_text(const Section& section) {
    if (const auto* rectangle = std::get_if<RectangularSection>(&section))
        return "\n[section]\nshape = \"rectangle\"\n" + line("width", rectangle->width) +
               line("height", rectangle->height);
    if (const auto* general = std::get_if<GeneralSection>(&section))
        return "\n[section]\nshape = \"general\"\n" + line("area", general->area, area_unit) +
               line("second_moment", general->second_moment, second_moment_unit);
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

std::string stem_text(const MeasuredStem& stem) {
    std::string text = "[stem]\nid = " + quoted(stem.id) + "\n" + line("length", stem.length);
    if (const auto* circle = std::get_if<CircularSection>(&stem.section)) {
        text += line("diameter", circle->diameter);
        if (circle->wall)
            text += line("wall", *circle->wall);
    }
    text += fmt::format("density_kg_m3 = {}\n", decimal_text(stem.density));
    if (stem.poissons_ratio)
        text += fmt::format("poissons_ratio = {}\n", decimal_text(*stem.poissons_ratio));
    if (stem.spheres)
        text += fmt::format("spheres = {}\n", *stem.spheres);
    text += section_text(stem.section);
    for (const AddedMass& mass : stem.added_masses)
        text +=
            "\n[[added_mass]]\n" + line("height", mass.height) + line("mass", mass.mass, mass_unit);
    return text;
}

} // namespace

void read_stem_tables(TomlTable& root, Measurement& measurement) {
    TomlTable section = root.table("section");
    TomlTable stem = root.table("stem");
    if (!stem.exists() && !root.has("stem"))
        root.missing("stem", "write a table [stem] with id, length_mm, diameter_mm, density_kg_m3");
    else
        read_stem(stem, section.exists(), measurement.stem);
    if (section.exists())
        read_section(section, measurement.stem);
    read_added_masses(root, measurement.stem, measurement.remarks);
    TomlTable release = root.table("release");
    const std::array<std::string, 2> kinds{"tip_pull", "held_straight"};
    if (const auto index = release.word("kind", kinds))
        measurement.release = *index == 0 ? ReleaseKind::TipPull : ReleaseKind::HeldStraight;
    TomlTable camera = root.table("camera");
    measurement.frames_per_second = camera.number("fps", {0.0, 1e8, true});
    TomlTable measured = root.table("measurement");
    read_measurement_table(measured, measurement);
    for (const TomlTable* table : {&stem, &section, &release, &camera, &measured})
        table->finish(measurement.remarks);
}

Measurement read_stem_file(const std::filesystem::path& file) {
    const toml::table parsed = parse_toml_file(file);
    FileFaults faults(file.string());
    TomlTable root(&parsed, "", faults);
    Measurement measurement;
    read_stem_tables(root, measurement);
    root.finish(measurement.remarks);
    faults.throw_if_any();
    return measurement;
}

std::string stem_file_text(const Measurement& measurement) {
    std::string text = stem_text(measurement.stem);
    text += fmt::format("\n[release]\nkind = \"{}\"\n", to_string(measurement.release));
    if (measurement.frames_per_second)
        text += fmt::format("\n[camera]\nfps = {}\n", decimal_text(*measurement.frames_per_second));
    text += "\n[measurement]\n";
    if (measurement.noise)
        text += line("noise", *measurement.noise);
    if (!measurement.noise_by_height.empty())
        text += noise_line(measurement.noise_by_height);
    if (!measurement.noise_source.empty())
        text += "noise_source = " + quoted(measurement.noise_source) + "\n";
    text += fmt::format("gravity_direction = \"{}\"\nreading = \"{}\"\n",
                        to_string(measurement.gravity_direction), to_string(measurement.reading));
    if (measurement.hold_time)
        text += fmt::format("hold_time_s = {}\n", decimal_text(*measurement.hold_time));
    return text;
}

} // namespace culm::measure
