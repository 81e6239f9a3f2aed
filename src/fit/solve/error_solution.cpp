// SPDX-License-Identifier: BSD-3-Clause
#include "fit/solve/error_solution.hpp"

#include "fit/linear/scaled_solve.hpp"
#include "fit/solve/moved_inputs.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>

namespace culm::fit {
namespace {

/// Passes in which an unknown noise follows from what remains.
constexpr int noise_passes = 3;
/// Pulls, in standard uncertainties, up to which the solution of an inadequate model is linear.
constexpr double linear_pull = 5.0;
/// Likewise of a model that may be adequate with other inputs, whose solution is run.
constexpr double largest_pull = 20.0;
constexpr double nearly_adequate = 2.0; ///< reduced χ² in that solution
constexpr int most_passes = 3;          ///< of runs with new derivatives
constexpr double no_limit = 1e6;

class ErrorSolution {
  public:
    ErrorSolution(std::span<const ObservedRecording> recordings, const JointLayout& layout,
                  const std::vector<bool>& is_held, const FitOptions& options, Fit& fit)
        : recordings_(recordings), layout_(layout), is_held_(is_held), options_(options), fit_(fit),
          count_(static_cast<Eigen::Index>(layout.ids.size())) {}

    void run() {
        const bool is_known = std::ranges::all_of(fit_.parts, &RecordingFit::is_noise_known);
        const int passes = is_known ? 1 : noise_passes;
        for (int pass = 0; pass < passes; ++pass) {
            build(pass == 0);
            solve(largest_pull);
            const bool is_near =
                is_known && left_.squaredNorm() < nearly_adequate * double(fit_.readings);
            if (!is_near)
                solve(linear_pull);
            if (pass + 1 == passes)
                run_moved_inputs(is_near ? most_passes : 0);
            if (!is_known)
                scale_noise();
        }
        add_sums();
        add_covariance();
        add_remaining();
        add_pulls();
        if (has_factors_)
            take_solution();
    }

    /// Change of the columns, after run().
    [[nodiscard]] const Eigen::VectorXd& change() const { return change_; }

  private:
    void build(bool is_first) {
        fit_.system = weighted_system(layout_, parts_of(fit_, recordings_));
        begins_.assign(1, 0);
        for (const RecordingFit& part : fit_.parts)
            begins_.push_back(begins_.back() + std::ssize(part.residuals));
        fit_.own_weighted_rms = std::sqrt(fit_.system.residual.squaredNorm() /
                                          std::max<double>(1.0, double(fit_.readings)));
        if (is_first)
            fit_.weighted_rms = fit_.own_weighted_rms;
        take_back_factors();
        add_normal_equations();
    }

    /// Is the number a factor of Y or β?
    [[nodiscard]] bool is_factor(std::size_t k) const {
        return fit_.system.errors[k] == ErrorKind::Modulus ||
               fit_.system.errors[k] == ErrorKind::Damping;
    }

    /// The stated inputs take the place of the factors of Y and β.
    void take_back_factors() {
        WeightedSystem& system = fit_.system;
        for (std::size_t k = 0; k < layout_.owners.size(); ++k) {
            if (!is_factor(k))
                continue;
            has_factors_ = true;
            const auto [model, parameter] = layout_.owners[k];
            auto column = system.jacobian.col(static_cast<Eigen::Index>(k));
            system.residual += fit_.parts[model].model.value(parameter) * column;
            column.setZero();
        }
    }

    // A fit is at its minimum. The rest of its gradient is an error of the derivatives, which leads
    // far along a valley; only the terms move the parameters.
    void add_normal_equations() {
        const Eigen::MatrixXd& jacobian = fit_.system.jacobian;
        const auto [lower, upper] = limits_of(start_from(fit_), Eigen::VectorXd::Zero(count_));
        std::vector<Eigen::Index> free;
        for (Eigen::Index k = 0; k < count_ && !has_factors_; ++k)
            if (!fit_.parameters[static_cast<std::size_t>(k)].is_at_bound && lower(k) < upper(k))
                free.push_back(k);
        information_ = jacobian.transpose() * jacobian;
        gradient_ = jacobian.transpose() *
                    Projector(jacobian(Eigen::all, free)).remainder(fit_.system.residual);
    }

