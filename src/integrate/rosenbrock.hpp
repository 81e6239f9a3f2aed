// SPDX-License-Identifier: BSD-3-Clause
// Linearly implicit integration of a chain: one stem, or one stem per SIMD lane with its own step.
#pragma once

#include "core/lanes.hpp"
#include "integrate/condensed_newton.hpp"
#include "integrate/error_weights.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string_view>
#include <utility>
#include <vector>

namespace culm::integrate {

/// Di Marzo (1993), thesis, University of Geneva; listed by Hairer & Wanner (1996). L-stable
/// and stiffly accurate: the last stage's argument plus its increment is the new solution, and the
/// increment itself the difference to the embedded one. `argument` holds a_ij and `coupling` c_ij
/// of their Eq. IV.7.25; tests/integrate measures the order.
struct Rodas5 {
    static constexpr std::string_view name = "RODAS5";
    static constexpr std::size_t stages = 8;
    static constexpr int order = 5;
    static constexpr int embedded_order = 4;
    static constexpr double gamma = 0.19;
    static constexpr std::array<std::array<double, stages>, stages> argument{{
        {{}},
        {{2}},
        {{3.040894194418781, 1.041747909077569}},
        {{2.576417536461461, 1.622083060776640, -0.9089668560264532}},
        {{2.760842080225597, 1.446624659844071, -0.3036980084553738, 0.2877498600325443}},
        {{-14.09640773051259, 6.925207756232704, -41.47510893210728, 2.343771018586405,
          24.13215229196062}},
        {{-14.09640773051259, 6.925207756232704, -41.47510893210728, 2.343771018586405,
          24.13215229196062, 1}},
        {{-14.09640773051259, 6.925207756232704, -41.47510893210728, 2.343771018586405,
          24.13215229196062, 1, 1}},
    }};
    static constexpr std::array<std::array<double, stages>, stages> coupling{{
        {{}},
        {{-10.31323885133993}},
        {{-21.04823117650003, -7.234992135176716}},
        {{32.22751541853323, -4.943732386540191, 19.44922031041879}},
        {{-20.69865579590063, -8.816374604402768, 1.260436877740897, -0.7495647613787146}},
        {{-46.22004352711257, -17.49534862857472, -289.6389582892057, 93.60855400400906,
          318.3822534212147}},
        {{34.20013733472935, -14.15535402717690, 57.82335640988400, 25.83362985412365,
          1.408950972071624, -6.551835421242162}},
        {{42.57076742291101, -13.80770672017997, 93.98938432427124, 18.77919633714503,
          -31.58359187223370, -6.685968952921985, -5.810979938412932}},
    }};
};

/// Time as an additional unknown of an equation whose right-hand side depends on time: the time at
/// which a stage evaluates it, and the increment of time. The unit is one step.
struct StageTime {
    double argument = 0.0;
    double increment = 0.0;
};

template <class Method>
inline constexpr auto stage_times = [] {
    std::array<StageTime, Method::stages> times{};
    for (std::size_t i = 0; i < Method::stages; ++i) {
        double coupled = 1.0;
        for (std::size_t j = 0; j < i; ++j) {
            times[i].argument += Method::argument[i][j] * times[j].increment;
            coupled += Method::coupling[i][j] * times[j].increment;
        }
        times[i].increment = Method::gamma * coupled;
    }
    return times;
}();

/// Keeps time and step of one stem. Errors are given in units of what is allowed.
/// Gustafsson's PI controller in the constants of Hairer & Wanner (1996), section IV.2.
class StepController {
  public:
    /// `embedded_order`: order of the embedded solution of the error estimate.
    StepController(double first_step, int embedded_order)
        : step_(first_step), smallest_step_(1e-12 * first_step),
          exponent_(1.0 / (embedded_order + 1)) {}

    /// Every step has this length from now on, whatever its error.
    void fix_step(double step) {
        step_ = step;
        is_fixed_ = true;
    }

    /// No step is longer than this from now on, except fixed ones.
    void limit_step(double largest) {
        largest_step_ = largest;
        if (!is_fixed_)
            step_ = std::min(step_, largest);
    }

    [[nodiscard]] double time() const { return time_; }
    [[nodiscard]] double step() const { return step_; }
    [[nodiscard]] std::int64_t accepted_steps() const { return accepted_; }
    [[nodiscard]] std::int64_t rejected_steps() const { return rejected_; }
    /// Whether even shorter steps would not help.
    [[nodiscard]] bool has_failed() const {
        return step_ < smallest_step_ || (is_fixed_ && rejected_ > 0);
    }

