// SPDX-License-Identifier: BSD-3-Clause
#include "integrate/sundials/integrator.hpp"

#include "core/error.hpp"
#include "integrate/condensed_newton.hpp"
#include "integrate/error_weights.hpp"
#include "integrate/sundials/stepper.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/core.h>
#include <sundials/sundials_version.h>

namespace culm::integrate {
namespace {

using namespace sundials;

/// Method errors in the bonds' histories and geometry also appear in the positions. Errors of an
/// unfinished Newton iteration do not, and they persist as a wrong shape at rest, or as a bond that
/// no longer ends at its spheres. These states therefore need a weight.
ErrorShares counted_errors(double rate_weight) {
    return {.rates = rate_weight, .histories = std::max(rate_weight, 0.01), .geometry = 1.0};
}

/// One chain's equations with the condensed Newton system of culm's own integrator.
template <int Dim>
class ChainEquations final : public Equations {
  public:
    ChainEquations(const physics::Chain<Dim, double>& chain, const ErrorScales& scales,
                   double tolerance, double rate_weight)
        : chain_(chain), newton_(chain),
          weights_(error_weights(chain.layout(), scales, tolerance, counted_errors(rate_weight))) {
        // SUNDIALS takes the mean of the squares, error_weights() their sum.
        const double root = std::sqrt(static_cast<double>(weights_.size()));
        for (double& weight : weights_)
            weight *= root;
    }

    void evaluate_rate(double time, const double* state, double* rate) override {
        chain_.evaluate_rate(state, rate, time);
    }
    void evaluate_jacobian(double time, const double* state) override {
        newton_.set_state(state, time);
    }
    bool factorise(double gamma) override { return newton_.factorise(gamma); }
    void solve(const double* b, double* x) override { newton_.solve(b, x); }
    [[nodiscard]] std::span<const double> weights() const override { return weights_; }

  private:
    const physics::Chain<Dim, double>& chain_;
    CondensedNewton<Dim> newton_;
    std::vector<double> weights_;
};

/// The meaning of ARKODE's flags.
std::string_view meaning_of(int flag) {
    switch (flag) {
    case ARK_TOO_MUCH_ACC:
        return "the tolerance is too tight for double precision";
    case ARK_ERR_FAILURE:
        return "the error test failed again and again, or the step became too short";
    case ARK_CONV_FAILURE:
        return "Newton's iteration did not converge, however short the step";
    case ARK_LSETUP_FAIL:
        return "the Newton matrix could not be set up";
    case ARK_LSOLVE_FAIL:
        return "the Newton system could not be solved";
    case ARK_RHSFUNC_FAIL:
    case ARK_FIRST_RHSFUNC_ERR:
    case ARK_REPTD_RHSFUNC_ERR:
    case ARK_UNREC_RHSFUNC_ERR:
        return "the right-hand side is not a number";
    default:
        return "see the manual of SUNDIALS";
    }
}

} // namespace

std::string sundials_version() {
    std::array<char, 64> text{};
    SUNDIALSGetVersion(text.data(), static_cast<int>(text.size()));
    return text.data();
}

template <int Dim>
SundialsIntegrator<Dim>::SundialsIntegrator(const physics::ChainLayout<Dim>& layout,
                                            const std::string& table)
    : stepper_(std::make_unique<Stepper>(layout.size(), table)) {}

template <int Dim>
SundialsIntegrator<Dim>::~SundialsIntegrator() = default;

template <int Dim>
LaneOutcome SundialsIntegrator<Dim>::integrate(const physics::Chain<Dim, double>& chain,
                                               const std::vector<double>& released,
                                               const ErrorScales& scales, double duration,
                                               const StepObserver& observe,
                                               const ImplicitOptions& options) {
    ChainEquations<Dim> equations(chain, scales, options.relative_tolerance,
                                  options.rate_error_weight);
    const std::span<double> state = stepper_->state();
    std::ranges::copy(released, state.begin());
    chain.layout().set_geometry(state.data());
    stepper_->restart(equations, first_step(scales), longest_step(chain.model()));
    observe(0.0, state);
    LaneOutcome outcome;
    double time = 0.0;
    for (std::int64_t step = 0; time < duration && !outcome.failure; ++step) {
        if (step == options.step_limit) {
            outcome.failure = core::NumericalError(
                core::FailureKind::StepLimit,
                fmt::format("SUNDIALS' arkode used up its {} steps at t = {:.6g} s", step, time));
            break;
        }
        double end = time;
        const int flag = stepper_->step(duration, end);
        if (flag < 0)
            outcome.failure = core::NumericalError(
                core::FailureKind::SolverFailed,
                fmt::format("SUNDIALS' arkode failed at t = {:.6g} s: {} ({})", time,
                            meaning_of(flag), stepper_->flag_name(flag)));
        else
            observe(time = end, state);
        if (options.heartbeat && !options.heartbeat())
            throw Interrupted{};
    }
    outcome.work = stepper_->work();
    return outcome;
}

template class SundialsIntegrator<2>;
template class SundialsIntegrator<3>;

} // namespace culm::integrate
