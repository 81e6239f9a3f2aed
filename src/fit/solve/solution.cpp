// SPDX-License-Identifier: BSD-3-Clause
#include "fit/solve/solution.hpp"

#include "core/error.hpp"
#include "fit/linear/scaled_solve.hpp"
#include "run/modes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <tuple>
#include <utility>

#include <fmt/core.h>

namespace culm::fit {
namespace {

/// Convergence limit, in units of the χ² of one standard error of a parameter. The point after the
/// last step is nearer to the minimum than that by the convergence of Gauss-Newton steps.
constexpr double improvement = 0.1;
constexpr double noise_of_runs = 0.2;
constexpr double largest_excess = 10.0; ///< of χ² at a start over that at the safe one
/// Levenberg's, over the diagonal of the information; side by side.
constexpr std::array dampings{1e-6, 1e-4, 1e-3, 1e-2};
constexpr std::array curved_shares{0.5, 1.0, 2.0, 4.0}; ///< of a damped step, along its curvature
constexpr double more_damping = 1e4;                    ///< after a vain trial
constexpr double rough_gain = 0.5; ///< of the promise; a lower gain is that of a curved valley
/// A valley in which steps gain less than this share of their promise, and less than one standard
/// error of a parameter changes, leads nowhere.
constexpr double vain_gain = 0.02;
constexpr int most_vain_trials = 2;

constexpr double slope_share = 1e-3; ///< of a step, for its slope
constexpr int corrections = 3;       ///< f² is nearly a straight line in Y
constexpr double largest_correction = 2.0;

/// Changes free number `k` by a change of its coordinate, as far as the bounds allow.
void move(StemModel& model, std::size_t k, double change) {
    const physics::FittedAs as = model.fitted_as(k);
    const auto [lower, upper] = model.bounds(k);
    const double to = from_coordinate(as, to_coordinate(as, model.value(k)) + change);
    model.set_value(k, std::clamp(to, lower, upper));
}

/// The models at one point, with everything that one run of each recording gives.
struct Point {
    StartModels models;
    std::vector<ChainPrediction> predictions;
    Eigen::MatrixXd jacobian;    ///< J, by the parameters that are not held
    Eigen::VectorXd residual;    ///< r
    Eigen::MatrixXd information; ///< JᵀJ
    Eigen::VectorXd gradient;    ///< Jᵀr
    double cost = 0.0;
};

struct Step {
    Eigen::VectorXd change; ///< (joint parameters)
    double promised = 0.0;  ///< decrease of the sum of squares
};

struct Trial {
    StartModels models;
    Eigen::VectorXd residual;
    double cost = 0.0;
};

class LeastSquares {
  public:
    explicit LeastSquares(const JointProblem& problem) : problem_(problem) {
        const double last =
            problem.options.window.value_or(std::numeric_limits<double>::infinity());
        for (const ObservedRecording& recording : problem.measurements)
            times_.emplace_back(recording.times.begin(),
                                std::ranges::upper_bound(recording.times, last));
        for (std::size_t k = 0; k < problem.layout.ids.size(); ++k)
            if (!problem.is_held[k])
                free_.push_back(static_cast<Eigen::Index>(k));
    }

    [[nodiscard]] Point at(StartModels models, std::vector<ChainPrediction> predictions = {}) {
        Point point;
        point.models = std::move(models);
        point.predictions = std::move(predictions);
        for (std::size_t m = point.predictions.size(); m < times_.size(); ++m) {
            point.predictions.push_back(
                predict_readings(point.models[m], times_[m], problem_.options.heartbeat));
            batches_ += point.predictions.back().batches;
        }
        WeightedSystem system = system_of(point.models, point.predictions);
        point.jacobian = system.jacobian(Eigen::all, free_);
        point.residual = std::move(system.residual);
        point.cost = point.residual.squaredNorm();
        point.information = point.jacobian.transpose() * point.jacobian;
        point.gradient = point.jacobian.transpose() * point.residual;
        return point;
    }

    [[nodiscard]] Step step(const Point& point, double damping = 0.0) const {
        const auto [lower, upper] = bounds_of(point.models, problem_.layout);
        Eigen::MatrixXd damped = point.information;
        damped.diagonal() *= 1.0 + damping;
        const Eigen::VectorXd change =
            bounded_minimum(damped, point.gradient, lower(free_), upper(free_));
        Step out{Eigen::VectorXd::Zero(static_cast<Eigen::Index>(problem_.layout.ids.size())),
                 2.0 * point.gradient.dot(change) - change.dot(point.information * change)};
        out.change(free_) = change;
        return out;
    }