    /// Judges the last attempt; true accepts it. An error that is not a number rejects it.
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

/// A Rosenbrock method solves, in stage i with increments U of the stages before it,
///   (I − γhJ) U_i = γ (h f(y + Σ a_ij U_j) + Σ c_ij U_j)
/// (Hairer & Wanner 1996, Eq. IV.7.25, times γh). J is the exact Jacobian at the step's start.
/// No iteration can fail, and every lane does the same work.
template <int Dim, class T, class Method = Rodas5>
class Rosenbrock {
  public:
    static constexpr std::size_t lanes = core::lanes_of<T>;

    /// Starts from `state` (the chain's layout) at t = 0. The error of a step is the root mean
    /// square of the positions' errors over `tolerance` × displacement scale; the errors of
    /// velocities, spins and bond histories count with the weight `rate_error_weight`.
    Rosenbrock(const physics::Chain<Dim, T>& chain, std::vector<T> state,
               const ErrorScalesOf<T>& scales, double tolerance, double rate_error_weight)
        : chain_(chain), newton_(chain), state_(std::move(state)), argument_(state_.size()),
          rate_(state_.size()), time_derivative_(state_.size()),
          weights_(error_weights(chain.layout(), scales, tolerance,
                                 {.rates = rate_error_weight, .histories = rate_error_weight})),
          only_positions_(rate_error_weight == 0.0),
          depends_on_time_(chain.model().depends_on_time()) {
        chain.layout().set_geometry(state_.data());
        increments_.fill(std::vector<T>(state_.size()));
        for (std::size_t lane = 0; lane < lanes; ++lane) {
            StepController& controller =
                controllers_.emplace_back(first_step(scales, lane), Method::embedded_order);
            controller.limit_step(longest_step(chain.model(), lane));
        }
    }

    void fix_step(double step) {
        for (StepController& controller : controllers_)
            controller.fix_step(step);
    }
    /// All lanes take the steps of lane 0. The results are then smooth functions of the lanes'
    /// parameters, so that differences of lanes give derivatives.
    void follow_first_lane() { follows_first_lane_ = true; }

    [[nodiscard]] const StepController& controller(std::size_t lane) const {
        return controllers_[follows_first_lane_ ? 0 : lane];
    }
    [[nodiscard]] const std::vector<T>& state() const { return state_; }

    /// Tries one step in every lane that `wanted` names; a lane's state changes if its step is
    /// accepted. Returns which were.
    std::array<bool, lanes> try_step(const std::array<bool, lanes>& wanted) {
        time_ = core::by_lane<T>([this](std::size_t lane) { return controller(lane).time(); });
        if (state_is_new_)
            newton_.set_state(state_.data(), time_);
        step_ = core::by_lane<T>([this](std::size_t lane) { return controller(lane).step(); });
        if (depends_on_time_)
            set_time_derivative();
        // A lane whose matrix is singular gets an error that is not a number, and a shorter step.
        (void)newton_.factorise(T(Method::gamma) * step_);
        run_stages(std::make_index_sequence<Method::stages>());
        const T error = error_of_step();
        std::array<bool, lanes> accepted{};
        if (follows_first_lane_) {
            // A clamp that sticks a little later in another lane would send it astray.
            constexpr double largest_error = 10.0; // of the other lanes, over the allowed one
            double judged = core::lane(error, 0);
            for (std::size_t lane = 1; lane < lanes; ++lane)
                if (const double other = core::lane(error, lane) / largest_error;
                    std::isfinite(other))
                    judged = std::max(judged, other);
            accepted.fill(controllers_[0].judge(judged));
        } else {
            for (std::size_t lane = 0; lane < lanes; ++lane)
                accepted[lane] = wanted[lane] && controllers_[lane].judge(core::lane(error, lane));
        }
        state_is_new_ = take_over(accepted);
        return accepted;
    }

  private:
    template <std::size_t... Stage>
    void run_stages(std::index_sequence<Stage...>) {
        (run_stage<Stage>(), ...);
    }

    template <std::size_t Stage>
    void run_stage() {
        const std::size_t size = state_.size();
        T* const increment = increments_[Stage].data();
        if constexpr (Stage > 0)
            sum_stages<Stage>();
        chain_.evaluate_rate(Stage > 0 ? argument_.data() : state_.data(), rate_.data(),
                             time_ + T(stage_times<Method>[Stage].argument) * step_);
        const T scaled_step = T(Method::gamma) * step_;
        for (std::size_t k = 0; k < size; ++k) {
            increment[k] = Stage > 0 ? scaled_step * rate_[k] + T(Method::gamma) * increment[k]
                                     : scaled_step * rate_[k];
        }
        if (depends_on_time_) {
            const T factor = scaled_step * step_ * T(stage_times<Method>[Stage].increment);
            for (std::size_t k = 0; k < size; ++k)
                increment[k] += factor * time_derivative_[k];
        }
        newton_.solve(increment, increment);
    }

