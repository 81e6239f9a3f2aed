// SPDX-License-Identifier: BSD-3-Clause
#include "fit/errors/stated_inputs.hpp"

#include "fit/chain/stem_chain.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <optional>
#include <utility>
#include <variant>

#include <fmt/core.h>

namespace culm::fit {
namespace {

// Default uncertainties, those of a careful laboratory (docs/uncertainty.md).
constexpr double default_length = 0.3e-3; // m, a steel ruler and the edge of the clamp
constexpr double default_clamp = 0.2e-3;  // m, of its height in the picture
constexpr double default_scale = 0.005;   // of a length in the picture
constexpr double default_place = 0.5e-3;  // m, of a sensor
constexpr double default_share = 0.01;    // of a diameter, a density, a mass

using Member = std::function<double&(measure::MeasuredStem&)>;

/// The default uncertainty is `otherwise`, or default_share of the value.
StatedInput input(std::string name, std::string unit, double value, std::optional<double> stated,
                  std::optional<double> otherwise = std::nullopt) {
    StatedInput out;
    out.name = std::move(name);
    out.unit = std::move(unit);
    out.value = value;
    out.standard_uncertainty = stated.value_or(otherwise.value_or(default_share * value));
    out.is_default = !stated.has_value();
    return out;
}

/// An input that is a property of the stem, as the error of the stated number. A change divides the
/// chain of the changed stem again.
StatedInput stem_input(const measure::MeasuredStem& stem, std::string name, std::string unit,
                       Member member, std::optional<double> stated,
                       std::optional<double> otherwise = std::nullopt) {
    measure::MeasuredStem copy = stem;
    StatedInput out = input(std::move(name), std::move(unit), member(copy), stated, otherwise);
    out.number = std::move(member);
    out.access = {{{}, out.name, {}},
                  [](const run::CaseSpec&) { return 0.0; },
                  [stem, number = out.number](run::CaseSpec& spec, double error) {
                      measure::MeasuredStem changed = stem;
                      number(changed) += error;
                      set_stem(changed, spec);
                  },
                  std::abs(out.value)};
    return out;
}

/// A number of a section of this shape.
template <class Shape>
Member of_section(double Shape::*number) {
    return [number](measure::MeasuredStem& stem) -> double& {
        return std::get<Shape>(stem.section).*number;
    };
}

std::vector<StatedInput> section_inputs(const measure::MeasuredStem& stem,
                                        const measure::StatedUncertainties& stated) {
    using measure::CircularSection;
    using measure::GeneralSection;
    using measure::RectangularSection;
    if (std::holds_alternative<RectangularSection>(stem.section))
        return {stem_input(stem, "section width", "m", of_section(&RectangularSection::width),
                           stated.section_width),
                stem_input(stem, "section height", "m", of_section(&RectangularSection::height),
                           stated.section_height)};
    if (std::holds_alternative<GeneralSection>(stem.section))
        return {stem_input(stem, "section area", "m²", of_section(&GeneralSection::area),
                           stated.section_area),
                stem_input(stem, "second moment of area", "m⁴",
                           of_section(&GeneralSection::second_moment), stated.second_moment)};
    std::vector<StatedInput> inputs{
        stem_input(stem, "diameter", "m", of_section(&CircularSection::diameter), stated.diameter)};
    if (std::get<CircularSection>(stem.section).wall)
        inputs.push_back(stem_input(
            stem, "wall", "m",
            [](measure::MeasuredStem& its) -> double& {
                return *std::get<CircularSection>(its.section).wall;
            },
            stated.wall));
    return inputs;
}

void add_stem(const measure::Measurement& measurement, std::vector<StatedInput>& inputs) {
    const measure::MeasuredStem& stem = measurement.stem;
    const measure::StatedUncertainties& stated = measurement.uncertainties;
    inputs.push_back(stem_input(stem, "length", "m", &measure::MeasuredStem::length, stated.length,
                                default_length));
    std::ranges::move(section_inputs(stem, stated), std::back_inserter(inputs));
    inputs.push_back(
        stem_input(stem, "density", "kg/m³", &measure::MeasuredStem::density, stated.density));
    for (std::size_t k = 0; k < stem.added_masses.size(); ++k) {
        const measure::AddedMass& added = stem.added_masses[k];
        // A balance resolves half a digit at best, and a mass of many digits was computed.
        inputs.push_back(stem_input(
            stem, fmt::format("mass at {:.6g} mm", 1e3 * added.height), "kg",
            [k](measure::MeasuredStem& its) -> double& { return its.added_masses[k].mass; },
            added.mass_uncertainty,
            std::max(default_share * added.mass, 0.5 * added.mass_last_digit)));
    }
}

void add_of_rig(StatedInput input, InputActs acts, std::vector<StatedInput>& inputs) {
    input.acts = acts;
    input.is_of_rig = true;
    inputs.push_back(std::move(input));
}

/// The sensors were at other heights than stated, and each of them has its own scale.
void add_sensors(const measure::Measurement& measurement, std::vector<StatedInput>& inputs) {
    for (std::size_t j = 0; j < measurement.sensors.size(); ++j) {
        const measure::Sensor& sensor = measurement.sensors[j];
        if (sensor.is_camera())
            continue;
        StatedInput scale =
            input("scale of " + sensor.column, "", 0.0, sensor.scale_uncertainty, default_share);
        scale.row = j;
        add_of_rig(std::move(scale), InputActs::OnSensor, inputs);
    }
    add_of_rig(
        input("position of the sensors", "m", 0.0, measurement.uncertainties.clamp, default_place),
        InputActs::OnRows, inputs);
    add_of_rig(input("frame rate", "", 0.0, measurement.uncertainties.frames_per_second, 0.0),
               InputActs::OnClock, inputs);
}

/// Scale and clamp: the rows were at other heights of the stem than stated.
void add_picture(const measure::Measurement& measurement, std::vector<StatedInput>& inputs) {
    const measure::StatedUncertainties& stated = measurement.uncertainties;
    for (auto& [acts, added] :
         {std::pair(InputActs::OnPicture, input("scale", "", 0.0, stated.scale, default_scale)),
          std::pair(InputActs::OnRows,
                    input("clamp height", "m", 0.0, stated.clamp, default_clamp)),
          std::pair(InputActs::OnClock,
                    input("frame rate", "", 0.0, stated.frames_per_second, 0.0))})
        add_of_rig(added, acts, inputs);
}

/// Recordings whose inputs have the same name share their term.
std::string term_name(const StatedInput& input, const measure::Measurement& measurement) {
    const std::string& specimen = measurement.specimen_name();
    // Each specimen is clamped anew, at another height of the picture.
    if (input.is_of_rig && input.acts == InputActs::OnRows && !measurement.rig.empty())
        return fmt::format("{} of {} on rig {}", input.name, specimen, measurement.rig);
    if (input.is_of_rig)
        return fmt::format("{} of {}", input.name,
                           measurement.rig.empty() ? measurement.stem.id
                                                   : "rig " + measurement.rig);
    // A specimen that is clamped again has a new length, which was measured again.
    return fmt::format("{} ({:.6g} {}) of {}", input.name, input.value, input.unit, specimen);
}

/// Distance over which a slope along the stem is taken, bond lengths.
constexpr double slope_distance = 0.01;

/// Derivatives of the predicted readings at the times of a fit.
class InputChanges {
  public:
    InputChanges(const RecordingFit& fit, const measure::Measurement& measurement,
                 const std::vector<StatedInput>& inputs, const run::Heartbeat& heartbeat)
        : fit_(fit), measurement_(measurement),
          distance_(slope_distance * fit.model.spec.stem.bond_length) {
        StemModel model = fixed_model(fit.model);
        for (const StatedInput& input : inputs) {
            columns_.push_back(model.parameters.size());
            if (input.acts == InputActs::OnChain)
                model.parameters.emplace_back().access = input.access;
        }
        add_rows(-distance_, model.spec);
        add_rows(distance_, model.spec);
        changed_ = predict_readings(model, fit.times, heartbeat);
    }

