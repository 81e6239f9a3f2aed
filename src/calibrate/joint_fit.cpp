// SPDX-License-Identifier: BSD-3-Clause
#include "calibrate/joint_fit.hpp"

#include "calibrate/fit_statistics.hpp"
#include "calibrate/joint_solution.hpp"
#include "core/error.hpp"
#include "run/modes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <fmt/core.h>

namespace culm::calibrate {
namespace {

constexpr std::array<double, 3> first_windows{2.0, 5.0, 12.0}; // cycles
/// Factors on Y about its start. Within two cycles a frequency that is wrong by a quarter still
/// leads downhill; 6 % of Y is 3 % of it.
constexpr std::array<double, 3> first_moduli{1.0, 0.94, 1.06};
/// A fit that leaves less of the motion than this has found it.
constexpr double small_remainder = 0.2;

/// Of recordings whose noise is not known, until their residuals tell it.
constexpr double provisional_noise = 1e-3; // m

/// Share of the motion that a solution leaves: rms residual over rms reading after the release.
double remainder(const JointSolution& solution,
                 std::span<const measure::Measurement> measurements) {
    double left = 0.0;
    double all = 0.0;
    for (std::size_t m = 0; m < measurements.size(); ++m) {
        const std::size_t rows = measurements[m].heights.size();
        for (std::size_t i = 0; i < solution.times[m].size(); ++i)
            for (std::size_t j = 0; j < rows && solution.times[m][i] >= 0.0; ++j) {
                const double reading = measurements[m].deflection(i, j);
                const double predicted = solution.predictions[m].readings[i * rows + j];
                if (std::isnan(reading) || std::isnan(predicted))
                    continue;
                left += (reading - predicted) * (reading - predicted);
                all += reading * reading;
            }
    }
    return all > 0.0 ? std::sqrt(left / all) : 1.0;
}

void add_runs(const std::vector<int>& runs, std::vector<int>& sum) {
    sum.resize(runs.size(), 0);
    for (std::size_t m = 0; m < runs.size(); ++m)
        sum[m] += runs[m];
}

/// The growing window, from one modulus.
JointSolution grow(const JointProblem& problem, std::vector<StemModel> models,
                   const std::vector<double>& last_times) {
    std::vector<int> runs;
    std::vector<double> periods;
    for (const StemModel& model : models)
        periods.push_back(1.0 / natural_frequency(model.spec));
    for (const double cycles : first_windows) {
        std::vector<double> window;
        for (std::size_t m = 0; m < models.size(); ++m)
            window.push_back(std::min(cycles * periods[m], last_times[m]));
        if (window == last_times)
            break;
        JointSolution part = problem.solve(models, window, Purpose::Passing);
        add_runs(part.runs, runs);
        models = std::move(part.models);
    }
    JointSolution solution = problem.solve(models, last_times, Purpose::Final);
    add_runs(runs, solution.runs);
    return solution;
}

/// The best of several starts; the others are tried only if the first does not find the motion.
JointSolution search(const JointProblem& problem, const std::vector<StemModel>& models,
                     std::span<const measure::Measurement> measurements,
                     const std::vector<double>& last_times) {
    JointSolution best;
    std::vector<int> runs;
    std::string reason;
    for (const double factor : first_moduli) {
        std::vector<StemModel> start = models;
        for (StemModel& model : start)
            model.spec.stem.bond_youngs_modulus *= factor;
        try {
            JointSolution solution = grow(problem, std::move(start), last_times);
            add_runs(solution.runs, runs);
            if (solution.cost < best.cost)
                best = std::move(solution);
        } catch (const core::NumericalError& error) {
            reason = error.what();
        }
        if (std::isfinite(best.cost) && remainder(best, measurements) < small_remainder)
            break;
    }
    if (!std::isfinite(best.cost))
        throw core::NumericalError(core::FailureKind::FitFailed, reason);
    best.runs = runs;
    return best;
}

/// What the solution of each recording is weighted by.
std::vector<ReadingNoise> noises_of(std::span<const measure::Measurement> measurements,
                                    const JointOptions& options) {
    std::vector<ReadingNoise> noises;
    for (std::size_t m = 0; m < measurements.size(); ++m) {
        noises.push_back(reading_noise(measurements[m]));
        if (!noises.back().by_row.empty())
            continue;
        noises.back() = {m < options.weights.size()
                             ? options.weights[m]
                             : std::vector(measurements[m].heights.size(), provisional_noise),
                         "residuals"};
    }
    return noises;
}

ChainFit part_of(JointSolution& solution, std::size_t m, ReadingNoise noise, bool is_noise_known) {
    ChainFit part;
    part.model = std::move(solution.models[m]);
    part.prediction = std::move(solution.predictions[m]);
    part.times = std::move(solution.times[m]);
    part.noise = std::move(noise.by_row);
    part.noise_source = std::move(noise.source);
    part.is_noise_known = is_noise_known;
    part.runs = solution.runs[m];
    part.has_converged = solution.has_converged;
    if (!solution.has_converged)
        part.reason = fmt::format("not converged: {}", solution.message);
    return part;
}

} // namespace

JointFit fit_jointly(std::span<const StemModel> models,
                     std::span<const measure::Measurement> measurements,
                     const JointOptions& options) {
    const JointLayout layout = joint_layout(models, measurements, options.belongs_to_recording);
    const std::vector<StemModel> starts =
        reconciled(std::vector(models.begin(), models.end()), layout);
    std::vector<ReadingNoise> noises = noises_of(measurements, options);
    std::vector<std::vector<double>> weights;
    std::vector<double> last_times;
    for (std::size_t m = 0; m < measurements.size(); ++m) {
        weights.push_back(noises[m].by_row);
        last_times.push_back(
            std::min(options.chain.window.value_or(std::numeric_limits<double>::infinity()),
                     measurements[m].times.back()));
    }
    std::vector<bool> is_held = options.is_held;
    is_held.resize(layout.names.size(), false);
    const JointProblem problem(measurements, layout, weights, is_held, options.chain);
    JointSolution solution = options.chain.is_first_guess
                                 ? search(problem, starts, measurements, last_times)
                                 : problem.solve(starts, last_times, Purpose::Final);
    JointFit fit;
    fit.has_converged = solution.has_converged;
    if (solution.is_cut_short)
        fit.out_of_reach = options.chain.wanted_chi_squared;
    if (!solution.has_converged)
        fit.reason = fmt::format("not converged: {}", solution.message);
    for (std::size_t m = 0; m < measurements.size(); ++m) {
        fit.runs += solution.runs[m];
        const bool is_known = noises[m].source != "residuals";
        fit.parts.push_back(part_of(solution, m, std::move(noises[m]), is_known));
    }
    add_statistics(measurements, layout, is_held, fit);
    return fit;
}

} // namespace culm::calibrate