    /// Writes the stage's argument, and Σ c_ij U_j into the array of its increment. Both are
    /// computed in one pass, because reading the increments takes most of the time.
    template <std::size_t Stage>
    [[gnu::flatten]] void sum_stages() {
        constexpr auto& a = Method::argument[Stage];
        constexpr auto& c = Method::coupling[Stage];
        T* const increment = increments_[Stage].data();
        T* const argument = argument_.data();
        const std::size_t size = state_.size();
#pragma GCC ivdep // there are too many arrays for the compiler to check whether they overlap
        for (std::size_t k = 0; k < size; ++k) {
            if constexpr (continues_argument<Stage>())
                argument[k] += increments_[Stage - 1][k];
            else
                argument[k] = combined<Stage>(a, state_[k], k);
            increment[k] = combined<Stage>(c, T(0.0), k);
        }
    }

    /// Is the stage's argument that of the stage before plus its increment?
    template <std::size_t Stage>
    [[nodiscard]] static constexpr bool continues_argument() {
        auto before = Method::argument[Stage - 1];
        before[Stage - 1] = 1.0;
        return Stage > 1 && Method::argument[Stage] == before;
    }

    /// ∂f/∂t at the step's start, as a difference over a small part of the step. Without this
    /// derivative the method loses its order if the right-hand side depends on time.
    void set_time_derivative() {
        const T change = T(1e-4) * step_;
        chain_.evaluate_rate(state_.data(), rate_.data(), time_);
        chain_.evaluate_rate(state_.data(), time_derivative_.data(), time_ + change);
        for (std::size_t k = 0; k < rate_.size(); ++k)
            time_derivative_[k] = (time_derivative_[k] - rate_[k]) / change;
    }

    /// start + Σ factors_j U_j at index `k`, over the first `Count` stages.
    template <std::size_t Count>
    [[nodiscard]] T combined(const std::array<double, Method::stages>& factors, const T& start,
                             std::size_t k) const {
        return [&]<std::size_t... J>(std::index_sequence<J...>) {
            T sum = start;
            ((sum += T(factors[J]) * increments_[J][k]), ...);
            return sum;
        }
        (std::make_index_sequence<Count>());
    }

    /// The method is stiffly accurate: its last increment is the error estimate.
    [[nodiscard]] T error_of_step() const {
        using std::sqrt;
        const std::vector<T>& increment = increments_[Method::stages - 1];
        T sum = T(0.0);
        const auto add = [&](std::size_t k) {
            const T part = weights_[k] * increment[k];
            sum += part * part;
        };
        if (only_positions_) {
            for (int i = 0; i < chain_.layout().sphere_count(); ++i)
                for (std::size_t d = 0; d < Dim; ++d)
                    add(chain_.layout().sphere_offset(i) + d);
            if (chain_.base_turns()) {
                add(chain_.layout().base_rotation_offset());
                add(base_spin_place(chain_.layout()));
                if (chain_.layout().base_slips())
                    add(chain_.layout().base_moment_offset());
            }
        } else {
            for (std::size_t k = 0; k < increment.size(); ++k)
                add(k);
        }
        return sqrt(sum);
    }

    /// Adds the last increment to the last stage's argument, which gives the new state. Returns
    /// whether any lane accepted it.
    bool take_over(const std::array<bool, lanes>& accepted) {
        if (std::ranges::find(accepted, true) == accepted.end())
            return false;
        const std::vector<T>& last = increments_[Method::stages - 1];
        for (std::size_t k = 0; k < argument_.size(); ++k)
            argument_[k] = argument_[k] + last[k];
        if (std::ranges::find(accepted, false) == accepted.end()) {
            std::swap(state_, argument_);
        } else if constexpr (lanes > 1) {
            const T choice =
                core::by_lane<T>([&](std::size_t lane) { return accepted[lane] ? 1.0 : 0.0; });
            for (std::size_t k = 0; k < argument_.size(); ++k)
                where(choice > T(0.5), state_[k]) = argument_[k];
        }
        return true;
    }

    const physics::Chain<Dim, T>& chain_;
    CondensedNewton<Dim, T> newton_;
    std::vector<T> state_;
    std::vector<T> argument_;
    std::vector<T> rate_;
    std::array<std::vector<T>, Method::stages> increments_;
    std::vector<T> time_derivative_;
    std::vector<T> weights_;
    bool only_positions_;
    bool depends_on_time_;
    std::vector<StepController> controllers_; ///< one a lane
    T step_ = T(0.0);
    T time_ = T(0.0);
    bool state_is_new_ = true;
    bool follows_first_lane_ = false;
};

} // namespace culm::integrate