    void solve(double largest) {
        limit_ = largest;
        const Eigen::MatrixXd& jacobian = fit_.system.jacobian;
        const auto [lower, upper] =
            limits_of(start_from(fit_), Eigen::VectorXd::Zero(jacobian.cols()));
        change_ = bounded_minimum(information_, gradient_, lower, upper);
        left_ = fit_.system.residual - jacobian * change_;
    }

    /// Limits of the changes of all columns, of which `change` was made before.
    [[nodiscard]] std::pair<Eigen::VectorXd, Eigen::VectorXd>
    limits_of(const StartModels& models, const Eigen::VectorXd& change) const {
        // The inputs take over whatever the factors have explained.
        const double largest = has_factors_ ? no_limit : limit_;
        Eigen::VectorXd lower = -change.array() - largest;
        Eigen::VectorXd upper = -change.array() + largest;
        const auto [lowest, highest] = bounds_of(models, layout_);
        lower.head(count_) = lowest;
        upper.head(count_) = highest;
        for (Eigen::Index k = 0; k < count_; ++k)
            if (is_held_[static_cast<std::size_t>(k)])
                lower(k) = upper(k) = 0.0;
        return {lower, upper};
    }

    /// Replaces the linear solution by runs where it contradicts inputs of a chain.
    void run_moved_inputs(int new_derivatives) {
        if (has_factors_ || !options_.moves_inputs)
            return; // the inputs have to explain the factors
        moved_ = moved_inputs(
            recordings_, layout_, change_,
            [&](const WeightedSystem& system, const StartModels& models,
                const Eigen::VectorXd& change) {
                const auto [lower, upper] = limits_of(models, change);
                return bounded_minimum(system.jacobian.transpose() * system.jacobian,
                                       system.jacobian.transpose() * system.residual, lower, upper);
            },
            new_derivatives, options_.heartbeat, fit_);
        if (moved_) {
            change_ = moved_->change;
            left_ = moved_->left;
        }
    }

    [[nodiscard]] double left_of(std::size_t m) const {
        return left_.segment(begins_[m], begins_[m + 1] - begins_[m]).squaredNorm();
    }

    /// An error term adds a residual and so takes no degree of freedom.
    [[nodiscard]] bool takes_freedom(std::size_t k) const {
        return !is_held_[k] && !fit_.system.errors[k];
    }

    [[nodiscard]] std::size_t degrees_of_freedom(std::size_t m) const {
        std::size_t degrees = fit_.parts[m].readings;
        for (const JointLayout::Share& share : layout_.shares[m])
            degrees -= degrees > 0 && takes_freedom(share.place) ? 1 : 0;
        return degrees;
    }

    void scale_noise() {
        for (std::size_t m = 0; m < fit_.parts.size(); ++m) {
            const double degrees = double(std::max<std::size_t>(degrees_of_freedom(m), 1));
            const double factor = std::sqrt(std::max(left_of(m) / degrees, 1e-300));
            if (!fit_.parts[m].is_noise_known)
                for (double& noise : fit_.parts[m].noise)
                    noise *= factor;
        }
    }

    void add_sums() {
        fit_.misfits.clear();
        std::vector<bool> is_counted(static_cast<std::size_t>(change_.size()), false);
        fit_.chi_squared = 0.0;
        for (std::size_t m = 0; m < fit_.parts.size(); ++m) {
            RecordingFit& part = fit_.parts[m];
            part.degrees_of_freedom = degrees_of_freedom(m);
            const double degrees = double(std::max<std::size_t>(part.degrees_of_freedom, 1));
            part.chi_squared = part.is_noise_known ? left_of(m) + pulls_of(m, is_counted) : degrees;
            part.reduced_chi_squared = part.chi_squared / degrees;
            fit_.chi_squared += part.chi_squared;
        }
        fit_.degrees_of_freedom = fit_.readings;
        for (std::size_t k = 0; k < layout_.ids.size(); ++k)
            fit_.degrees_of_freedom -= fit_.degrees_of_freedom > 0 && takes_freedom(k) ? 1 : 0;
        fit_.reduced_chi_squared =
            fit_.chi_squared / double(std::max<std::size_t>(fit_.degrees_of_freedom, 1));
    }

