// SPDX-License-Identifier: BSD-3-Clause
// Converts sampled positions to the histories that a case stores, as its camera sees them.
#pragma once

#include "measure/folder/observation.hpp"
#include "run/case_model.hpp"
#include "run/case_spec.hpp"

namespace culm::run {

/// Fills a CaseResult sample by sample.
class Recorder {
  public:
    explicit Recorder(const CaseSpec& spec);

    /// The first sphere whose positions record() needs; it is the tip if only the tip is stored.
    [[nodiscard]] int first_watched_sphere() const { return first_watched_; }

    /// Samples that record() needs: a rolling shutter reads rows after the last sample's time.
    [[nodiscard]] std::size_t recorded_samples() const { return samples_; }
    [[nodiscard]] double recorded_duration() const {
        return spec_.duration +
               static_cast<double>(samples_ - spec_.sample_count()) * spec_.sample_interval;
    }

    /// Do the case's sensors need the rates of the chain?
    [[nodiscard]] bool needs_rates() const;

    /// Stores sample `index` of the watched spheres up to the tip, with one number for each
    /// dimension of the case.
    void record(std::size_t index, const measure::ChainSample& sample);

    /// Must be called after the last sample.
    void finish();

    [[nodiscard]] CaseResult& result() { return result_; }

  private:
    [[nodiscard]] double camera_scale(double height) const;
    void read_heights(std::size_t index, const measure::ChainSample& sample, double support);
    [[nodiscard]] measure::SensorSurroundings surroundings_at(double time) const;

    const CaseSpec& spec_;
    int dimensions_;
    int first_watched_;
    CaseModel model_;
    std::size_t samples_;
    CaseResult result_;
};

} // namespace culm::run