    [[nodiscard]] int batches() const { return changed_.batches; }

    /// Change of predicted − measured by one standard uncertainty of input `k`.
    [[nodiscard]] std::vector<double> by(const StatedInput& input, std::size_t k) const {
        std::vector<double> out;
        out.reserve(fit_.prediction.readings.size());
        for (std::size_t at = 0; at < fit_.prediction.readings.size(); ++at)
            out.push_back(derivative(at, input, k) * input.standard_uncertainty);
        return out;
    }

  private:
    static double finite(double value) { return std::isfinite(value) ? value : 0.0; }

    /// The same rows again, shifted along the stem.
    void add_rows(double shift, run::CaseSpec& spec) const {
        for (std::size_t j = 0; j < measurement_.heights.size(); ++j)
            spec.heights.push_back(spec.heights[j] + shift);
        for (std::size_t j = 0; j < measurement_.sensors.size(); ++j)
            spec.sensors.push_back(spec.sensors[j]);
    }

    /// Index of a reading in the run; `copy`: 0, or 1 and 2 for the rows below and above.
    [[nodiscard]] std::size_t place_of(std::size_t at, std::size_t copy) const {
        const std::size_t rows = fit_.prediction.rows;
        return at / rows * changed_.rows + copy * rows + at % rows;
    }

