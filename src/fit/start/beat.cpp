// SPDX-License-Identifier: BSD-3-Clause
#include "fit/start/beat.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include <ceres/ceres.h>

namespace culm::fit {

namespace {

constexpr std::array<double, 6> first_splits{0.01, 0.03, 0.07, 0.12, 0.2, 0.35};
constexpr std::array<double, 4> first_angles{20.0, 40.0, 55.0, 75.0}; // degrees
/// ε = 0.8: one principal stiffness is (1 + 0.4)/(1 − 0.4) = 2.3 times the other.
constexpr double largest_split = 0.8;
constexpr double needed_beat_gain = 0.1; ///< of the fit's residual sum of squares
constexpr double same_split = 0.05;      ///< relative: two solutions are the same
constexpr int most_iterations = 40;
constexpr std::size_t fewest_beat_frames = 10;

/// The swing in its shape at the release, relative to the fitted chain's swing at the release.
struct SwingHistory {
    std::vector<double> times;
    std::vector<double> measured;
    std::vector<double> modelled;
};

SwingHistory swing_history(const RecordingFit& fit) {
    const std::size_t rows = fit.prediction.rows;
    const auto after = std::ranges::lower_bound(fit.times, 0.0);
    const auto first = static_cast<std::size_t>(after - fit.times.begin());
    SwingHistory history;
    for (std::size_t i = first; i < fit.times.size(); ++i) {
        double squares = 0.0;
        double modelled = 0.0;
        double missed = 0.0;
        for (std::size_t j = 0; j < rows; ++j) {
            const double shape = fit.prediction.readings[first * rows + j];
            const double residual = fit.residuals[i * rows + j];
            if (std::isnan(residual) || std::isnan(shape))
                continue;
            squares += shape * shape;
            modelled += shape * fit.prediction.readings[i * rows + j];
            missed += shape * residual;
        }
        if (!(squares > 0.0))
            continue;
        // Projections onto the shape s: Σ s y/Σ s² of the model and of model + residual.
        history.times.push_back(fit.times[i]);
        history.modelled.push_back(modelled / squares);
        history.measured.push_back((modelled + missed) / squares);
    }
    return history;
}

/// Residuals of the beat. Parameters: ω, δ, ε, α and A, each over its scale.
/// A stem that is pulled at an angle α to its principal planes swings in both: seen from the side,
/// x = A e^(−δt) [cos²α cos ω₁t + sin²α cos ω₂t] with ω₁,₂² = ω² (1 ± ε/2). Fitting it to the swing
/// is a problem of five numbers, hundreds of times cheaper than a fit of the spatial chain.
struct BeatCost {
    double time;
    double measured;
    double angular_frequency;
    double decay_rate;

    template <class T>
    bool operator()(const T* const numbers, T* missed) const {
        const T squared = numbers[0] * numbers[0] * (angular_frequency * angular_frequency);
        const T stiff = sqrt(squared * (1.0 + 0.5 * numbers[2]));
        const T soft = sqrt(squared * (1.0 - 0.5 * numbers[2]));
        const T along = cos(numbers[3]) * cos(numbers[3]);
        *missed = numbers[4] * exp(-numbers[1] * decay_rate * time) *
                      (along * cos(stiff * time) + (1.0 - along) * cos(soft * time)) -
                  measured;
        return true;
    }
};

struct Candidate {
    std::array<double, 5> numbers{};
    double cost = 0.0;
};

Candidate solved(const SwingHistory& history, double angular_frequency, double decay_rate,
                 double split, double angle) {
    // ω is that of the fit, which follows the stronger of the two frequencies.
    const double along = std::pow(std::cos(angle), 2);
    const double stronger = along > 0.5 ? 1.0 + 0.5 * split : 1.0 - 0.5 * split;
    Candidate candidate{{1.0 / std::sqrt(stronger), 1.0, split, angle, 1.0}, 0.0};
    ceres::Problem problem;
    for (std::size_t i = 0; i < history.times.size(); ++i)
        problem.AddResidualBlock(
            new ceres::AutoDiffCostFunction<BeatCost, 1, 5>(
                new BeatCost{history.times[i], history.measured[i], angular_frequency, decay_rate}),
            nullptr, candidate.numbers.data());
    const std::array<std::pair<double, double>, 5> bounds{{{0.7, 1.4},
                                                           {0.05, 5.0},
                                                           {1e-3, largest_split},
                                                           {0.05, 0.5 * std::numbers::pi - 0.05},
                                                           {0.3, 3.0}}};
    for (std::size_t k = 0; k < bounds.size(); ++k) {
        problem.SetParameterLowerBound(candidate.numbers.data(), static_cast<int>(k),
                                       bounds[k].first);
        problem.SetParameterUpperBound(candidate.numbers.data(), static_cast<int>(k),
                                       bounds[k].second);
    }
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::DENSE_QR;
    options.max_num_iterations = most_iterations;
    options.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    candidate.cost = 2.0 * summary.final_cost;
    return candidate;
}

} // namespace

std::vector<Beat> recorded_beats(const RecordingFit& fit, double angular_frequency,
                                 double decay_rate, std::size_t count) {
    const SwingHistory history = swing_history(fit);
    if (history.times.size() < fewest_beat_frames) // or held straight: no release shape
        return {};
    double left = 0.0;
    for (std::size_t i = 0; i < history.times.size(); ++i)
        left += std::pow(history.measured[i] - history.modelled[i], 2);
    std::vector<Candidate> candidates;
    for (const double split : first_splits)
        for (const double angle : first_angles)
            candidates.push_back(solved(history, angular_frequency, decay_rate, split,
                                        angle * std::numbers::pi / 180.0));
    std::ranges::stable_sort(candidates, {}, &Candidate::cost);
    std::vector<Beat> beats;
    for (const Candidate& candidate : candidates) {
        if (!(candidate.cost < (1.0 - needed_beat_gain) * left) || beats.size() == count)
            break;
        const auto [frequency, decay, split, angle, amplitude] = candidate.numbers;
        const bool is_new =
            std::ranges::none_of(beats, [&, own = split, at = angle](const Beat& beat) {
                return std::abs(beat.split / own - 1.0) < same_split &&
                       std::abs(beat.angle - at) < same_split;
            });
        if (is_new)
            beats.push_back(
                {frequency * angular_frequency, decay * decay_rate, split, angle, amplitude});
    }
    return beats;
}

} // namespace culm::fit
