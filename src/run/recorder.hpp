// SPDX-License-Identifier: BSD-3-Clause
// Turns sampled positions into the histories that a case asked for.
#pragma once

#include "run/case_result.hpp"
#include "run/case_spec.hpp"

#include <span>

namespace culm::run {

/// Fills a CaseResult sample by sample.
class Recorder {
  public:
    explicit Recorder(const CaseSpec& spec);

    /// The first sphere whose positions record() needs: the tip when no more is stored than that.
    [[nodiscard]] int first_watched_sphere() const { return first_watched_; }

    /// Stores sample `index`; `positions` holds the watched spheres up to the tip, spec.dimensions
    /// numbers each.
    void record(std::size_t index, std::span<const double> positions);

    [[nodiscard]] CaseResult& result() { return result_; }

  private:
    const CaseSpec& spec_;
    int first_watched_;
    CaseResult result_;
};

} // namespace culm::run
