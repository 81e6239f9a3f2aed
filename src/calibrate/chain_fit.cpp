// SPDX-License-Identifier: BSD-3-Clause
#include "calibrate/chain_fit.hpp"

#include "calibrate/fit_statistics.hpp"
#include "calibrate/reading_residuals.hpp"
#include "core/error.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>

#include <ceres/ceres.h>
#include <fmt/core.h>
#include <glog/logging.h>

namespace culm::calibrate {
namespace {

constexpr double robust_width = 2.0;                           // standard deviations
constexpr std::array<double, 3> first_windows{2.0, 5.0, 12.0}; // cycles
/// Factors on Y about its start. Within two cycles a frequency that is wrong by a quarter still
/// leads downhill; 6 % of Y is 3 % of it.
constexpr std::array<double, 3> first_moduli{1.0, 0.94, 1.06};
/// A fit that leaves less of the motion than this has found it.
constexpr double small_remainder = 0.2;

/// The end of a solution, in units of the χ² that one standard error of a parameter makes (so
/// divided by the reduced χ² of the solution): an improvement below this is not worth a run.
constexpr double final_improvement = 0.005;
/// A window that only leads to the next one need not be as good.
constexpr double passing_improvement = 5.0;
/// The integrator's choice of steps follows the parameters, which leaves that much noise on the
/// sum; a step that fails by no more than this has met the noise and not a wrong model.
constexpr double noise_of_runs = 0.2;

/// One reading as Ceres sees it.
class ReadingCost : public ceres::CostFunction {
  public:
    ReadingCost(const ReadingResiduals& residuals, const ReadingResiduals::Place& place)
        : residuals_(residuals), place_(place) {
        set_num_residuals(1);
        mutable_parameter_block_sizes()->push_back(
            static_cast<std::int32_t>(residuals.parameter_count()));
    }
    bool Evaluate(const double* const*, double* residuals, double** jacobians) const override {
        return residuals_.evaluate(place_, residuals,
                                   jacobians == nullptr ? nullptr : jacobians[0]);
    }

  private:
    const ReadingResiduals& residuals_;
    const ReadingResiduals::Place& place_;
};

/// Ends the solution where a step promised less than `improvement`, and at the noise of the runs,
/// where Ceres would shorten its steps in vain.
class EnoughGained : public ceres::IterationCallback {
  public:
    EnoughGained(double readings, double improvement)
        : readings_(readings), improvement_(improvement) {}
    ceres::CallbackReturnType operator()(const ceres::IterationSummary& iteration) override {
        if (iteration.iteration == 0 || !iteration.step_is_valid)
            return ceres::SOLVER_CONTINUE;
        const double gain = iteration.cost_change / iteration.cost * readings_;
        const double promised = gain / iteration.relative_decrease;
        const bool is_noise = !iteration.step_is_successful && -gain < noise_of_runs;
        return is_noise || std::abs(promised) < improvement_ ? ceres::SOLVER_TERMINATE_SUCCESSFULLY
                                                             : ceres::SOLVER_CONTINUE;
    }

  private:
    double readings_;
    double improvement_;
};

/// A least-squares solution over one window.
struct Solution {
    StemModel model;
    ChainPrediction prediction;
    std::vector<double> times;
    double cost = std::numeric_limits<double>::infinity(); ///< as Ceres minimises it
    int runs = 0;
    bool has_converged = false;
    std::string message;
};

class Fitter {
  public:
    Fitter(const measure::Measurement& measurement, const ChainFitOptions& options,
           std::vector<double> noise, std::vector<bool> is_held)
        : measurement_(measurement), options_(options), noise_(std::move(noise)),
          is_held_(std::move(is_held)) {}

    /// Frames up to `last_time`, from the model's values.
    [[nodiscard]] Solution solve(const StemModel& model, double last_time,
                                 double improvement = final_improvement) const {
        ReadingResiduals residuals(model, measurement_, noise_, last_time, options_.heartbeat);
        ceres::Problem::Options ownership;
        ownership.evaluation_callback = &residuals;
        ownership.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
        ceres::Problem problem(ownership);
        ceres::HuberLoss huber(robust_width);
        for (const ReadingResiduals::Place& place : residuals.places())
            problem.AddResidualBlock(new ReadingCost(residuals, place),
                                     options_.is_robust ? &huber : nullptr, residuals.internal());
        bound(problem, residuals);

        const auto count = static_cast<double>(std::max<std::size_t>(residuals.places().size(), 1));
        EnoughGained enough_gained(count, improvement);
        ceres::Solver::Options settings;
        settings.linear_solver_type = ceres::DENSE_QR;
        settings.max_num_iterations = options_.largest_iterations;
        // Parameters that the data hardly tell apart would otherwise begin with wild steps.
        settings.initial_trust_region_radius = 100.0;
        settings.function_tolerance = improvement / count;
        settings.callbacks = {&enough_gained};
        // Steps are projected onto the bounds; a search along each would cost more runs than it
        // saves.
        settings.max_num_line_search_step_size_iterations = 0;
        settings.parameter_tolerance = 1e-9;
        settings.gradient_tolerance = 1e-14;
        settings.logging_type = ceres::SILENT;
        ceres::Solver::Summary summary;
        FLAGS_minloglevel = google::GLOG_FATAL; // what fails comes back as a reason
        ceres::Solve(settings, &problem, &summary);
        Solution solution;
        solution.model = residuals.current_model();
        solution.prediction = residuals.prediction();
        solution.times = residuals.times();
        solution.runs = residuals.runs();
        solution.cost = summary.final_cost;
        solution.has_converged = summary.termination_type == ceres::CONVERGENCE ||
                                 summary.termination_type == ceres::USER_SUCCESS;
        solution.message = summary.message;
        return solution;
    }