    [[nodiscard]] double by_chain(std::size_t at, std::size_t column) const {
        return finite(changed_.jacobian[place_of(at, 0) * changed_.parameters + column]);
    }

    /// Derivative by the height of the row. A row at an end of the stem has one neighbour.
    [[nodiscard]] double by_height(std::size_t at) const {
        const double here = changed_.readings[place_of(at, 0)];
        const double below = changed_.readings[place_of(at, 1)];
        const double above = changed_.readings[place_of(at, 2)];
        const double down = std::isfinite(below) ? here - below : above - here;
        const double up = std::isfinite(above) ? above - here : down;
        return finite(0.5 * (down + up) / distance_);
    }

    [[nodiscard]] double derivative(std::size_t at, const StatedInput& input, std::size_t k) const {
        const ChainPrediction& own = fit_.prediction;
        const std::size_t row = at % own.rows;
        switch (input.acts) {
        case InputActs::OnChain:
            return by_chain(at, columns_[k]);
        case InputActs::OnRows:
            return by_height(at);
        case InputActs::OnPicture:
            return measurement_.heights[row] * by_height(at) - finite(own.readings[at]);
        case InputActs::OnSensor:
            return row == input.row ? -finite(own.readings[at]) : 0.0;
        case InputActs::OnClock:
            // If the rate is larger by the share c, the reading was taken at t/(1 + c), where the
            // prediction is smaller by c t dy/dt. The release time's derivative is −dy/dt.
            return fit_.model.release_time_bound > 0.0
                       ? fit_.times[at / own.rows] *
                             finite(
                                 own.jacobian[at * own.parameters + fit_.model.first_error() - 1])
                       : 0.0;
        }
        return 0.0;
    }

    const RecordingFit& fit_;
    const measure::Measurement& measurement_;
    double distance_;                  ///< of the added rows, m
    ChainPrediction changed_;          ///< by the inputs that change the chain, with added rows
    std::vector<std::size_t> columns_; ///< (inputs) their columns in changed_
};

} // namespace

void set_stem(const measure::MeasuredStem& stem, run::CaseSpec& spec) {
    set_geometry(stem, spec.stem.sphere_count, spec.stem);
    for (std::size_t k = 0; k < stem.added_masses.size(); ++k)
        spec.added_masses[k].mass = stem.added_masses[k].mass;
}

std::pair<measure::MeasuredStem, std::vector<double>>
restated(const measure::Measurement& measurement, const std::vector<StatedInput>& inputs,
         std::span<const double> errors) {
    measure::MeasuredStem stem = measurement.stem;
    std::vector<double> heights = measurement.heights;
    for (std::size_t k = 0; k < inputs.size(); ++k) {
        const double change = errors[k] * inputs[k].standard_uncertainty;
        if (inputs[k].acts == InputActs::OnChain)
            inputs[k].number(stem) += change;
        for (std::size_t j = 0; j < heights.size(); ++j)
            if (inputs[k].acts == InputActs::OnRows)
                heights[j] += change;
            else if (inputs[k].acts == InputActs::OnPicture)
                heights[j] += change * measurement.heights[j];
    }
    return {std::move(stem), std::move(heights)};
}

std::vector<StatedInput> stated_inputs(const measure::Measurement& measurement) {
    std::vector<StatedInput> inputs;
    add_stem(measurement, inputs);
    if (measurement.sensors.empty())
        add_picture(measurement, inputs);
    else
        add_sensors(measurement, inputs);
    std::erase_if(inputs, [](const StatedInput& each) { return each.standard_uncertainty == 0.0; });
    return inputs;
}

std::vector<ErrorTerm> input_terms(const RecordingFit& fit, const measure::Measurement& measurement,
                                   const run::Heartbeat& heartbeat, int& batches) {
    const std::vector<StatedInput> inputs = stated_inputs(measurement);
    const InputChanges changes(fit, measurement, inputs, heartbeat);
    batches += changes.batches();
    std::vector<ErrorTerm> terms;
    for (std::size_t k = 0; k < inputs.size(); ++k)
        terms.push_back(
            {ErrorKind::StatedInput, term_name(inputs[k], measurement), changes.by(inputs[k], k)});
    return terms;
}

} // namespace culm::fit
