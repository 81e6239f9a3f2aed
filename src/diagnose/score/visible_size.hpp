// SPDX-License-Identifier: BSD-3-Clause
// How large an effect must be to be seen, and what it does to the other numbers meanwhile.
#pragma once

#include "diagnose/score/score_test.hpp"
#include "diagnose/score/stacked_readings.hpp"

#include <limits>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace culm::diagnose {

/// The free parameter that a column of readings belongs to; null if it is no effect's or stem's.
[[nodiscard]] const fit::FreeParameter* parameter_of(const fit::StemModel& model,
                                                     const physics::ParameterId& column);

/// Part of a derivative that nothing imitates; less is rounding and the runs' own noise.
constexpr double least_standing_out = 1e-4;

class VisibleSize {
  public:
    /// All must outlive this; `fitted` of `base`. Writes into `score`, whose effect is named.
    VisibleSize(const fit::Fit& base, const StackedReadings& fitted,
                std::span<const fit::ObservedRecording> recordings, const fit::FitOptions& options,
                EffectScore& score)
        : base_(base), fitted_(fitted), recordings_(recordings), options_(options), score_(score) {}

    /// The size at which the first of the effect's sizes is seen, if its first order tells; the
    /// smallest of several calls. `start`: where the effect is absent, `stacked` its readings.
    void judge(const StackedReadings& stacked, const fit::StartModels& start);

    [[nodiscard]] bool is_known() const { return size_ < std::numeric_limits<double>::infinity(); }

    /// Runs of the size at which the effect should be seen: its trace need not grow in proportion,
    /// as that of two planes of bending, which grows with the square. Where the first order tells
    /// nothing, from `default_start` on, which else may be empty.
    void settle(const fit::StartModels& default_start);

    /// Of an effect without a number to fit: its trace for `value` of the parameter.
    void keep_fixed(const physics::EffectParameter& parameter, double value,
                    const Projection& projection);

  private:
    void keep(const fit::FreeParameter& parameter, double size, const Projection& projection,
              const Eigen::VectorXd& imitated);
    void name(const fit::FreeParameter& parameter);
    void keep_direction(const Projection& projection, const Eigen::VectorXd& imitated);
    [[nodiscard]] double bias(const physics::ParameterId& id) const;
    [[nodiscard]] fit::StartModels without_imitation(const Eigen::VectorXd& imitated) const;
    [[nodiscard]] Projection trace(const fit::FreeParameter& parameter, double value,
                                   const Eigen::VectorXd& imitated) const;
    [[nodiscard]] double value_of(const fit::FreeParameter& parameter, double size) const;
    [[nodiscard]] double size_of(const fit::FreeParameter& parameter, double value) const;

    const fit::Fit& base_;
    const StackedReadings& fitted_;
    std::span<const fit::ObservedRecording> recordings_;
    const fit::FitOptions& options_;
    EffectScore& score_;
    double size_ = std::numeric_limits<double>::infinity(); ///< away from its absence
    fit::StartModels absent_; ///< the start that has told it, else the first
    double absent_at_ = 0.0;  ///< its value there
    Eigen::VectorXd absent_predicted_;
    Eigen::VectorXd imitated_; ///< change of what is fitted without the effect that hides the size
};

/// Columns of `stacked` that are among those of `fitted`.
[[nodiscard]] Eigen::MatrixXd columns_of(const StackedReadings& fitted,
                                         const StackedReadings& stacked);

} // namespace culm::diagnose
