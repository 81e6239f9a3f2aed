// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/frequency_match.hpp"

#include "core/error.hpp"
#include "diagnose/fit_starts.hpp"
#include "run/modes.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

namespace culm::diagnose {
namespace {

constexpr int modulus_passes = 3;         // f² is nearly a straight line in Y
constexpr double first_step = 1.0 / 16.0; ///< of the size's scale
constexpr int most_doublings = 20;
constexpr int halvings = 12;
/// An excess that moves by no more than this share over a scale does not depend on the size.
constexpr double least_influence = 1e-3;

/// A point of the search: the size as it is fitted, and what is to vanish there.
struct Trial {
    double internal = 0.0;
    double excess = 0.0;
};

class ModulusSearch {
  public:
    ModulusSearch(const calibrate::FreeParameter& size, const run::CaseSpec& spec,
                  const std::function<double(const run::CaseSpec&)>& excess)
        : size_(size), spec_(spec), excess_(excess) {
        std::tie(lower_, upper_) = std::minmax({calibrate::to_internal(size, spec, size.lower),
                                                calibrate::to_internal(size, spec, size.upper)});
        absent_ = at(calibrate::to_internal(size, spec, absent_value(size)));
        best_ = absent_;
    }

    [[nodiscard]] double run() {
        const double least = least_influence * std::abs(absent_.excess);
        for (const double direction : {1.0, -1.0}) {
            const Trial far = at(std::clamp(absent_.internal + direction, lower_, upper_));
            if (std::abs(far.excess - absent_.excess) > least && go(direction))
                break;
        }
        return calibrate::from_internal(size_, spec_, best_.internal);
    }

  private:
    [[nodiscard]] Trial at(double internal) const {
        run::CaseSpec spec = spec_;
        size_.access.set(spec, calibrate::from_internal(size_, spec_, internal));
        return {internal, excess_(spec)};
    }
    void take(const Trial& trial) {
        if (std::abs(trial.excess) < std::abs(best_.excess))
            best_ = trial;
    }
    [[nodiscard]] bool go(double direction) {
        Trial last = absent_;
        double step = first_step;
        for (int k = 0; k < most_doublings; ++k, step *= 2.0) {
            const Trial next = at(std::clamp(absent_.internal + direction * step, lower_, upper_));
            if (!std::isfinite(next.excess) || next.internal == last.internal)
                return false;
            take(next);
            if (std::signbit(next.excess) != std::signbit(last.excess)) {
                halve(last, next);
                return true;
            }
            last = next;
        }
        return false;
    }
    void halve(Trial left, Trial right) {
        for (int k = 0; k < halvings; ++k) {
            const Trial middle = at(0.5 * (left.internal + right.internal));
            take(middle);
            (std::signbit(middle.excess) == std::signbit(left.excess) ? left : right) = middle;
        }
    }

    const calibrate::FreeParameter& size_;
    const run::CaseSpec& spec_;
    const std::function<double(const run::CaseSpec&)>& excess_;
    double lower_ = 0.0;
    double upper_ = 0.0;
    Trial absent_;
    Trial best_;
};

} // namespace

double first_frequency(const run::CaseSpec& spec) {
    try {
        const auto modes = chain_modes(spec, 1);
        if (!modes.empty())
            return modes.front().frequency;
    } catch (const core::NumericalError&) {
        // Far from any stem a chain may be beyond what eigenvalues can be computed of.
    }
    return std::numeric_limits<double>::quiet_NaN();
}

double matching_modulus(run::CaseSpec spec, double frequency) {
    for (int pass = 0; pass < modulus_passes; ++pass) {
        const double own = first_frequency(spec);
        if (!std::isfinite(own))
            break;
        spec.stem.bond_youngs_modulus *= (frequency / own) * (frequency / own);
    }
    return spec.stem.bond_youngs_modulus;
}

void match(const calibrate::FreeParameter& size, run::CaseSpec& spec,
           const std::function<double(const run::CaseSpec&)>& excess) {
    const double value = ModulusSearch(size, spec, excess).run();
    size.access.set(spec, value);
}

} // namespace culm::diagnose
