// SPDX-License-Identifier: BSD-3-Clause
#include "fit/solve/solution.hpp"

#include "core/error.hpp"
#include "fit/solve/residuals.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <Eigen/Core>
#include <ceres/ceres.h>
#include <fmt/core.h>

namespace culm::fit {

namespace {

/// Jᵀ W J and Jᵀ W r.
struct NormalEquations {
    Eigen::MatrixXd information;
    Eigen::VectorXd gradient;
};

NormalEquations normal_equations(const JointResiduals& residuals) {
    const auto count = static_cast<Eigen::Index>(residuals.parameter_count());
    NormalEquations sums{Eigen::MatrixXd::Zero(count, count), Eigen::VectorXd::Zero(count)};
    Eigen::VectorXd slope(count);
    for (std::size_t part = 0; part < residuals.parts().size(); ++part)
        for (const ReadingResiduals::Place& place : residuals.parts()[part].places()) {
            double residual = 0.0;
            if (!residuals.evaluate(part, place, &residual, slope.data()) || !slope.allFinite())
                continue;
            sums.information.selfadjointView<Eigen::Lower>().rankUpdate(slope);
            sums.gradient += residual * slope;
        }
    for (std::size_t k = 0; k < residuals.parameter_count(); ++k)
        if (residuals.is_error(k)) {
            const auto at = static_cast<Eigen::Index>(k);
            sums.information(at, at) += 1.0;
            sums.gradient(at) += residuals.internal()[k];
        }
    sums.information = sums.information.selfadjointView<Eigen::Lower>();
    return sums;
}

/// Can the parameter move against the gradient without crossing a bound?
bool can_move(const JointResiduals& residuals, std::size_t k, double gradient) {
    const double internal = residuals.internal()[k];
    const auto [lower, upper] = residuals.bounds(k);
    return gradient > 0.0 ? internal > lower : internal < upper;
}

/// Decrease of the sum of squares over the noise in one Gauss-Newton step from the prepared point,
/// gᵀ (Jᵀ J)⁻¹ g over the parameters that can move: those that are not fixed (`is_held`; missing
/// entries are false) and not at a bound that the step would cross. A step that a trust region
/// shortens promises less than this in directions that the readings hardly determine, and may end a
/// solution many standard errors away from the best one.
double remaining_gain(const JointResiduals& residuals, const std::vector<bool>& is_held) {
    // Half the decrease of χ² by one Gauss-Newton step is gᵀ H⁻¹ g/2. In the eigenvectors of the
    // scaled H it is a sum over directions, without those that the data do not determine.
    const NormalEquations sums = normal_equations(residuals);
    std::vector<Eigen::Index> moving;
    for (std::size_t k = 0; k < residuals.parameter_count(); ++k) {
        const auto at = static_cast<Eigen::Index>(k);
        const bool is_free = k >= is_held.size() || !is_held[k];
        if (is_free && sums.information(at, at) > 0.0 && can_move(residuals, k, sums.gradient(at)))
            moving.push_back(at);
    }
    if (moving.empty())
        return 0.0;
    const InformationDirections told = information_directions(sums.information(moving, moving));
    const Eigen::VectorXd gradient = sums.gradient(moving).cwiseQuotient(told.scale);
    double gain = 0.0;
    for (Eigen::Index k = 0; k < told.information.size(); ++k)
        if (told.is_known(k))
            gain += std::pow(told.directions.col(k).dot(gradient), 2) / told.information(k);
    return gain;
}

/// Convergence limit, in units of the χ² of one standard error of a parameter (so divided by the
/// reduced χ² of the solution): 0.05 nats of evidence are not worth a run. The point after the last
/// step is nearer to the minimum than that by the convergence of Gauss-Newton steps.
constexpr double final_improvement = 0.1;
/// A window that only leads to the next one needs less accuracy.
constexpr double passing_improvement = 5.0;
/// The integrator's choice of steps depends on the parameters, which adds noise of this size to the
/// sum. A step that fails by less has met the noise, not a wrong model.
constexpr double noise_of_runs = 0.2;
/// Consecutive failures: a region that is 2 million times narrower should contain a better point.
constexpr int most_vain_steps = 6;

/// In a wider region, parameters that the data hardly distinguish start with excessive steps.
constexpr double first_trust_region = 100.0;
/// Wide enough not to shorten steps near the end, where a narrow region ends a solution early: in a
/// valley whose floor has a millionth of its walls' curvature, shortened steps promise nothing.
constexpr double last_trust_region = 1e10;
constexpr int most_refinements = 3;

/// The cost function of one reading.
class ReadingCost : public ceres::CostFunction {
  public:
    ReadingCost(const JointResiduals& residuals, std::size_t part,
                const ReadingResiduals::Place& place)
        : residuals_(residuals), part_(part), place_(place) {
        set_num_residuals(1);
        mutable_parameter_block_sizes()->push_back(
            static_cast<std::int32_t>(residuals.parameter_count()));
    }
    bool Evaluate(const double* const*, double* residuals, double** jacobians) const override {
        return residuals_.evaluate(part_, place_, residuals,
                                   jacobians == nullptr ? nullptr : jacobians[0]);
    }