    /// Sum of the squares of the terms that this recording has first.
    [[nodiscard]] double pulls_of(std::size_t m, std::vector<bool>& is_counted) const {
        double sum = 0.0;
        Eigen::Index row = fit_.system.readings();
        for (std::size_t k = 0; k < is_counted.size(); ++k) {
            if (!fit_.system.errors[k])
                continue;
            const double value = left_(row++);
            const std::string& id = fit_.system.ids[k].name;
            const bool is_own = k < layout_.owners.size()
                                    ? layout_.owners[k].model == m
                                    : std::ranges::find(fit_.parts[m].terms, id, &ErrorTerm::id) !=
                                          fit_.parts[m].terms.end();
            if (!is_own || is_counted[k])
                continue;
            is_counted[k] = true;
            sum += value * value;
        }
        return sum;
    }

    void add_covariance() {
        const double misfit = std::max(1.0, fit_.reduced_chi_squared);
        const Eigen::Index readings = fit_.system.readings();
        const Eigen::MatrixXd jacobian = fit_.system.jacobian.topRows(readings);
        const Eigen::MatrixXd constraints =
            fit_.system.jacobian.bottomRows(fit_.system.constraints);
        const auto information = [&](const std::vector<Eigen::Index>& columns, double factor) {
            const Eigen::MatrixXd of = jacobian(Eigen::all, columns);
            const Eigen::MatrixXd with = constraints(Eigen::all, columns);
            return Eigen::MatrixXd(of.transpose() * of / factor + with.transpose() * with);
        };
        std::vector<Eigen::Index> own;
        std::vector<Eigen::Index> all;
        for (Eigen::Index k = 0; k < jacobian.cols(); ++k)
            if (k >= count_ || !is_held_[static_cast<std::size_t>(k)]) {
                all.push_back(k);
                if (k < count_)
                    own.push_back(k);
            }
        const ScaledSpectrum together(information(all, misfit));
        together_ = Eigen::MatrixXd::Zero(jacobian.cols(), jacobian.cols());
        together_(all, all) = together.covariance();
        changes_ = Eigen::MatrixXd::Zero(count_, jacobian.cols());
        fit_.covariance = Eigen::MatrixXd::Zero(count_, count_);
        if (own.empty())
            return;
        const ScaledSpectrum alone(information(own, 1.0));
        const Eigen::MatrixXd of = jacobian(Eigen::all, own);
        changes_(own, Eigen::all) = alone.solve(of.transpose() * jacobian);
        changes_.leftCols(count_).setZero(); // fitted
        fit_.covariance(own, own) = ScaledSpectrum(information(own, misfit)).covariance();
        fit_.covariance += changes_ * changes_.transpose();
    }

    /// The residuals without the changes of the terms and of the parameters.
    void add_remaining() {
        for (std::size_t m = 0; m < fit_.parts.size(); ++m) {
            RecordingFit& part = fit_.parts[m];
            part.remaining = part.residuals;
            if (moved_)
                for (std::size_t at = 0; at < part.remaining.size(); ++at)
                    part.remaining[at] += part.prediction.readings[at] - moved_->readings[m][at];
            else
                subtract_changes(m);
            double squares = 0.0;
            double motion = 0.0;
            for (std::size_t at = 0; at < part.remaining.size(); ++at)
                if (!std::isnan(part.remaining[at])) {
                    squares += part.remaining[at] * part.remaining[at];
                    motion += std::pow(part.prediction.readings[at] + part.residuals[at], 2);
                }
            const auto readings = double(std::max<std::size_t>(part.readings, 1));
            fit_.misfits.push_back(
                {part.readings, part.is_noise_known ? left_of(m) : part.chi_squared,
                 std::sqrt(squares / readings), part.is_noise_known, std::sqrt(motion / readings)});
        }
    }

