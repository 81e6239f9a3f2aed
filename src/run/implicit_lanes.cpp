// SPDX-License-Identifier: BSD-3-Clause
#include "integrate/history_sampler.hpp"
#include "integrate/implicit.hpp"
#include "run/case_lanes.hpp"
#include "run/case_model.hpp"
#include "run/recorder.hpp"
#include "run/simulate.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <utility>

#include <fmt/core.h>

namespace culm::run {
namespace {

/// The first sample that is not a number, if any.
std::optional<CaseFailure> not_a_number(const CaseResult& result, double sample_interval) {
    for (std::size_t k = 0; k < result.tip_deflection.size(); ++k)
        if (!std::isfinite(result.tip_deflection[k]))
            return CaseFailure{core::FailureKind::NotANumber,
                               fmt::format("the tip's position is not a number at t = {:.6g} s",
                                           static_cast<double>(k) * sample_interval)};
    return std::nullopt;
}

/// Scale of the integration error, m: the prescribed deflection and the sag of a cantilever under
/// its own weight, q L⁴/(8 E I).
double largest_deflection(const CaseSpec& spec) {
    double gravity = 0.0;
    if (spec.release == Release::HeldStraight)
        gravity = std::abs(case_model(spec).chain.gravity[1]);
    const physics::StemParameters<double>& stem = spec.stem;
    const double length = stem.free_length();
    const double sag = stem.sphere_mass() / stem.bond_length * gravity * std::pow(length, 4) /
                       (8.0 * stem.bond_youngs_modulus * stem.second_moment_of_area());
    const double largest = std::abs(spec.tip_deflection) + std::min(sag, length);
    // The scale must not be zero for a stem that is expected to stay at rest.
    const bool starts_at_rest = spec.release == Release::HeldStraight || spec.tip_deflection == 0.0;
    return std::max(largest, starts_at_rest ? 0.01 * length : 0.0);
}

template <int Dim, class T>
class ImplicitBatch {
    static constexpr std::size_t lanes = core::lanes_of<T>;

  public:
    /// Cases of RODAS5, or one of SUNDIALS, whose integrators are then needed.
    ImplicitBatch(std::span<const CaseSpec> specs, integrate::SundialsIntegrators* integrators)
        : specs_(specs), integrators_(integrators) {
        recorders_.reserve(specs.size());
        samplers_.reserve(specs.size());
        const physics::ChainLayout<Dim> layout(specs.front().stem.sphere_count);
        for (const CaseSpec& spec : specs) {
            Recorder& recorder = recorders_.emplace_back(spec);
            samplers_.emplace_back(layout, recorder.first_watched_sphere(),
                                   spec.stem.sphere_count - 1, spec.sample_interval,
                                   recorder.recorded_samples(), recorder.needs_rates(),
                                   [&recorder](std::size_t index, const auto& rates) {
                                       recorder.record(index, {rates[0], rates[1], rates[2]});
                                   });
        }
    }

    [[nodiscard]] std::vector<CaseOutcome> run(const Heartbeat& heartbeat, bool on_common_steps) {
        const auto start = std::chrono::steady_clock::now();
        const physics::StemParameters<T> stems = packed_stems<T>(specs_);
        const ReleasedState<T> released = released_lanes<Dim, T>(specs_);
        const physics::Chain<Dim, T> chain(specs_.front().stem.sphere_count, released.model,
                                           specs_.front().law);
        const T tip_deflection = core::by_lane<T>(
            [this](std::size_t lane) { return largest_deflection(in_lane(specs_, lane)); });
        std::array<double, lanes> durations{};
        for (std::size_t lane = 0; lane < specs_.size(); ++lane)
            durations[lane] = released.failures[lane] ? 0.0 : recorders_[lane].recorded_duration();
        // All lanes end at the same time, so their last samples come from the same steps. Otherwise
        // the derivative by the readout time would contain the difference between two
        // interpolations.
        if (on_common_steps)
            std::fill_n(durations.begin(), specs_.size(), *std::ranges::max_element(durations));
        integrate::ImplicitOptions options;
        options.relative_tolerance = specs_.front().integrator.relative_tolerance;
        options.step_limit = specs_.front().integrator.step_limit;
        options.follow_first_lane = on_common_steps;
        options.heartbeat = heartbeat;
        const auto ends =
            integrated(chain, released.state, integrate::cantilever_scales(stems, tip_deflection),
                       durations, options);

        const double wall =
            std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        std::vector<CaseOutcome> outcomes;
        for (std::size_t lane = 0; lane < specs_.size(); ++lane)
            outcomes.push_back(
                released.failures[lane]
                    ? CaseOutcome(*released.failures[lane])
                    : outcome(lane, ends[lane], wall / static_cast<double>(specs_.size())));
        return outcomes;
    }

