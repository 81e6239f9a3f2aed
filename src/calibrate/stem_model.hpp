// SPDX-License-Identifier: BSD-3-Clause
// A candidate model of a measured stem: a case, and which of its numbers may be fitted.
#pragma once

#include "calibrate/free_parameter.hpp"
#include "calibrate/stem_chain.hpp"

#include <string>
#include <vector>

namespace culm::calibrate {

/// Whatever physics the case contains, the fit only knows its free parameters. The moment of the
/// release is known to about a frame, so it is one of them: the case runs from release_time on and
/// is held before.
struct StemModel {
    run::CaseSpec spec;                    ///< with the values from which a fit starts
    std::vector<FreeParameter> parameters; ///< of the case, in the order of all results
    double release_time = 0.0;             ///< on the measurement's clock, s
    double release_time_bound = 0.0;       ///< |release_time| stays within; 0: it is not free
    std::vector<std::string> remarks;      ///< what the model leaves out, one sentence each

    /// Names of what is fitted: the parameters', then "release_time" if that is free.
    [[nodiscard]] std::vector<std::string> free_names() const;
    [[nodiscard]] std::size_t free_count() const {
        return parameters.size() + (release_time_bound > 0.0 ? 1 : 0);
    }
};

inline constexpr const char* release_time_name = "release_time";

/// The published chain of a measured stem with Y, β, tip deflection (of one that was held straight:
/// not) and release time free. Start
/// values: Y and β from Eq. 1 (with a free phase) through the formulas of a slender beam, the tip
/// deflection from the frames about the release through a cantilever's shape. Throws
/// core::InputError if the stem cannot be a chain, core::NumericalError (FitFailed) if Eq. 1 finds
/// no vibration at any height.
[[nodiscard]] StemModel baseline_model(const measure::Measurement& measurement,
                                       const ChainOptions& options = {});

} // namespace culm::calibrate
