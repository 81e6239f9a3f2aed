// SPDX-License-Identifier: BSD-3-Clause
#include "fit/model/stem_chain.hpp"
#include "fit/solve/uncertainty_budget.hpp"

#include <functional>
#include <optional>
#include <utility>
#include <variant>

#include <fmt/core.h>

namespace culm::fit {
namespace {

// Of a careful laboratory that states nothing (docs/uncertainty.md).
constexpr double default_length = 0.3e-3; // m, a steel ruler and where the clamp begins
constexpr double default_clamp = 0.2e-3;  // m, of its height in the picture
constexpr double default_scale = 0.005;   // of a length in the picture
constexpr double default_share = 0.01;    // of a diameter, a density, a mass

using Get = std::function<double(const run::CaseSpec&)>;

StatedInput input(std::string name, std::string unit, double value, std::optional<double> stated,
                  double otherwise) {
    StatedInput out;
    out.name = std::move(name);
    out.unit = std::move(unit);
    out.value = value;
    out.standard_uncertainty = stated.value_or(otherwise);
    out.is_default = !stated.has_value();
    return out;
}

double mass_per_length_of(const run::CaseSpec& spec) {
    return spec.stem.sphere_mass() / spec.stem.bond_length;
}

/// A number of the stem: the chain is divided anew from the stem that has it.
StatedInput of_stem(StatedInput input, const measure::MeasuredStem& stated,
                    std::function<void(measure::MeasuredStem&, double)> change, Get get) {
    input.access.id = {{}, input.name, {}};
    input.access.get = std::move(get);
    input.access.set = [stated, change = std::move(change)](run::CaseSpec& spec, double value) {
        measure::MeasuredStem stem = stated;
        change(stem, value);
        set_geometry(stem, spec.stem.sphere_count, spec.stem);
    };
    return input;
}

void add_circle(const measure::CircularSection& circle, const measure::Measurement& measurement,
                std::vector<StatedInput>& inputs) {
    const measure::MeasuredStem& stem = measurement.stem;
    inputs.push_back(of_stem(
        input("diameter", "m", circle.diameter, measurement.uncertainties.diameter,
              default_share * circle.diameter),
        stem,
        [](measure::MeasuredStem& changed, double value) {
            std::get<measure::CircularSection>(changed.section).diameter = value;
        },
        [](const run::CaseSpec& spec) { return spec.stem.bond_outer_diameter; }));
    if (!circle.wall)
        return;
    inputs.push_back(of_stem(
        input("wall", "m", *circle.wall, measurement.uncertainties.wall,
              default_share * *circle.wall),
        stem,
        [](measure::MeasuredStem& changed, double value) {
            std::get<measure::CircularSection>(changed.section).wall = value;
        },
        [](const run::CaseSpec& spec) {
            return 0.5 * (spec.stem.bond_outer_diameter - spec.stem.bond_inner_diameter);
        }));
}

/// Both sides of a rectangle are in the mass per length m' = ρ b h.
void add_rectangle(const measure::RectangularSection& rectangle,
                   const measure::Measurement& measurement, std::vector<StatedInput>& inputs) {
    const measure::MeasuredStem& stem = measurement.stem;
    const auto side = [&](const char* name, double measure::RectangularSection::*member,
                          std::optional<double> stated) {
        const double value = rectangle.*member;
        const double mass_per_side = measure::mass_per_length(stem) / value;
        inputs.push_back(of_stem(
            input(name, "m", value, stated, default_share * value), stem,
            [member](measure::MeasuredStem& changed, double to) {
                std::get<measure::RectangularSection>(changed.section).*member = to;
            },
            [mass_per_side](const run::CaseSpec& spec) {
                return mass_per_length_of(spec) / mass_per_side;
            }));
    };
    side("section width", &measure::RectangularSection::width,
         measurement.uncertainties.section_width);
    side("section height", &measure::RectangularSection::height,
         measurement.uncertainties.section_height);
}

void add_general(const measure::GeneralSection& general, const measure::Measurement& measurement,
                 std::vector<StatedInput>& inputs) {
    const measure::MeasuredStem& stem = measurement.stem;
    const double density = stem.density;
    inputs.push_back(of_stem(
        input("section area", "m²", general.area, measurement.uncertainties.section_area,
              default_share * general.area),
        stem,
        [](measure::MeasuredStem& changed, double value) {
            std::get<measure::GeneralSection>(changed.section).area = value;
        },
        [density](const run::CaseSpec& spec) { return mass_per_length_of(spec) / density; }));
    inputs.push_back(of_stem(
        input("second moment of area", "m⁴", general.second_moment,
              measurement.uncertainties.second_moment, default_share * general.second_moment),
        stem,
        [](measure::MeasuredStem& changed, double value) {
            std::get<measure::GeneralSection>(changed.section).second_moment = value;
        },
        [](const run::CaseSpec& spec) { return spec.stem.second_moment_of_area(); }));
}

void add_stem(const measure::Measurement& measurement, std::vector<StatedInput>& inputs) {
    const measure::MeasuredStem& stem = measurement.stem;
    inputs.push_back(of_stem(
        input("length", "m", stem.length, measurement.uncertainties.length, default_length), stem,
        [](measure::MeasuredStem& changed, double value) { changed.length = value; },
        [](const run::CaseSpec& spec) { return spec.stem.free_length(); }));
    if (const auto* circle = std::get_if<measure::CircularSection>(&stem.section))
        add_circle(*circle, measurement, inputs);
    else if (const auto* rectangle = std::get_if<measure::RectangularSection>(&stem.section))
        add_rectangle(*rectangle, measurement, inputs);
    else
        add_general(std::get<measure::GeneralSection>(stem.section), measurement, inputs);
    const double volume_per_length = measure::mass_per_length(stem) / stem.density;
    inputs.push_back(of_stem(
        input("density", "kg/m³", stem.density, measurement.uncertainties.density,
              default_share * stem.density),
        stem, [](measure::MeasuredStem& changed, double value) { changed.density = value; },
        [volume_per_length](const run::CaseSpec& spec) {
            return mass_per_length_of(spec) / volume_per_length;
        }));
    for (std::size_t k = 0; k < stem.added_masses.size(); ++k) {
        const measure::AddedMass& added = stem.added_masses[k];
        StatedInput mass = input(fmt::format("mass at {:.6g} mm", 1e3 * added.height), "kg",
                                 added.mass, added.mass_uncertainty, default_share * added.mass);
        mass.access = {{{}, mass.name, {}},
                       [k](const run::CaseSpec& spec) { return spec.added_masses[k].mass; },
                       [k](run::CaseSpec& spec, double to) { spec.added_masses[k].mass = to; },
                       0.0};
        inputs.push_back(std::move(mass));
    }
}

/// Scale and clamp: the rows were elsewhere on the stem than the file says.
void add_picture(const measure::Measurement& measurement, std::vector<StatedInput>& inputs) {
    const std::vector<double> stated = measurement.heights;
    const auto moved = [stated](auto move) {
        return [stated, move](run::CaseSpec& spec, double value) {
            for (std::size_t j = 0; j < stated.size(); ++j)
                spec.heights[j] = move(stated[j], value);
        };
    };
    StatedInput scale = input("scale", "", 0.0, measurement.uncertainties.scale, default_scale);
    scale.scales_readings = true;
    scale.access = {{{}, "scale", {}},
                    [top = stated.back()](const run::CaseSpec& spec) {
                        return spec.heights.back() / top - 1.0;
                    },
                    moved([](double height, double share) { return height * (1.0 + share); }),
                    1.0};
    StatedInput clamp =
        input("clamp height", "m", 0.0, measurement.uncertainties.clamp, default_clamp);
    clamp.access = {
        {{}, "clamp height", {}},
        [top = stated.back()](const run::CaseSpec& spec) { return spec.heights.back() - top; },
        moved([](double height, double shift) { return height + shift; }),
        measurement.stem.length};
    inputs.push_back(std::move(scale));
    inputs.push_back(std::move(clamp));
    StatedInput rate =
        input("frame rate", "", 0.0, measurement.uncertainties.frames_per_second, 0.0);
    rate.scales_times = true;
    inputs.push_back(std::move(rate));
}

} // namespace

std::vector<StatedInput> stated_inputs(const measure::Measurement& measurement) {
    std::vector<StatedInput> inputs;
    add_stem(measurement, inputs);
    add_picture(measurement, inputs);
    std::erase_if(inputs, [](const StatedInput& each) { return each.standard_uncertainty == 0.0; });
    return inputs;
}

} // namespace culm::fit