    void subtract_changes(std::size_t m) {
        RecordingFit& part = fit_.parts[m];
        const std::size_t stride = part.prediction.parameters;
        const auto subtract = [&](double amount, const double* column, std::size_t step) {
            for (std::size_t at = 0; at < part.remaining.size(); ++at)
                if (const double by = column[at * step]; std::isfinite(by))
                    part.remaining[at] -= amount * by;
        };
        for (std::size_t k = 0; k < layout_.shares[m].size(); ++k)
            subtract(explained(m, k), part.prediction.jacobian.data() + k, stride);
        for (const ErrorTerm& term : part.terms)
            subtract(change_(fit_.system.column_of(term)), term.readings.data(), 1);
    }

    /// Change of free number `k` of a part in the solution.
    [[nodiscard]] double explained(std::size_t m, std::size_t k) const {
        const std::size_t place = layout_.shares[m][k].place;
        return is_factor(place) ? -fit_.parts[m].model.value(k)
                                : change_(static_cast<Eigen::Index>(place));
    }

    void add_pulls() {
        fit_.pulls.clear();
        for (Eigen::Index k = 0; k < change_.size(); ++k) {
            const auto place = static_cast<std::size_t>(k);
            const std::optional<ErrorKind> kind = fit_.system.errors[place];
            if (!kind || is_factor(place))
                continue; // of the factors, the inputs have taken over
            double value = change_(k);
            if (k < count_) {
                const auto [model, parameter] = layout_.owners[place];
                value += fit_.parts[model].model.value(parameter);
            }
            Pull& pull = fit_.pulls.emplace_back(
                Pull{*kind, fit_.system.ids[place].name, value, std::sqrt(together_(k, k)), {}});
            for (Eigen::Index p = 0; p < count_; ++p) {
                const auto [model, parameter] = layout_.owners[static_cast<std::size_t>(p)];
                pull.changes.push_back(changes_(p, k) /
                                       fit_.parts[model].model.coordinate_slope(parameter));
            }
        }
    }

    /// The values of the solution; the prediction remains that of the fit.
    void take_solution() {
        fit_.has_moved_inputs = true;
        fit_.covariance = together_.topLeftCorner(count_, count_);
        StartModels models = moved(start_from(fit_), layout_, change_.head(count_));
        for (std::size_t m = 0; m < models.size(); ++m) {
            StemModel& model = models[m];
            const physics::StemParameters<double>& stem = fit_.parts[m].model.spec.stem;
            for (std::size_t k = model.first_error(); k < model.free_count(); ++k) {
                const ErrorTerm& term = model.error_term(k); // the recording's own Y and β stay
                const physics::StemParameters<double>& now = model.spec.stem;
                const double moved_by =
                    term.kind == ErrorKind::Modulus
                        ? std::log(now.bond_youngs_modulus / stem.bond_youngs_modulus) /
                              term.log_modulus
                    : term.kind == ErrorKind::Damping
                        ? std::log(now.bond_damping / stem.bond_damping) / term.log_damping
                        : 0.0;
                model.set_value(k, model.value(k) - moved_by);
            }
            fit_.parts[m].model = std::move(model);
        }
        change_.head(count_).setZero();
    }

