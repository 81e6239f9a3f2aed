// SPDX-License-Identifier: BSD-3-Clause
#include "fit/start/coarse_chain.hpp"

#include "core/error.hpp"
#include "fit/model/prediction.hpp"
#include "fit/model/reading_noise.hpp"
#include "run/modes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <Eigen/QR>

namespace culm::fit {
namespace {

constexpr std::array numbers_of_spheres{14, 20, 28};
constexpr double likely_error = 1.0 / 3.0; ///< of y₂ − y₁
constexpr double small_error = 0.2;        ///< of the noise

/// A chain with other bonds and the same first mode, without free parameters.
StemModel divided(StemModel model, int spheres) {
    const auto modes = run::chain_modes(model.spec, 1);
    model.spec = with_spheres(std::move(model.spec), spheres);
    if (!modes.empty())
        keep_first_mode(modes.front(), model);
    return model;
}

/// Rms over the readings of the error that remains, over the noise.
double remaining_error(const StemModel& coarse, const measure::Measurement& recording,
                       const std::vector<double>& noise, const run::Heartbeat& heartbeat) {
    StemModel fine = divided(coarse, 2 * coarse.spec.stem.sphere_count - 1);
    fine.parameters.clear();
    fine.release_time_bound = 0.0;
    const ChainPrediction one = predict_readings(coarse, recording.times, heartbeat);
    const ChainPrediction two = predict_readings(fine, recording.times, heartbeat);
    const auto count = static_cast<Eigen::Index>(one.readings.size());
    const auto parameters = static_cast<Eigen::Index>(one.parameters);
    Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(count, parameters);
    Eigen::VectorXd error = Eigen::VectorXd::Zero(count);
    for (Eigen::Index k = 0; k < count; ++k) {
        const auto at = static_cast<std::size_t>(k);
        const double scale = 1.0 / noise[at % one.rows];
        const Eigen::Map<const Eigen::VectorXd> slope(one.jacobian.data() + at * one.parameters,
                                                      parameters);
        const double change = likely_error * (two.readings[at] - one.readings[at]) * scale;
        if (!std::isfinite(change) || !slope.allFinite())
            continue;
        error[k] = change;
        columns.row(k) = scale * slope.transpose();
    }
    columns.colwise().normalize(); // their units differ by orders of magnitude
    const Eigen::VectorXd left = error - columns * columns.colPivHouseholderQr().solve(error);
    return std::sqrt(left.squaredNorm() / static_cast<double>(std::max<Eigen::Index>(count, 1)));
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
