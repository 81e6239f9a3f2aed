// SPDX-License-Identifier: BSD-3-Clause
// The measured quantities that a model takes as numbers, and what their errors do to the readings.
//
// A term is u ∂(predicted − measured)/∂input: Y and β stay. The first mode of the chain moves with
// the length by two per cent of the phase of a swing of ten cycles per standard uncertainty, but
// the readings determine its frequency, so in a solution Y compensates and the sum is small.
#pragma once

#include "fit/solve/fit_result.hpp"

#include <functional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace culm::fit {

/// The object that a stated input changes.
enum class InputActs {
    OnChain,   ///< the chain or what is on it, by StatedInput::access
    OnRows,    ///< the heights of all rows alike
    OnPicture, ///< heights and deflections by the same share
    OnSensor,  ///< the readings of one sensor by a share
    OnClock
};

/// A measured quantity that the model takes as a number. SI units.
struct StatedInput {
    InputActs acts = InputActs::OnChain;
    /// The number in the stem, and its error in a fitted case; of one that acts on the chain.
    std::function<double&(measure::MeasuredStem&)> number;
    run::CaseParameter access;
    std::string name; ///< "length", "mass at 156 mm"
    std::string unit; ///< "m"; empty: a share
    double value = 0.0;
    double standard_uncertainty = 0.0; ///< one standard deviation (JCGM 100)
    bool is_default = false;           ///< the file states none
    bool is_of_rig = false;            ///< recordings on one rig share it; else those of a specimen
    std::size_t row = 0;               ///< of one that acts on a sensor
};

/// Length, section, density, added masses, scale and clamp height of the picture, frame rate. The
/// defaults of the uncertainties are: length 0.3 mm, clamp height 0.2 mm, scale 0.5 %, every other
/// quantity 1 % (docs/uncertainty.md); a frame rate is exact. Inputs of uncertainty 0 are omitted.
[[nodiscard]] std::vector<StatedInput> stated_inputs(const measure::Measurement& measurement);

/// Gives the case the geometry and the added masses of a stem. Y and β stay.
void set_stem(const measure::MeasuredStem& stem, run::CaseSpec& spec);

/// The stem and the heights that would have been stated if the inputs had these `errors`, in
/// standard uncertainties.
[[nodiscard]] std::pair<measure::MeasuredStem, std::vector<double>>
restated(const measure::Measurement& measurement, const std::vector<StatedInput>& inputs,
         std::span<const double> errors);

/// The terms of the inputs at the times of a fit, in their order. Recordings of one rig, or of one
/// specimen with the same stated value, share a term. Adds the lanes that were run to `batches`.
/// Throws core::NumericalError if the chain cannot be computed with an input changed a little.
[[nodiscard]] std::vector<ErrorTerm> input_terms(const RecordingFit& fit,
                                                 const measure::Measurement& measurement,
                                                 const run::Heartbeat& heartbeat, int& batches);

} // namespace culm::fit