    std::span<const ObservedRecording> recordings_;
    const JointLayout& layout_;
    const std::vector<bool>& is_held_;
    const FitOptions& options_;
    Fit& fit_;
    Eigen::Index count_;               ///< of parameters and fitted terms
    std::vector<Eigen::Index> begins_; ///< (recordings + 1) first rows
    Eigen::MatrixXd information_;      ///< (columns, columns) of the solution
    Eigen::VectorXd gradient_;         ///< (columns)
    Eigen::VectorXd change_;           ///< (columns)
    Eigen::VectorXd left_;             ///< (rows)
    Eigen::MatrixXd changes_;          ///< (parameters, columns) by one unit of a term
    Eigen::MatrixXd together_;         ///< (columns, columns) covariance of the solution
    std::optional<MovedInputs> moved_; ///< where runs replace the linear solution
    double limit_ = 0.0;               ///< of a pull
    bool has_factors_ = false;
};

} // namespace

void solve_with_errors(std::span<const ObservedRecording> recordings, const JointLayout& layout,
                       const std::vector<bool>& is_held, const FitOptions& options, Fit& fit) {
    ErrorSolution solution(recordings, layout, is_held, options, fit);
    solution.run();
    for (std::size_t k = 0; k < layout.ids.size(); ++k) {
        const auto [model, parameter] = layout.owners[k];
        FittedParameter& joint = fit.parameters[k];
        const StemModel& owner = fit.parts[model].model;
        joint.value = owner.value(parameter);
        const auto place = static_cast<Eigen::Index>(k);
        joint.standard_error =
            std::sqrt(fit.covariance(place, place)) / std::abs(owner.coordinate_slope(parameter));
        joint.value_with_errors =
            from_coordinate(joint.fitted_as,
                            to_coordinate(joint.fitted_as, joint.value) + solution.change()(place));
    }
    for (std::size_t m = 0; m < fit.parts.size(); ++m)
        for (std::size_t k = 0; k < layout.shares[m].size(); ++k) {
            const auto [place, factor] = layout.shares[m][k];
            FittedParameter& own = fit.parts[m].parameters[k];
            own.value = fit.parts[m].model.value(k);
            own.standard_error = factor * fit.parameters[place].standard_error;
            own.value_with_errors = factor * fit.parameters[place].value_with_errors;
        }
}

std::vector<SystemPart> parts_of(const Fit& fit, std::span<const ObservedRecording> recordings) {
    std::vector<SystemPart> parts;
    for (std::size_t m = 0; m < fit.parts.size(); ++m) {
        const RecordingFit& part = fit.parts[m];
        parts.push_back({part.model, recordings[m], part.prediction, part.noise, part.terms});
    }
    return parts;
}

WeightedSystem system_at(const StartModels& models, const Fit& fit,
                         std::span<const ObservedRecording> recordings,
                         const run::Heartbeat& heartbeat) {
    std::vector<ChainPrediction> predictions;
    for (std::size_t m = 0; m < models.size(); ++m)
        predictions.push_back(predict_readings(models[m], fit.parts[m].times, heartbeat));
    std::vector<SystemPart> parts;
    for (std::size_t m = 0; m < models.size(); ++m)
        parts.push_back(
            {models[m], recordings[m], predictions[m], fit.parts[m].noise, fit.parts[m].terms});
    return weighted_system(joint_layout(models, recordings), parts);
}

std::vector<Eigen::VectorXd> readings_together(const std::vector<StartModels>& runs, const Fit& fit,
                                               std::span<const ObservedRecording> recordings,
                                               const run::Heartbeat& heartbeat, int& batches) {
    const auto predictions = predict_runs(runs, times_of(fit), heartbeat, batches);
    std::vector<Eigen::VectorXd> readings(runs.size(),
                                          Eigen::VectorXd::Zero(fit.system.residual.size()));
    for (std::size_t k = 0; k < runs.size(); ++k) {
        Eigen::Index row = 0;
        for (std::size_t m = 0; m < fit.parts.size(); ++m) {
            const RecordingFit& part = fit.parts[m];
            const Eigen::Index size = std::ssize(part.residuals);
            readings[k].segment(row, size) = weighted_readings(
                {runs[k][m], recordings[m], predictions[k][m], part.noise, part.terms});
            row += size;
        }
    }
    return readings;
}

} // namespace culm::fit
