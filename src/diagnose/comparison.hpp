// SPDX-License-Identifier: BSD-3-Clause
// Compares a fitted chain with its measurement: whether, where, when and how it fails.
#pragma once

#include "diagnose/adequacy.hpp"
#include "fit/fit_model.hpp"
#include "fit/solve/residual_statistics.hpp"
#include "fit/start/residual_spectrum.hpp"
#include "reduce/ring_down/stem_ring_downs.hpp"
#include "residuals/residual_structure.hpp"
#include "residuals/swing.hpp"

#include <string>
#include <vector>

namespace culm::diagnose {

struct Comparison {
    std::string id;            ///< of the measurement
    measure::ReadingUnit unit; ///< of its readings as text
    bool moves = true;         ///< false: nothing in the model moves the stem
    Verdict verdict;           ///< of the judged fit; everything else is of the stated one
    double rmse = 0.0;         ///< m
    double noise = 0.0;        ///< m; the residuals' own where it is not known
    double over_noise = 0.0;   ///< root mean square of residual over noise
    std::vector<fit::ResidualGroup> by_height;
    std::vector<fit::ResidualGroup> by_time;      ///< thirds
    std::vector<fit::ResidualGroup> by_amplitude; ///< thirds, the largest first; empty if unknown
    fit::ResidualSpectrum spectrum;
    residuals::Swing swing;
    std::vector<residuals::SwingWindow> windows;
    residuals::ResidualStructure structure;
    reduce::StemRingDowns measured_ring_downs; ///< Eq. 1 at every height: b1 along the stem
    reduce::StemRingDowns modelled_ring_downs; ///< of the model at the same times and heights
};

/// Both fits are of one model to this one measurement. `stated` has every input as stated and gives
/// the residuals; `judged` has the error terms of the readings and is tested for lack of fit.
[[nodiscard]] Comparison compare(const fit::Fit& stated, const fit::Fit& judged,
                                 const measure::Measurement& measurement,
                                 const Policy& policy = {});

} // namespace culm::diagnose
