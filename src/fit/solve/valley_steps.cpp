// SPDX-License-Identifier: BSD-3-Clause
#include "fit/solve/valley_steps.hpp"

#include "run/modes.hpp"

#include <algorithm>
#include <cmath>

namespace culm::fit {

namespace {

constexpr double slope_share = 1e-3; ///< of the step, for its slope
constexpr int corrections = 3;       ///< f² is nearly a straight line in Y
constexpr double largest_correction = 2.0;

} // namespace

ValleySteps::ValleySteps(const JointResiduals& residuals, const JointLayout& layout,
                         const std::vector<bool>& is_held)
    : residuals_(residuals), size_(residuals.parameter_count()) {
    for (std::size_t k = 0; k < size_; ++k)
        if (k >= is_held.size() || !is_held[k])
            free_.push_back(k);
    const auto found = std::ranges::find(layout.ids, physics::bond_youngs_modulus);
    const auto place = static_cast<std::size_t>(found - layout.ids.begin());
    if (found != layout.ids.end() && std::ranges::find(free_, place) != free_.end())
        modulus_ = place;
}

double ValleySteps::log_square(const std::vector<double>& internal) const {
    return 2.0 * std::log(run::lowest_frequency_with_effects(residuals_.case_at(internal.data())));
}

// The readings of N cycles lose their phase after a change of f by 1/N, while Y and an added mass
// or a soft clamp can change together by far more at the same f. So χ² is a curved valley whose
// walls are steep in f and whose floor is flat. A straight Gauss-Newton step leaves the floor and
// is shortened again and again. Here a step has the frequency of the straight step to first order:
// f² is proportional to Y except for the share of the other parameters, so ln f² is corrected by
// changes of ln Y.
void ValleySteps::follow_frequency(const std::vector<double>& point,
                                   std::vector<double>& moved) const {
    std::vector<double> ahead(size_);
    std::vector<double> behind(size_);
    for (std::size_t k = 0; k < size_; ++k) {
        ahead[k] = point[k] + slope_share * (moved[k] - point[k]);
        behind[k] = point[k] - slope_share * (moved[k] - point[k]);
    }
    // The frequency of the step to first order: a central difference along it.
    const double wanted =
        log_square(point) + (log_square(ahead) - log_square(behind)) / (2.0 * slope_share);
    const double straight = moved[*modulus_];
    for (int pass = 0; pass < corrections; ++pass) {
        const double missing = wanted - log_square(moved);
        if (!(std::abs(missing) < largest_correction)) { // no frequency to follow
            moved[*modulus_] = straight;
            return;
        }
        moved[*modulus_] += missing;
    }
}

bool ValleySteps::Plus(const double* point, const double* step, double* moved) const {
    std::vector<double> to(point, point + size_);
    for (std::size_t k = 0; k < free_.size(); ++k)
        to[free_[k]] += step[k];
    if (modulus_)
        follow_frequency({point, point + size_}, to);
    std::ranges::copy(to, moved);
    return true;
}

// To first order Plus() is the straight step, so its derivative is that of a linear subspace.
bool ValleySteps::PlusJacobian(const double*, double* jacobian) const {
    std::fill_n(jacobian, size_ * free_.size(), 0.0); // (ambient, tangent), row-major
    for (std::size_t k = 0; k < free_.size(); ++k)
        jacobian[free_[k] * free_.size() + k] = 1.0;
    return true;
}

bool ValleySteps::Minus(const double* moved, const double* point, double* step) const {
    for (std::size_t k = 0; k < free_.size(); ++k)
        step[k] = moved[free_[k]] - point[free_[k]];
    return true;
}

bool ValleySteps::MinusJacobian(const double*, double* jacobian) const {
    std::fill_n(jacobian, size_ * free_.size(), 0.0); // (tangent, ambient), row-major
    for (std::size_t k = 0; k < free_.size(); ++k)
        jacobian[k * size_ + free_[k]] = 1.0;
    return true;
}

} // namespace culm::fit
