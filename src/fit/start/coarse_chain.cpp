// SPDX-License-Identifier: BSD-3-Clause
#include "fit/start/coarse_chain.hpp"

#include "core/error.hpp"
#include "fit/chain/baseline_model.hpp"
#include "fit/chain/prediction.hpp"
#include "fit/linear/scaled_solve.hpp"
#include "fit/linear/weighted_system.hpp"
#include "fit/noise/reading_noise.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace culm::fit {
namespace {

constexpr std::array numbers_of_spheres{14, 20, 28};
constexpr double likely_error = 1.0 / 3.0; ///< of y₂ − y₁
constexpr double small_error = 0.2;        ///< of the noise

/// Rms over the readings of the error that remains, over the noise.
double remaining_error(const StemModel& coarse, const measure::Measurement& recording,
                       const std::vector<double>& noise, const run::Heartbeat& heartbeat) {
    StemModel fine = with_spheres(coarse, 2 * coarse.spec.stem.sphere_count - 1);
    fine.parameters.clear();
    fine.release_time_bound = 0.0;
    ObservedRecording finer(recording);
    finer.deflections = predict_readings(fine, recording.times, heartbeat).readings;
    const ChainPrediction own = predict_readings(coarse, recording.times, heartbeat);
    const std::vector<ErrorTerm> none;
    const SystemPart part{coarse, finer, own, noise, none};
    const WeightedSystem system =
        weighted_system(joint_layout({&coarse, 1}, {&finer, 1}), {&part, 1});
    const Eigen::VectorXd left = Projector(system.jacobian).remainder(system.residual);
    return likely_error * std::sqrt(left.squaredNorm() / std::max(1.0, double(left.size())));
}

bool suffices(int spheres, std::span<const measure::Measurement> recordings,
              const FitOptions& options) {
    ChainOptions chain = options.chain;
    chain.spheres = spheres;
    for (const measure::Measurement& recording : recordings) {
        const std::vector<double> noise = reading_noise(ObservedRecording(recording)).by_row;
        if (noise.empty())
            return false;
        try {
            if (!(remaining_error(baseline_model(recording, chain), recording, noise,
                                  options.heartbeat) < small_error))
                return false;
        } catch (const core::NumericalError&) {
            return false;
        }
    }
    return true;
}

} // namespace

int coarsest_chain(std::span<const measure::Measurement> recordings, const FitOptions& options) {
    int stated = std::numeric_limits<int>::max();
    for (const measure::Measurement& recording : recordings)
        stated = std::min(stated, chain_of(recording, options.chain).spec.stem.sphere_count);
    for (const int spheres : numbers_of_spheres)
        if (spheres < stated && suffices(spheres, recordings, options))
            return spheres;
    return stated;
}

} // namespace culm::fit