  private:
    void bound(ceres::Problem& problem, ReadingResiduals& residuals) const {
        double* const block = residuals.internal();
        std::vector<int> held;
        for (std::size_t k = 0; k < residuals.parameter_count(); ++k) {
            problem.SetParameterLowerBound(block, static_cast<int>(k), residuals.lower(k));
            problem.SetParameterUpperBound(block, static_cast<int>(k), residuals.upper(k));
            if (k < is_held_.size() && is_held_[k])
                held.push_back(static_cast<int>(k));
        }
        if (held.size() == residuals.parameter_count())
            problem.SetParameterBlockConstant(block);
        else if (!held.empty())
            problem.SetManifold(block, new ceres::SubsetManifold(
                                           static_cast<int>(residuals.parameter_count()), held));
    }

    const measure::Measurement& measurement_;
    const ChainFitOptions& options_;
    std::vector<double> noise_;
    std::vector<bool> is_held_;
};

/// Share of the motion that a solution leaves: rms residual over rms reading after the release.
double remainder(const Solution& solution, const measure::Measurement& measurement) {
    double left = 0.0;
    double all = 0.0;
    const std::size_t rows = measurement.heights.size();
    for (std::size_t i = 0; i < solution.times.size(); ++i)
        for (std::size_t j = 0; j < rows && solution.times[i] >= 0.0; ++j) {
            const double reading = measurement.deflection(i, j);
            const double predicted = solution.prediction.readings[i * rows + j];
            if (std::isnan(reading) || std::isnan(predicted))
                continue;
            left += (reading - predicted) * (reading - predicted);
            all += reading * reading;
        }
    return all > 0.0 ? std::sqrt(left / all) : 1.0;
}

/// The growing window, from one modulus.
Solution grow(const Fitter& fitter, StemModel model, double last_time) {
    int runs = 0;
    const double period = 1.0 / beam_frequency(model.spec);
    for (const double cycles : first_windows) {
        if (cycles * period >= last_time)
            break;
        Solution part = fitter.solve(model, cycles * period, passing_improvement);
        runs += part.runs;
        model = std::move(part.model);
    }
    Solution solution = fitter.solve(model, last_time);
    solution.runs += runs;
    return solution;
}

/// The best of several starts; the others are tried only if the first does not find the motion.
Solution search(const Fitter& fitter, const StemModel& model,
                const measure::Measurement& measurement, double last_time) {
    Solution best;
    int runs = 0;
    std::string reason;
    for (const double factor : first_moduli) {
        StemModel start = model;
        start.spec.stem.bond_youngs_modulus *= factor;
        try {
            Solution solution = grow(fitter, std::move(start), last_time);
            runs += solution.runs;
            if (solution.cost < best.cost)
                best = std::move(solution);
        } catch (const core::NumericalError& error) {
            reason = error.what();
        }
        if (std::isfinite(best.cost) && remainder(best, measurement) < small_remainder)
            break;
    }
    if (!std::isfinite(best.cost))
        throw core::NumericalError(core::FailureKind::FitFailed, reason);
    best.runs = runs;
    return best;
}

ChainFit fit(const StemModel& model, const measure::Measurement& measurement,
             const ChainFitOptions& options, const std::vector<bool>& is_held,
             bool is_first_guess) {
    ReadingNoise noise = reading_noise(measurement);
    const bool is_noise_known = !noise.by_row.empty();
    if (!is_noise_known)
        noise = {std::vector<double>(measurement.heights.size(), 1e-3), "residuals"};
    const double last_time = std::min(
        options.window.value_or(std::numeric_limits<double>::infinity()), measurement.times.back());
    const Fitter fitter(measurement, options, noise.by_row, is_held);
    Solution solution = is_first_guess ? search(fitter, model, measurement, last_time)
                                       : fitter.solve(model, last_time);
    ChainFit result;
    result.model = std::move(solution.model);
    result.prediction = std::move(solution.prediction);
    result.times = std::move(solution.times);
    result.noise = std::move(noise.by_row);
    result.noise_source = std::move(noise.source);
    result.is_noise_known = is_noise_known;
    result.runs = solution.runs;
    result.has_converged = solution.has_converged;
    if (!solution.has_converged)
        result.reason = fmt::format("not converged: {}", solution.message);
    add_statistics(measurement, is_held, result);
    return result;
}

} // namespace

const FittedParameter* ChainFit::find(const std::string& name) const {
    const auto found = std::ranges::find(parameters, name, &FittedParameter::name);
    return found == parameters.end() ? nullptr : &*found;
}

ChainFit fit_chain(const StemModel& model, const measure::Measurement& measurement,
                   const ChainFitOptions& options) {
    return fit(model, measurement, options, std::vector<bool>(model.free_count(), false),
               options.is_first_guess);
}

ChainFit fit_chain_with_held(const StemModel& model, const measure::Measurement& measurement,
                             const std::vector<bool>& is_held, const ChainFitOptions& options) {
    return fit(model, measurement, options, is_held, false);
}

StemModel started_from(StemModel model, const ChainFit& fit) {
    for (const FreeParameter& parameter : model.parameters)
        if (const FittedParameter* found = fit.find(parameter.access.name))
            parameter.access.set(model.spec, found->value);
    model.release_time = fit.model.release_time;
    return model;
}

} // namespace culm::calibrate
