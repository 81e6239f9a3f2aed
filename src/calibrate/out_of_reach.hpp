// SPDX-License-Identifier: BSD-3-Clause
// When a solution is given up because it would not come to what is wanted.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

#include <ceres/iteration_callback.h>

namespace culm::calibrate {

/// Ends a solution that slows down and could not come down to `wanted` within its iterations even
/// at the best pace of its last ones. One that gains speed goes on: steps begin short and triple.
class OutOfReach : public ceres::IterationCallback {
  public:
    OutOfReach(double wanted, int largest_iterations)
        : wanted_(wanted), largest_iterations_(largest_iterations) {}
    [[nodiscard]] bool is_so() const { return is_so_; }
    ceres::CallbackReturnType operator()(const ceres::IterationSummary& iteration) override {
        const auto slot = static_cast<std::size_t>(iteration.iteration) % gains_.size();
        gains_[slot] = iteration.step_is_successful ? iteration.cost_change : 0.0;
        if (iteration.iteration < static_cast<int>(gains_.size()))
            return ceres::SOLVER_CONTINUE;
        const double left = largest_iterations_ - iteration.iteration;
        const double best = *std::ranges::max_element(gains_);
        const double before = gains_[(slot + gains_.size() - 1) % gains_.size()];
        const bool slows_down = std::max(gains_[slot], before) <= 0.5 * best;
        // Of a step that failed, `cost` is where it would have led.
        const double cost =
            iteration.cost + (iteration.step_is_successful ? 0.0 : iteration.cost_change);
        is_so_ = slows_down && cost - left * best > wanted_;
        return is_so_ ? ceres::SOLVER_TERMINATE_SUCCESSFULLY : ceres::SOLVER_CONTINUE;
    }

  private:
    double wanted_; ///< as Ceres counts the cost
    int largest_iterations_;
    std::array<double, 5> gains_{}; ///< of the last iterations
    bool is_so_ = false;
};

} // namespace culm::calibrate