  private:
    [[nodiscard]] std::array<integrate::LaneOutcome, lanes>
    integrated(const physics::Chain<Dim, T>& chain, const std::vector<T>& released,
               const integrate::ErrorScalesOf<T>& scales,
               const std::array<double, lanes>& durations,
               const integrate::ImplicitOptions& options) {
        const auto observe = [this](std::size_t lane, double time, std::span<const T> state) {
            if (lane < samplers_.size())
                samplers_[lane].observe(time, state, lane);
        };
        if constexpr (lanes == 1) {
            if (integrators_ != nullptr && durations[0] > 0.0)
                return {integrators_->integrator_for(chain.layout())
                            .integrate(chain, released, scales, durations[0],
                                       std::bind_front(observe, 0), options)};
        }
        return integrate::integrate_lanes<Dim, T>(chain, released, scales, durations, observe,
                                                  options);
    }

    [[nodiscard]] CaseOutcome outcome(std::size_t lane, const integrate::LaneOutcome& end,
                                      double wall_seconds) {
        if (end.failure)
            return CaseFailure{end.failure->kind(), end.failure->what()};
        samplers_[lane].finish();
        recorders_[lane].finish();
        CaseResult& result = recorders_[lane].result();
        if (auto failure = not_a_number(result, specs_[lane].sample_interval))
            return *failure;
        result.work = end.work;
        result.wall_seconds = wall_seconds;
        return std::move(result);
    }

    std::span<const CaseSpec> specs_;
    integrate::SundialsIntegrators* integrators_;
    std::vector<Recorder> recorders_;
    std::vector<integrate::HistorySampler<Dim>> samplers_;
};

template <class T>
std::vector<CaseOutcome> run_batch(std::span<const CaseSpec> specs, const Heartbeat& heartbeat,
                                   bool on_common_steps,
                                   integrate::SundialsIntegrators* integrators) {
    return dimensions_of(specs.front()) == 2
               ? ImplicitBatch<2, T>(specs, integrators).run(heartbeat, on_common_steps)
               : ImplicitBatch<3, T>(specs, integrators).run(heartbeat, on_common_steps);
}

} // namespace

template <class T>
std::vector<CaseOutcome> simulate_implicit_lanes(std::span<const CaseSpec> specs,
                                                 const Heartbeat& heartbeat,
                                                 integrate::SundialsIntegrators* integrators) {
    return run_batch<T>(specs, heartbeat, false, integrators);
}

template std::vector<CaseOutcome> simulate_implicit_lanes<double>(std::span<const CaseSpec>,
                                                                  const Heartbeat&,
                                                                  integrate::SundialsIntegrators*);
template std::vector<CaseOutcome>
simulate_implicit_lanes<core::Lanes>(std::span<const CaseSpec>, const Heartbeat&,
                                     integrate::SundialsIntegrators*);

std::vector<CaseOutcome> simulate_on_common_steps(std::span<const CaseSpec> specs,
                                                  const Heartbeat& heartbeat) {
    return run_batch<core::Lanes>(specs, heartbeat, true, nullptr);
}

} // namespace culm::run
