// SPDX-License-Identifier: BSD-3-Clause
// Where every fit begins: the published chain of a measured stem.
#pragma once

#include "fit/chain/stem_model.hpp"

namespace culm::fit {

/// The published chain of a measured stem with free Y, β, tip deflection (unless the stem was held
/// straight) and release time. Y and β start from Eq. 1 (with a free phase) through the formulas of
/// a slender beam, the tip deflection from the frames about the release through a cantilever's
/// shape. Throws core::InputError if the stem cannot be a chain, core::NumericalError (FitFailed)
/// if Eq. 1 finds no vibration at any height.
[[nodiscard]] StemModel baseline_model(const measure::Measurement& measurement,
                                       const ChainOptions& options = {});

} // namespace culm::fit
