// SPDX-License-Identifier: BSD-3-Clause
// How one model is fitted to one or several recordings: first a few steps from each of its starts.
#pragma once

#include "diagnose/best_fit.hpp"
#include "diagnose/joint_starts.hpp"
#include "diagnose/model_fit.hpp"

#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace culm::diagnose {

/// begin() for every start, then finish(), is what fit_model() does; apart, they can be spread over
/// ranks.
class FitPlan {
  public:
    /// `smaller`: a fit with some or none of the effects; empty only for the chain itself. It and
    /// the recordings must outlive this.
    FitPlan(const SelectedEffects& effects, const ModelFit& smaller,
            std::span<const measure::Measurement> recordings, const CandidateOptions& options);

    /// Starts to begin from; 0 where there is nothing to choose between.
    [[nodiscard]] std::size_t start_count() const {
        return starts_.size() > 1 ? starts_.size() : 0;
    }
    /// Where some steps from start `k` lead, as text that keeps every bit; empty if nowhere.
    [[nodiscard]] std::string begin(std::size_t k, const CandidateOptions& options) const;
    /// χ² that begin() told of; infinite if the start led nowhere.
    [[nodiscard]] static double chi_squared_of(const std::string& begun);
    /// `begun`: what begin() told of each start. As fit_model().
    [[nodiscard]] ModelFit finish(const std::vector<std::string>& begun,
                                  const CandidateOptions& options) const;

  private:
    [[nodiscard]] ModelFit fitted(const std::vector<std::string>& begun,
                                  const CandidateOptions& options) const;
    [[nodiscard]] bool moves() const;
    [[nodiscard]] bool moves_more() const;
    [[nodiscard]] std::vector<JointStart> larger_starts() const;
    [[nodiscard]] ModelFit fit_alone(std::size_t recording, const CandidateOptions& options) const;
    [[nodiscard]] ModelFit fit_from_own(const CandidateOptions& options) const;
    [[nodiscard]] ModelFit fit_from_starts(const std::vector<std::string>& begun,
                                           const CandidateOptions& options) const;

    std::string failure_; ///< why there is no plan
    SelectedEffects effects_;
    const ModelFit& smaller_;
    std::span<const measure::Measurement> recordings_;
    JointStart models_;
    std::vector<RecordedSwing> swings_; ///< of several recordings
    std::vector<JointStart> starts_;    ///< from `smaller`, if it has a fit and moves as much
};

/// A fit of these effects that begins near its end: with the values of `start`, from which it goes
/// all the way. The rest as fit_model().
[[nodiscard]] ModelFit refined(const JointStart& start, const SelectedEffects& effects,
                               const ModelFit& smaller,
                               std::span<const measure::Measurement> recordings,
                               const CandidateOptions& options);

} // namespace culm::diagnose