    /// Does the step move a parameter away from its bound?
    [[nodiscard]] bool leaves_bound(const Step& step, const Point& point) const {
        const auto [lower, upper] = bounds_of(point.models, problem_.layout);
        return std::ranges::any_of(free_, [&, &low = lower, &high = upper](Eigen::Index k) {
            return step.change(k) != 0.0 && (low(k) == 0.0 || high(k) == 0.0);
        });
    }

    /// Takes a last small step without a run: its error is of second order.
    void take_linear(const Step& step, Point& point) const {
        for (std::size_t m = 0; m < point.predictions.size(); ++m) {
            ChainPrediction& prediction = point.predictions[m];
            for (std::size_t k = 0; k < prediction.parameters; ++k) {
                const auto [place, factor] = problem_.layout.shares[m][k];
                const double change = factor * step.change(static_cast<Eigen::Index>(place));
                for (std::size_t at = 0; at < prediction.readings.size(); ++at)
                    if (const double slope = prediction.jacobian[at * prediction.parameters + k];
                        std::isfinite(slope))
                        prediction.readings[at] += change * slope;
            }
        }
        point.models = moved(std::move(point.models), problem_.layout, step.change);
        point.cost -= step.promised;
    }

    [[nodiscard]] StartModels after(const Point& point, const Step& step) const {
        return in_valley(
            [&](double share) { return moved(point.models, problem_.layout, share * step.change); },
            problem_.layout);
    }

    /// Steps that are computed side by side, without derivatives.
    [[nodiscard]] std::vector<Trial> tried(const Point& point, const std::vector<Step>& steps) {
        std::vector<StartModels> runs;
        for (const Step& step : steps)
            runs.push_back(after(point, step));
        return run(std::move(runs));
    }

    /// Models side by side, without derivatives.
    [[nodiscard]] std::vector<Trial> run(std::vector<StartModels> runs) {
        const auto predictions = predict_runs(runs, times_, problem_.options.heartbeat, batches_);
        std::vector<Trial> out;
        for (std::size_t k = 0; k < runs.size(); ++k) {
            Eigen::VectorXd residual = system_of(runs[k], predictions[k]).residual;
            const double cost = residual.squaredNorm();
            out.push_back({std::move(runs[k]), std::move(residual), cost});
        }
        return out;
    }

    /// The start of the smallest residual, or the last one. Where a start is too far for a chain,
    /// the next may do.
    [[nodiscard]] StartModels best_of(std::span<const StartModels> starts) {
        while (true)
            try {
                std::vector<Trial> trials = run(std::vector(starts.begin(), starts.end()));
                trials.back().cost *= largest_excess;
                return std::move(std::ranges::min_element(trials, {}, &Trial::cost)->models);
            } catch (const core::NumericalError&) {
                if (starts.size() == 1)
                    throw;
                starts = starts.subspan(1);
            }
    }

    /// The second-order part a of a step δ whose end missed its linear prediction by d: J a = d.
    /// The path α δ + α² a follows a curved valley (Transtrum & Sethna 2012).
    [[nodiscard]] Eigen::VectorXd curvature(const Point& point, const Eigen::VectorXd& change,
                                            const Trial& trial) const {
        const Eigen::VectorXd missed =
            trial.residual - (point.residual - point.jacobian * change(free_));
        Eigen::VectorXd out = Eigen::VectorXd::Zero(change.size());
        out(free_) =
            ScaledSpectrum(point.information).solve(point.jacobian.transpose() * missed).col(0);
        return out;
    }

    /// The best end of damped steps, and of paths along the curvature of the best one.
    [[nodiscard]] Trial best_damped(const Point& point, double factor) {
        std::vector<Step> steps;
        for (const double damping : dampings)
            steps.push_back(step(point, factor * damping));
        std::vector<Trial> trials = tried(point, steps);
        const auto best = std::ranges::min_element(trials, {}, &Trial::cost);
        const Eigen::VectorXd way = steps[static_cast<std::size_t>(best - trials.begin())].change;
        const Eigen::VectorXd curve = curvature(point, way, *best);
        steps.clear();
        for (const double share : curved_shares)
            steps.push_back({share * way + share * share * curve, 0.0});
        std::ranges::move(tried(point, steps), std::back_inserter(trials));
        return std::move(*std::ranges::min_element(trials, {}, &Trial::cost));
    }

