// SPDX-License-Identifier: BSD-3-Clause
#include "core/lanes.hpp"
#include "integrate/velocity_verlet.hpp"
#include "physics/energy.hpp"
#include "run/case_lanes.hpp"
#include "run/case_model.hpp"
#include "run/recorder.hpp"
#include "run/simulate.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>

#include <fmt/core.h>

namespace culm::run {
namespace {

using core::Lanes;

/// The batch while it runs.
template <int Dim>
class LaneBatch {
  public:
    explicit LaneBatch(std::span<const CaseSpec> specs)
        : specs_(specs), released_(released_lanes<Dim>(specs)), failures_(released_.failures) {
        for (const CaseSpec& spec : specs)
            recorders_.emplace_back(spec);
    }

    [[nodiscard]] std::vector<CaseOutcome> run(const Heartbeat& heartbeat) {
        const auto start = std::chrono::steady_clock::now();
        const CaseSpec& first = specs_.front();
        const physics::Chain<Dim, Lanes> chain(first.stem.sphere_count, released_.model, first.law);
        integrate::VelocityVerlet<Dim, Lanes> verlet(chain, released_.state,
                                                     first.integrator.timestep);
        const std::int64_t steps_per_sample =
            std::llround(first.sample_interval / first.integrator.timestep);
        std::size_t samples = 0;
        // A rolling shutter reads beyond the end of the record: the lanes run until the last one
        // ends.
        for (const Recorder& recorder : recorders_)
            samples = std::max(samples, recorder.recorded_samples());
        // A moving clamp or a formula of time does work on the stem, so it may gain
        // energy. An instability still exceeds any bound.
        allowed_gain_ = chain.model().depends_on_time() ? 1e3 : unstable_energy_gain;

        released_energy_ = stored_energy(chain, verlet);
        record(0, verlet);
        const auto has_failed = [](const auto& failure) { return failure.has_value(); };
        for (std::size_t sample = 1;
             sample < samples && !std::ranges::all_of(failures_, has_failed); ++sample) {
            for (std::int64_t done = 0; done < steps_per_sample; done += steps_per_beat) {
                verlet.advance(std::min(steps_per_beat, steps_per_sample - done));
                if (heartbeat && !heartbeat())
                    throw Abandoned{};
            }
            check_stability(stored_energy(chain, verlet), sample);
            record(sample, verlet);
        }
        const double wall =
            std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        return outcomes(static_cast<std::int64_t>(samples - 1) * steps_per_sample, wall);
    }

  private:
    void record(std::size_t sample, const integrate::VelocityVerlet<Dim, Lanes>& verlet) {
        const int tip = specs_.front().stem.sphere_count - 1;
        for (std::size_t lane = 0; lane < specs_.size(); ++lane) {
            if (failures_[lane] || sample >= recorders_[lane].recorded_samples())
                continue;
            positions_.clear();
            for (int i = recorders_[lane].first_watched_sphere(); i <= tip; ++i)
                for (int d = 0; d < Dim; ++d)
                    positions_.push_back(verlet.position(i)[d][lane]);
            recorders_[lane].record(sample, {positions_, {}, {}});
        }
    }

    /// Stored energy above that of the straight chain at rest, J.
    [[nodiscard]] static Lanes stored_energy(const physics::Chain<Dim, Lanes>& chain,
                                             const integrate::VelocityVerlet<Dim, Lanes>& verlet) {
        return physics::stored_energy(chain, verlet.state().data()) -
               physics::stored_energy(chain, chain.straight_state().data());
    }

    /// Fails the lanes whose energy has grown or is not a number.
    void check_stability(const Lanes& energy, std::size_t sample) {
        for (std::size_t lane = 0; lane < specs_.size(); ++lane) {
            // The comparison is written so that NaN fails: no comparison with NaN is true.
            if (failures_[lane] ||
                energy[lane] <= (1.0 + allowed_gain_) * std::abs(released_energy_[lane]))
                continue;
            const CaseSpec& spec = specs_[lane];
            failures_[lane] = CaseFailure{
                core::FailureKind::Instability,
                fmt::format("the motion gained energy ({:.3g} J at t = {:.6g} s, released with "
                            "{:.3g} J): the time step of {:.4g} s is above the largest stable one, "
                            "{:.4g} s",
                            double(energy[lane]),
                            static_cast<double>(sample) * spec.sample_interval,
                            double(released_energy_[lane]), spec.integrator.timestep,
                            largest_stable_timestep(spec))};
        }
    }

    [[nodiscard]] std::vector<CaseOutcome> outcomes(std::int64_t steps, double wall_seconds) {
        std::vector<CaseOutcome> out;
        for (std::size_t lane = 0; lane < specs_.size(); ++lane) {
            if (failures_[lane]) {
                out.emplace_back(*failures_[lane]);
                continue;
            }
            recorders_[lane].finish();
            CaseResult& result = recorders_[lane].result();
            result.work.steps = steps;
            result.work.rhs_evaluations = steps + 1;
            result.wall_seconds = wall_seconds / static_cast<double>(specs_.size());
            out.emplace_back(std::move(result));
        }
        return out;
    }

    std::span<const CaseSpec> specs_;
    ReleasedLanes released_;
    std::vector<std::optional<CaseFailure>> failures_;
    std::vector<Recorder> recorders_;
    std::vector<double> positions_;
    Lanes released_energy_ = 0.0;
    double allowed_gain_ = unstable_energy_gain;
};

} // namespace

std::vector<CaseOutcome> simulate_explicit_lanes(std::span<const CaseSpec> specs,
                                                 const Heartbeat& heartbeat) {
    return dimensions_of(specs.front()) == 2 ? LaneBatch<2>(specs).run(heartbeat)
                                             : LaneBatch<3>(specs).run(heartbeat);
}

} // namespace culm::run
