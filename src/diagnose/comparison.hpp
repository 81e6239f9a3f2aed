// SPDX-License-Identifier: BSD-3-Clause
// A fitted chain against its measurement: whether, where, when and how it fails.
#pragma once

#include "diagnose/candidate_fit.hpp"
#include "diagnose/mode_shapes.hpp"
#include "diagnose/residual_spectrum.hpp"
#include "diagnose/residual_structure.hpp"
#include "diagnose/residual_table.hpp"
#include "diagnose/swing_windows.hpp"
#include "diagnose/verdict.hpp"
#include "reduce/stem_ring_downs.hpp"

#include <string>
#include <vector>

namespace culm::diagnose {

struct Comparison {
    std::string id;    ///< of the measurement
    bool moves = true; ///< false: nothing in the model moves the stem
    Verdict verdict;
    std::vector<ResidualGroup> by_height;
    std::vector<ResidualGroup> by_time;      ///< thirds
    std::vector<ResidualGroup> by_amplitude; ///< thirds, the largest first; empty if unknown
    ResidualSpectrum spectrum;
    Swing swing;
    std::vector<SwingWindow> windows;
    std::vector<ModeShape> modes;
    ResidualStructure structure;
    reduce::StemRingDowns measured_ring_downs; ///< Eq. 1 at every height: b1 along the stem
    reduce::StemRingDowns modelled_ring_downs; ///< of the model at the same times and heights
};

/// `candidate` must have a fit.
[[nodiscard]] Comparison compare(const CandidateFit& candidate,
                                 const measure::Measurement& measurement);

/// Three sentences for people: does it fit; where and when does it fail most; what does that look
/// like.
[[nodiscard]] std::vector<std::string> in_words(const Comparison& comparison);

} // namespace culm::diagnose
