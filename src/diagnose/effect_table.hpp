// SPDX-License-Identifier: BSD-3-Clause
// Which models explain which measurements: every cell of the table is one fit.
#pragma once

#include "fit/fit_model.hpp"

#include <map>
#include <string>
#include <vector>

namespace culm::diagnose {

/// A model's fit to a measurement.
struct EffectCell {
    std::string failure; ///< why there is no fit; empty if there is one
    bool applies = true; ///< false: the effects mean nothing for this measurement
    double rmse = 0.0;   ///< m, with every input as stated
    double over_noise = 0.0;
    double reduced_chi_squared = 0.0;             ///< with the error terms of the readings
    std::vector<fit::FittedParameter> parameters; ///< the effects' only
    bool is_at_bound = false;                     ///< one of them
    int runs = 0;
};

template <class Wire>
void fields(Wire& wire, EffectCell& cell) {
    wire(cell.failure, cell.applies, cell.rmse, cell.over_noise, cell.reduced_chi_squared,
         cell.parameters, cell.is_at_bound, cell.runs);
}

/// Computes cells; caches the baseline fit of every measurement.
class EffectTable {
  public:
    explicit EffectTable(const std::vector<measure::Measurement>& measurements,
                         fit::FitOptions options = {})
        : measurements_(measurements), options_(std::move(options)) {}

    /// The cell of measurement number `measurement`; no effects: the baseline.
    [[nodiscard]] EffectCell cell(std::size_t measurement, const fit::SelectedEffects& effects,
                                  const run::Heartbeat& heartbeat = {});

  private:
    const std::vector<measure::Measurement>& measurements_;
    fit::FitOptions options_;
    std::map<std::size_t, fit::BaselineFit> baselines_;
};

} // namespace culm::diagnose