    /// Moves the point by a damped step; false if that gains less than `least`.
    [[nodiscard]] bool take_damped(Point& point, double least) {
        double factor = 1.0;
        for (int vain = 0; vain < most_vain_trials; ++vain, factor *= more_damping)
            try {
                Trial best = best_damped(point, factor);
                if (const double gain = point.cost - best.cost; gain > 0.0) {
                    point = at(std::move(best.models));
                    return gain > least;
                }
            } catch (const core::NumericalError&) {
            }
        return false;
    }

    [[nodiscard]] std::size_t readings() const {
        std::size_t count = 0;
        for (std::size_t m = 0; m < times_.size(); ++m)
            for (std::size_t at = 0; at < times_[m].size() * problem_.noise[m].size(); ++at)
                count += std::isfinite(problem_.measurements[m].deflections[at]) ? 1 : 0;
        return count;
    }

    [[nodiscard]] JointSolution solution_at(Point point, bool has_converged,
                                            std::string message) const {
        return {std::move(point.models),
                std::move(point.predictions),
                times_,
                batches_,
                point.cost,
                has_converged,
                std::move(message)};
    }

  private:
    [[nodiscard]] WeightedSystem system_of(const StartModels& models,
                                           const std::vector<ChainPrediction>& predictions) const {
        std::vector<SystemPart> parts;
        for (std::size_t m = 0; m < models.size(); ++m)
            parts.push_back(
                {models[m], problem_.measurements[m], predictions[m], problem_.noise[m], none_});
        return weighted_system(problem_.layout, parts);
    }

