// SPDX-License-Identifier: BSD-3-Clause
#include "measure/folder/measurement.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace culm::measure {

namespace {

double inner_diameter(const CircularSection& circle) {
    return circle.wall ? circle.diameter - 2.0 * *circle.wall : 0.0;
}

} // namespace

// Area and second moment for bending: ring π/4 (D² − d²) and π/64 (D⁴ − d⁴), rectangle b h and
// b h³/12.
double section_area(const Section& section) {
    if (const auto* circle = std::get_if<CircularSection>(&section)) {
        const double inner = inner_diameter(*circle);
        return std::numbers::pi / 4.0 * (circle->diameter * circle->diameter - inner * inner);
    }
    if (const auto* rectangle = std::get_if<RectangularSection>(&section))
        return rectangle->width * rectangle->height;
    return std::get<GeneralSection>(section).area;
}

double second_moment_of_area(const Section& section) {
    if (const auto* circle = std::get_if<CircularSection>(&section))
        return std::numbers::pi / 64.0 *
               (std::pow(circle->diameter, 4) - std::pow(inner_diameter(*circle), 4));
    if (const auto* rectangle = std::get_if<RectangularSection>(&section))
        return rectangle->width * std::pow(rectangle->height, 3) / 12.0;
    return std::get<GeneralSection>(section).second_moment;
}

double section_depth(const Section& section) {
    if (const auto* circle = std::get_if<CircularSection>(&section))
        return circle->diameter;
    if (const auto* rectangle = std::get_if<RectangularSection>(&section))
        return rectangle->height;
    // The height of the rectangle with this radius of gyration: I/A = h²/12.
    const auto& general = std::get<GeneralSection>(section);
    return std::sqrt(12.0 * general.second_moment / general.area);
}

double mass_per_length(const MeasuredStem& stem) {
    if (const auto* circle = std::get_if<CircularSection>(&stem.section))
        // One sphere, π d³/6, per length d.
        return stem.density * std::numbers::pi / 6.0 * circle->diameter * circle->diameter;
    return stem.density * section_area(stem.section);
}

std::vector<double> Measurement::history(std::size_t height) const {
    std::vector<double> values;
    values.reserve(times.size());
    for (std::size_t i = 0; i < times.size(); ++i)
        values.push_back(deflection(i, height));
    return values;
}

double Measurement::rms_reading(std::size_t height) const {
    double squares = 0.0;
    double count = 0.0;
    for (std::size_t i = 0; i < times.size(); ++i)
        if (const double value = deflection(i, height); !std::isnan(value)) {
            squares += value * value;
            count += 1.0;
        }
    return std::sqrt(squares / std::max(count, 1.0));
}

std::optional<double> Measurement::noise_at(std::size_t height) const {
    if (height < noise_by_height.size())
        return noise_by_height[height];
    return noise;
}

std::string_view to_string(ReleaseKind kind) {
    switch (kind) {
    case ReleaseKind::TipPull:
        return "tip_pull";
    case ReleaseKind::HeldStraight:
        return "held_straight";
    case ReleaseKind::Moving:
        break;
    }
    return "moving";
}

std::string_view to_string(GravityDirection direction) {
    switch (direction) {
    case GravityDirection::None:
        return "none";
    case GravityDirection::Axial:
        return "axial";
    case GravityDirection::Transverse:
        break;
    }
    return "transverse";
}

std::string_view to_string(Reading reading) {
    return reading == Reading::Row ? "row" : "material";
}

} // namespace culm::measure
