// SPDX-License-Identifier: BSD-3-Clause
// How long the next step of one stem is: proportional-integral control of the error per step.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

namespace culm::integrate {

/// Keeps time and step of one stem. Errors are given in units of what is allowed.
/// Gustafsson's PI controller in the constants of Hairer & Wanner (1996), section IV.2.
class StepController {
  public:
    /// `embedded_order`: of the solution that the error estimate belongs to.
    StepController(double first_step, int embedded_order)
        : step_(first_step), smallest_step_(1e-12 * first_step),
          exponent_(1.0 / (embedded_order + 1)) {}

    /// Every step has this length from now on, whatever its error.
    void fix_step(double step) {
        step_ = step;
        is_fixed_ = true;
    }

    /// No step is longer than this from now on, but for fixed ones.
    void limit_step(double largest) {
        largest_step_ = largest;
        if (!is_fixed_)
            step_ = std::min(step_, largest);
    }

    [[nodiscard]] double time() const { return time_; }
    [[nodiscard]] double step() const { return step_; }
    [[nodiscard]] std::int64_t accepted_steps() const { return accepted_; }
    [[nodiscard]] std::int64_t rejected_steps() const { return rejected_; }
    /// Shorter steps do not help either.
    [[nodiscard]] bool has_failed() const {
        return step_ < smallest_step_ || (is_fixed_ && rejected_ > 0);
    }

    /// Judges the step just tried; true accepts it. An error that is not a number rejects.
    bool judge(double error) {
        constexpr double safety = 0.9;
        constexpr double least_error = 1e-10;
        if (is_fixed_ ? !std::isfinite(error) : !(error <= 1.0)) {
            ++rejected_;
            after_rejection_ = true;
            step_ *= std::isfinite(error)
                         ? std::clamp(safety * std::pow(error, -exponent_), 0.1, 0.9)
                         : 0.1;
            return false;
        }
        time_ += step_;
        ++accepted_;
        if (!is_fixed_) {
            const double bounded = std::max(error, least_error);
            const double growth = safety * std::pow(bounded, -0.7 * exponent_) *
                                  std::pow(previous_error_, 0.4 * exponent_);
            step_ = std::min(step_ * std::clamp(growth, 0.2, after_rejection_ ? 1.0 : 5.0),
                             largest_step_);
            previous_error_ = std::max(bounded, 1e-4);
            after_rejection_ = false;
        }
        return true;
    }

  private:
    double time_ = 0.0;
    double step_;
    double smallest_step_;
    double largest_step_ = std::numeric_limits<double>::infinity();
    double exponent_;
    double previous_error_ = 1.0;
    bool is_fixed_ = false;
    bool after_rejection_ = false;
    std::int64_t accepted_ = 0;
    std::int64_t rejected_ = 0;
};

} // namespace culm::integrate