  private:
    const JointResiduals& residuals_;
    std::size_t part_;
    const ReadingResiduals::Place& place_;
};

/// The Gaussian constraint of an error term.
class ConstraintCost : public ceres::CostFunction {
  public:
    ConstraintCost(std::size_t parameter, std::size_t count) : parameter_(parameter) {
        set_num_residuals(1);
        mutable_parameter_block_sizes()->push_back(static_cast<std::int32_t>(count));
    }
    bool Evaluate(const double* const* parameters, double* residuals,
                  double** jacobians) const override {
        residuals[0] = parameters[0][parameter_];
        if (jacobians != nullptr && jacobians[0] != nullptr) {
            std::fill_n(jacobians[0], parameter_block_sizes().front(), 0.0);
            jacobians[0][parameter_] = 1.0;
        }
        return true;
    }

  private:
    std::size_t parameter_;
};

/// Ends the solution if a step promised or gained less than `improvement`, at the noise of the
/// runs, where Ceres would shorten its steps without success, and after many shortened steps.
/// Ceres's cost tolerance would discard the last point, which cost a run and is the best one.
class EnoughGained : public ceres::IterationCallback {
  public:
    EnoughGained(double readings, double improvement)
        : readings_(readings), improvement_(improvement) {}
    ceres::CallbackReturnType operator()(const ceres::IterationSummary& iteration) override {
        if (iteration.iteration == 0 || iteration.step_is_successful)
            vain_steps_ = 0;
        else if (++vain_steps_ == most_vain_steps)
            return ceres::SOLVER_TERMINATE_SUCCESSFULLY;
        if (iteration.iteration == 0 || !iteration.step_is_valid)
            return ceres::SOLVER_CONTINUE;
        // Decrease of χ² in units of the reduced χ² (cost is χ²/2): about the square of the step of
        // a parameter in standard errors.
        const double gain = iteration.cost_change / iteration.cost * readings_;
        const double promised = gain / iteration.relative_decrease;
        const bool is_noise =
            !iteration.step_is_successful && -gain < noise_of_runs && promised < noise_of_runs;
        // The gain of a whole step differs from its promise by about the gain that remains.
        const bool is_whole = iteration.trust_region_radius >= last_trust_region;
        const double left =
            is_whole ? std::abs(gain - promised) : std::numeric_limits<double>::infinity();
        return is_noise || std::min({std::abs(gain), std::abs(promised), left}) < improvement_
                   ? ceres::SOLVER_TERMINATE_SUCCESSFULLY
                   : ceres::SOLVER_CONTINUE;
    }

