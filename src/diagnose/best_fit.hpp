// SPDX-License-Identifier: BSD-3-Clause
// Fits of one model to some recordings from several starts, of which the best is kept.
#pragma once

#include "calibrate/joint_fit.hpp"
#include "diagnose/candidate_fit.hpp"

#include <optional>
#include <span>
#include <string>
#include <vector>

namespace culm::diagnose {

/// One model for each recording.
using JointStart = std::vector<calibrate::StemModel>;

/// Where some iterations from a start have led.
struct BegunFit {
    JointStart models;
    double weighted_rms = 0.0; ///< as JointFit's
    double chi_squared = 0.0;
};

class BestFit {
  public:
    /// All must outlive this; `weights` as calibrate::JointOptions'.
    BestFit(std::span<const measure::Measurement> recordings, const CandidateOptions& options,
            std::vector<std::vector<double>> weights = {});

    /// Goes all the way from a start.
    void try_start(const JointStart& start, bool is_first_guess);

    /// Some iterations from a start, with its places (angles, time scales) held. Throws
    /// core::NumericalError if they lead nowhere.
    [[nodiscard]] BegunFit begin(const JointStart& start, bool is_first_guess);

    /// Goes all the way from the best of those begun, and from the next if it was better then than
    /// that one is in the end.
    void go_on(std::vector<BegunFit> begun);

    /// Begins from all of them and goes on; with a single one, all the way from there.
    void try_starts(const std::vector<JointStart>& starts, bool is_first_guess);

    /// The same for a model that is larger than that of `smaller` (a part for each recording) and,
    /// if `is_nested`, contains it; `begun` from `starts`, empty: not yet. If it then fits worse
    /// the solution has missed a cycle, and growing windows are tried; what stays worse is a
    /// failure and no result.
    void try_larger(const std::vector<JointStart>& starts,
                    std::optional<std::vector<BegunFit>> begun,
                    std::span<const calibrate::ChainFit> smaller, bool is_nested);

    [[nodiscard]] std::optional<calibrate::JointFit> take() { return std::move(best_); }
    [[nodiscard]] const std::string& failure() const { return failure_; } ///< of the last that did
    [[nodiscard]] int starts() const { return starts_; }
    [[nodiscard]] int runs() const { return runs_; } ///< of chains with all their derivatives

  private:
    /// By the weights of the best.
    [[nodiscard]] bool is_as_good_as(std::span<const calibrate::ChainFit> smaller) const;
    [[nodiscard]] calibrate::JointFit solved(const JointStart& start,
                                             const calibrate::JointOptions& options);
    [[nodiscard]] calibrate::JointOptions joint_options(bool is_first_guess) const;
    [[nodiscard]] std::vector<bool> places(const JointStart& start) const;
    [[nodiscard]] calibrate::JointFit settled(calibrate::JointFit fit);

    std::span<const measure::Measurement> recordings_;
    const CandidateOptions& options_;
    std::vector<std::vector<double>> weights_;
    std::optional<calibrate::JointFit> best_;
    std::string failure_;
    int starts_ = 0;
    int runs_ = 0;
};

/// The models of a fit's parts.
[[nodiscard]] JointStart start_from(const calibrate::JointFit& fit);

} // namespace culm::diagnose