    const JointProblem& problem_;
    std::vector<std::vector<double>> times_;
    std::vector<Eigen::Index> free_; ///< joint parameters
    const std::vector<ErrorTerm> none_;
    int batches_ = 0;
};

/// Iterates from `point`; the last two are set at the end. In a curved valley, damped steps are
/// tried before derivatives are computed at its end.
void iterate(LeastSquares& problem, int most, Point& point, bool& has_converged,
             std::string& message) {
    const auto readings = static_cast<double>(problem.readings());
    bool is_rough = false;
    for (int iteration = 0; iteration < most; ++iteration) {
        const double unit = point.cost / readings;
        const Step step = problem.step(point);
        has_converged = true;
        if (!(step.promised > improvement * unit))
            return;
        const double before = point.cost;
        bool has_failed = false;
        if (!is_rough)
            try {
                Point next = problem.at(problem.after(point, step));
                const double gain = point.cost - next.cost;
                has_failed = !(gain > 0.0);
                if (!has_failed)
                    point = std::move(next);
                // The gain of a whole step differs from its promise by about the gain that remains.
                if (gain > 0.0 &&
                    std::min(gain, std::abs(gain - step.promised)) < improvement * unit)
                    return;
                if (has_failed && -gain < noise_of_runs * unit &&
                    step.promised < noise_of_runs * unit)
                    return;
            } catch (const core::NumericalError&) {
                has_failed = true;
            }
        if ((is_rough || has_failed) && !problem.take_damped(point, improvement * unit))
            return; // the rest of the promise is an error of the derivatives
        const double gained = before - point.cost;
        is_rough = gained < rough_gain * step.promised;
        if (gained < std::min(vain_gain * step.promised, unit))
            return;
    }
    has_converged = false;
    message = fmt::format("no minimum after {} steps", most);
}

/// ln f² and the decay rate (1/s) of the first mode of the first recording's chain.
Eigen::Vector2d first_mode(const StartModels& models) {
    const integrate::VibrationMode mode = run::lightly_damped_mode(computed_case(models.front()));
    return {2.0 * std::log(mode.frequency), -mode.decay_rate};
}

/// Index of a parameter among the joint ones; their number if it is not free.
Eigen::Index place_of(const JointLayout& layout, const physics::ParameterId& id) {
    return std::ranges::find(layout.ids, id) - layout.ids.begin();
}

/// Decay rate (1/s) by one unit of β.
double decay_per_beta(StartModels models) {
    const double whole = first_mode(models)(1);
    double& beta = models.front().spec.stem.bond_damping;
    const double half = 0.5 * beta;
    beta = half;
    return (whole - first_mode(models)(1)) / half;
}

} // namespace

FitOptions with_heartbeat(FitOptions options, const run::Heartbeat& heartbeat) {
    if (heartbeat)
        options.heartbeat = heartbeat;
    return options;
}

std::vector<std::vector<ChainPrediction>> predict_runs(const std::vector<StartModels>& runs,
                                                       std::span<const std::vector<double>> times,
                                                       const run::Heartbeat& heartbeat,
                                                       int& batches) {
    std::vector<std::vector<ChainPrediction>> predictions(runs.size());
    for (std::size_t m = 0; m < times.size(); ++m) {
        std::vector<StemModel> models;
        for (const StartModels& run : runs)
            models.push_back(run[m]);
        auto found = predict_together(models, times[m], heartbeat);
        for (std::size_t k = 0; k < runs.size(); ++k) {
            batches += found[k].batches;
            predictions[k].push_back(std::move(found[k]));
        }
    }
    return predictions;
}

std::pair<Eigen::VectorXd, Eigen::VectorXd> bounds_of(const StartModels& models,
                                                      const JointLayout& layout) {
    Eigen::VectorXd lowest(std::ssize(layout.owners));
    Eigen::VectorXd highest(lowest.size());
    for (Eigen::Index k = 0; k < lowest.size(); ++k) {
        const auto [m, parameter] = layout.owners[static_cast<std::size_t>(k)];
        const physics::FittedAs as = models[m].fitted_as(parameter);
        const auto [lower, upper] = models[m].bounds(parameter);
        const double at = to_coordinate(as, models[m].value(parameter));
        std::tie(lowest(k), highest(k)) =
            std::minmax({to_coordinate(as, lower) - at, to_coordinate(as, upper) - at});
    }
    return {std::move(lowest), std::move(highest)};
}

StartModels moved(StartModels models, const JointLayout& layout, const Eigen::VectorXd& change) {
    for (std::size_t m = 0; m < models.size(); ++m)
        for (std::size_t k = 0; k < layout.shares[m].size(); ++k) {
            const JointLayout::Share& share = layout.shares[m][k];
            // Only β has a factor.
            move(models[m], k, share.factor * change(static_cast<Eigen::Index>(share.place)));
        }
    return models;
}

StartModels in_valley(const std::function<StartModels(double)>& at, const JointLayout& layout) {
    const StartModels straight = at(1.0);
    const Eigen::Index modulus = place_of(layout, physics::bond_youngs_modulus);
    const Eigen::Index damping = place_of(layout, physics::bond_damping);
    const Eigen::Index count = std::ssize(layout.ids);
    if (modulus == count || count < 3)
        return straight;
    // The slope is one-sided, because an effect may begin at the bound of its size.
    const Eigen::Vector2d here = first_mode(at(0.0));
    const Eigen::Vector2d wanted = here + (4.0 * first_mode(at(slope_share)) - 3.0 * here -
                                           first_mode(at(2.0 * slope_share))) /
                                              (2.0 * slope_share);
    const double per_beta = damping < count ? decay_per_beta(straight) : 0.0;
    StartModels to = straight;
    Eigen::VectorXd change = Eigen::VectorXd::Zero(count);
    for (int pass = 0; pass < corrections; ++pass) {
        const Eigen::Vector2d missed = wanted - first_mode(to);
        if (!(std::abs(missed(0)) < largest_correction)) // no frequency to follow
            return straight;
        change(modulus) = missed(0);
        if (per_beta > 0.0)
            change(damping) = missed(1) / per_beta;
        to = moved(std::move(to), layout, change);
    }
    return to;
}

JointSolution solve(const JointProblem& problem, const std::vector<StartModels>& starts,
                    std::vector<ChainPrediction> predictions) {
    LeastSquares equations(problem);
    if (equations.readings() == 0)
        throw core::NumericalError(core::FailureKind::FitFailed,
                                   "no reading lies within the window of the fit");
    Point point = equations.at(starts.size() > 1 ? equations.best_of(starts) : starts.front(),
                               std::move(predictions));
    bool has_converged = false;
    std::string message;
    iterate(equations, problem.options.largest_iterations, point, has_converged, message);
    if (has_converged) {
        const Step last = equations.step(point);
        if (last.promised < improvement * point.cost / double(equations.readings()) &&
            !equations.leaves_bound(last, point))
            equations.take_linear(last, point);
    }
    return equations.solution_at(std::move(point), has_converged, std::move(message));
}

} // namespace culm::fit