  private:
    double readings_;
    double improvement_;
    int vain_steps_ = 0;
};

void bound(const JointLayout& layout, const std::vector<bool>& is_held, ceres::Problem& problem,
           JointResiduals& residuals) {
    double* const block = residuals.internal();
    for (std::size_t k = 0; k < residuals.parameter_count(); ++k) {
        const auto [lower, upper] = residuals.bounds(k);
        problem.SetParameterLowerBound(block, static_cast<int>(k), lower);
        problem.SetParameterUpperBound(block, static_cast<int>(k), upper);
    }
    // Ceres rejects a manifold without a free direction.
    if (std::ranges::count(is_held, true) ==
        static_cast<std::ptrdiff_t>(residuals.parameter_count()))
        problem.SetParameterBlockConstant(block);
    else
        problem.SetManifold(block, new ValleySteps(residuals, layout, is_held));
}

ceres::Solver::Options solver_settings(int largest_iterations, double trust_region) {
    ceres::Solver::Options settings;
    settings.linear_solver_type = ceres::DENSE_QR;
    settings.max_num_iterations = largest_iterations;
    settings.initial_trust_region_radius = trust_region;
    // Steps are projected onto the bounds; a search along each would cost more runs than it saves.
    settings.max_num_line_search_step_size_iterations = 0;
    settings.parameter_tolerance = 1e-9;
    settings.gradient_tolerance = 1e-14;
    settings.function_tolerance = 0.0; // see EnoughGained
    settings.logging_type = ceres::SILENT;
    return settings;
}

bool has_converged(const ceres::Solver::Summary& summary) {
    return summary.termination_type == ceres::CONVERGENCE ||
           summary.termination_type == ceres::USER_SUCCESS;
}

/// Did shortened steps end the solution too early?
bool is_far_from_the_end(const ceres::Solver::Summary& summary, const std::vector<bool>& is_held,
                         double readings, JointResiduals& residuals) {
    if (!has_converged(summary))
        return false;
    residuals.PrepareForEvaluation(true, true);
    const double reduced = 2.0 * summary.final_cost / readings;
    return remaining_gain(residuals, is_held) > noise_of_runs * std::max(1.0, reduced);
}

JointSolution solution_of(JointResiduals& residuals) {
    residuals.PrepareForEvaluation(true, true);
    JointSolution solution;
    for (const ReadingResiduals& part : residuals.parts()) {
        solution.models.push_back(part.current_model());
        solution.predictions.push_back(part.prediction());
        solution.times.push_back(part.times());
        solution.runs.push_back(part.runs());
    }
    return solution;
}

/// The parameters that a solution for this purpose keeps. A few cycles of a lightly damped record
/// hardly determine the damping, which would follow any error of the model to its bound.
std::vector<bool> held_for(Purpose purpose, const JointLayout& layout, std::vector<bool> is_held) {
    if (purpose == Purpose::Final)
        return is_held;
    is_held.resize(layout.ids.size(), false);
    for (std::size_t k = 0; k < layout.ids.size(); ++k)
        if (layout.ids[k] == physics::bond_damping)
            is_held[k] = true;
    return is_held;
}

} // namespace

JointSolution solve(const JointProblem& problem, const std::vector<StemModel>& models,
                    const std::vector<double>& last_times, Purpose purpose) {
    const auto& [measurements, layout, noise, held, options] = problem;
    std::vector<ReadingResiduals> parts;
    std::size_t readings = 0;
    for (std::size_t m = 0; m < models.size(); ++m) {
        parts.emplace_back(models[m], measurements[m], noise[m], last_times[m], options.heartbeat);
        readings += parts.back().places().size();
    }
    if (readings == 0)
        throw core::NumericalError(
            core::FailureKind::FitFailed,
            fmt::format("no reading lies within the first {:.3g} s after time 0, where the fit "
                        "begins: time 0 is not the release",
                        std::ranges::max(last_times)));
    JointResiduals residuals(models, layout, std::move(parts));
    ceres::Problem::Options ownership;
    ownership.evaluation_callback = &residuals;
    ceres::Problem equations(ownership);
    for (std::size_t m = 0; m < models.size(); ++m)
        for (const ReadingResiduals::Place& place : residuals.parts()[m].places())
            equations.AddResidualBlock(new ReadingCost(residuals, m, place), nullptr,
                                       residuals.internal());
    for (std::size_t k = 0; k < residuals.parameter_count(); ++k)
        if (residuals.is_error(k))
            equations.AddResidualBlock(new ConstraintCost(k, residuals.parameter_count()), nullptr,
                                       residuals.internal());
    const std::vector<bool> is_held = held_for(purpose, layout, held);
    bound(layout, is_held, equations, residuals);

    const double improvement = purpose == Purpose::Final ? final_improvement : passing_improvement;
    const auto count = static_cast<double>(std::max<std::size_t>(readings, 1));
    EnoughGained enough_gained(count, improvement);
    const auto solved_within = [&](double trust_region) {
        ceres::Solver::Options settings =
            solver_settings(problem.options.largest_iterations, trust_region);
        settings.callbacks = {&enough_gained};
        ceres::Solver::Summary summary;
        ceres::Solve(settings, &equations, &summary);
        return summary;
    };
    if (double cost = 0.0;
        purpose == Purpose::Final && !options.is_first_guess &&
        equations.Evaluate({}, &cost, nullptr, nullptr, nullptr) &&
        remaining_gain(residuals, held) < final_improvement * std::max(1.0, 2.0 * cost / count)) {
        JointSolution solution = solution_of(residuals); // the start is a solution
        solution.cost = cost;
        solution.has_converged = true;
        return solution;
    }
    ceres::Solver::Summary summary = solved_within(first_trust_region);
    const bool is_solved = has_converged(summary);
    for (int again = 0; again < most_refinements && purpose == Purpose::Final &&
                        is_far_from_the_end(summary, held, count, residuals);
         ++again) {
        summary = solved_within(last_trust_region);
        if (!(summary.final_cost < summary.initial_cost))
            break; // the gain that the derivatives promise does not exist
    }
    JointSolution solution = solution_of(residuals);
    solution.cost = summary.final_cost;
    solution.has_converged = is_solved;
    solution.message = summary.message;
    return solution;
}

} // namespace culm::fit
