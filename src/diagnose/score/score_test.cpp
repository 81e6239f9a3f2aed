// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/score/score_test.hpp"

#include "core/error.hpp"
#include "diagnose/score/stacked_readings.hpp"
#include "diagnose/score/visible_size.hpp"
#include "fit/solve/residual_statistics.hpp"
#include "fit/start/starts.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>

#include <Eigen/QR>

namespace culm::diagnose {
namespace {

constexpr int most_bounded = 4; ///< parameters that are held in turn because they meet a bound
/// Of Y in a start, within which it counts as the model as it is.
constexpr double largest_modulus_change = 0.1;

/// Above it AR(1) noise is nearly a random walk over the record, and a draw says nothing.
constexpr double largest_null_correlation = 0.95;
constexpr std::uint64_t null_seed = 0x63756c6dULL;

/// Standard normal numbers by Box and Muller's method: the same with every library.
class NormalNumbers {
  public:
    explicit NormalNumbers(std::uint64_t draw)
        : engine_(null_seed + draw * 0x9e3779b97f4a7c15ULL) {}
    [[nodiscard]] double operator()() {
        if (has_second_) {
            has_second_ = false;
            return second_;
        }
        const double radius = std::sqrt(-2.0 * std::log(uniform()));
        const double angle = 2.0 * std::numbers::pi * uniform();
        second_ = radius * std::sin(angle);
        has_second_ = true;
        return radius * std::cos(angle);
    }

  private:
    /// In (0, 1).
    [[nodiscard]] double uniform() {
        return (static_cast<double>(engine_() >> 11) + 0.5) * 0x1.0p-53;
    }
    std::mt19937_64 engine_;
    double second_ = 0.0;
    bool has_second_ = false;
};

/// Correlation of neighbouring frames; 0 within two standard errors of it.
double frame_correlation(const Eigen::MatrixXd& whitened, Eigen::Index row) {
    double product = 0.0;
    double square = 0.0;
    for (Eigen::Index i = 1; i < whitened.rows(); ++i) {
        product += whitened(i, row) * whitened(i - 1, row);
        square += whitened(i, row) * whitened(i, row);
    }
    const double correlation = square > 0.0 ? product / square : 0.0;
    const double chance =
        2.0 / std::sqrt(static_cast<double>(std::max<Eigen::Index>(whitened.rows(), 1)));
    return correlation > chance ? std::min(correlation, largest_null_correlation) : 0.0;
}

/// Noise over itself, (readings of all recordings, draws): Gaussian, and in every row correlated
/// from frame to frame as the residuals of `fit` are where that is more than chance (first-order
/// autoregression). Zero where nothing was seen. The same on every rank.
Eigen::MatrixXd null_noise(const fit::Fit& fit, int draws) {
    std::vector<std::vector<double>> correlations; // (recordings)(rows)
    Eigen::Index readings = 0;
    for (const fit::RecordingFit& part : fit.parts) {
        const Eigen::MatrixXd whitened = fit::whitened_residuals(part);
        std::vector<double>& rows = correlations.emplace_back();
        for (Eigen::Index j = 0; j < whitened.cols(); ++j)
            rows.push_back(frame_correlation(whitened, j));
        readings += static_cast<Eigen::Index>(part.residuals.size());
    }
    Eigen::MatrixXd noise = Eigen::MatrixXd::Zero(readings, draws);
    for (Eigen::Index draw = 0; draw < noise.cols(); ++draw) {
        NormalNumbers normal(static_cast<std::uint64_t>(draw));
        Eigen::Index begin = 0;
        for (std::size_t m = 0; m < fit.parts.size(); ++m) {
            const std::vector<double>& residuals = fit.parts[m].residuals;
            const std::size_t rows = correlations[m].size();
            for (std::size_t j = 0; j < rows; ++j) {
                const double correlation = correlations[m][j];
                const double fresh = std::sqrt(1.0 - correlation * correlation);
                double value = normal();
                for (std::size_t place = j; place < residuals.size(); place += rows) {
                    if (!std::isnan(residuals[place]))
                        noise(begin + static_cast<Eigen::Index>(place), draw) = value;
                    value = correlation * value + fresh * normal();
                }
            }
            begin += static_cast<Eigen::Index>(residuals.size());
        }
    }
    return noise;
}

class ScoreTest {
  public:
    ScoreTest(const fit::Fit& base, const physics::SelectedEffect& effect,
              std::span<const fit::ObservedRecording> recordings, const fit::FitOptions& options)
        : base_(base), effect_(effect), recordings_(recordings), options_(options),
          fitted_(stacked_readings(base, recordings)),
          size_(base, fitted_, recordings, options, score_) {
        score_.effect = effect.effect->name();
        for (std::size_t m = 0; m < recordings.size(); ++m)
            models_.push_back(candidate_model(base.parts[m].model, {effect}, recordings[m]));
    }

    [[nodiscard]] EffectScore run(int draws) {
        if (!has_new_parameter()) {
            judge_fixed(draws);
            return score_;
        }
        std::vector<fit::StartModels> absent = starts(fit::StartSize::Absent);
        if (has_own_sizes(models_.front(), base_.parts.front()))
            absent.resize(1); // its places say nothing while it is absent
        for (const fit::StartModels& start : absent)
            judge_start(start, draws);
        const bool vanishes = !size_.is_known();
        if (vanishes || draws > 0)
            make_sure_of_size();
        if (vanishes || has_own_sizes(models_.front(), base_.parts.front()))
            judge_told_starts();
        return score_;
    }

  private:
    [[nodiscard]] StackedReadings compute(const fit::StartModels& models) const {
        return stacked_readings(models, recordings_, base_, options_.heartbeat);
    }
    [[nodiscard]] bool is_new(const physics::ParameterId& column) const {
        return std::ranges::find(fitted_.ids, column) == fitted_.ids.end();
    }
    [[nodiscard]] bool has_new_parameter() const {
        return models_.front().free_count() > base_.parts.front().model.free_count();
    }

    /// The k-th start of every recording together.
    [[nodiscard]] std::vector<fit::StartModels> starts(fit::StartSize size) const {
        std::vector<fit::StartModels> all;
        for (std::size_t m = 0; m < models_.size(); ++m) {
            fit::StartModels own = fit_starts(models_[m], base_.parts[m], size);
            all.resize(m == 0 ? own.size() : std::min(all.size(), own.size()));
            for (std::size_t k = 0; k < all.size(); ++k)
                all[k].push_back(std::move(own[k]));
        }
        return all;
    }

    void judge_told_starts() {
        const std::vector<fit::StartModels> told = starts(fit::StartSize::Told);
        // Where the readings show beats, a step from no split at all promises what no split keeps.
        if (effect_.effect->dimensions() > 2 && !told.empty())
            score_.gain = 0.0;
        for (const fit::StartModels& start : told)
            judge_gain(compute(start), start);
    }

    void make_sure_of_size() {
        try {
            size_.settle(size_.is_known() ? fit::StartModels{}
                                          : starts(fit::StartSize::Default).front());
        } catch (const core::NumericalError&) {
            // A chain with so much of it cannot be computed: what is known stays.
        }
    }

    void judge_start(const fit::StartModels& start, int draws) {
        const StackedReadings stacked = compute(start);
        judge_gain(stacked, start);
        // Only beside the model as it is; a clamp as soft as its friction would need is another.
        const double modulus = base_.parts.front().model.spec.stem.bond_youngs_modulus;
        if (std::abs(start.front().spec.stem.bond_youngs_modulus / modulus - 1.0) <
            largest_modulus_change)
            size_.judge(stacked, start);
        judge_noise(stacked, start, draws);
    }

    /// The gain of one linear step from here that stays within the effect's bounds.
    void judge_gain(const StackedReadings& stacked, const fit::StartModels& start) {
        // An active-set method in a few passes: a parameter whose step leaves its bounds is held at
        // its start, and the others are solved for again. A mass that wants to be negative then
        // promises nothing, as it would in the fit.
        std::vector<bool> is_held(stacked.ids.size(), false);
        LinearSolution solution = solve_linear(stacked, is_held);
        for (int pass = 0; pass < most_bounded; ++pass) {
            bool is_inside = true;
            for (std::size_t k = 0; k < stacked.ids.size(); ++k)
                if (const double change = solution.change(static_cast<Eigen::Index>(k));
                    is_new(stacked.ids[k]) && !is_held[k] &&
                    (leaves_bounds(start, stacked.ids[k], change) ||
                     oversteps(start, stacked.ids[k], change))) {
                    is_held[k] = true;
                    is_inside = false;
                }
            if (is_inside)
                break;
            solution = solve_linear(stacked, is_held);
        }
        score_.added = static_cast<int>(stacked.ids.size() - fitted_.ids.size());
        score_.gain = std::max(score_.gain, fitted_.residual.squaredNorm() - solution.left);
    }

    [[nodiscard]] static bool leaves_bounds(const fit::StartModels& start,
                                            const physics::ParameterId& column, double change) {
        const fit::StemModel& model = start.front();
        const fit::FreeParameter* const parameter = parameter_of(model, column);
        if (parameter == nullptr || parameter->is_place)
            return false;
        const double value = parameter->access.get(model.spec);
        return (value <= parameter->lower && change < 0.0) ||
               (value >= parameter->upper && change > 0.0);
    }

    /// A step from a size of its own that would end beyond the bounds, at a negative mass say.
    [[nodiscard]] static bool oversteps(const fit::StartModels& start,
                                        const physics::ParameterId& column, double change) {
        const fit::StemModel& model = start.front();
        const fit::FreeParameter* const parameter = parameter_of(model, column);
        if (parameter == nullptr || parameter->is_place ||
            parameter->fitted_as != physics::FittedAs::Itself)
            return false;
        const double value = parameter->access.get(model.spec);
        return value > parameter->lower && value < parameter->upper &&
               (value + change < parameter->lower || value + change > parameter->upper);
    }

    void judge_noise(const StackedReadings& stacked, const fit::StartModels& start, int draws) {
        if (draws == 0)
            return;
        const Eigen::MatrixXd old = columns_of(fitted_, stacked);
        std::vector<Eigen::VectorXd> added;
        bool is_one_sided = false;
        for (std::size_t k = 0; k < stacked.ids.size(); ++k) {
            if (!is_new(stacked.ids[k]))
                continue;
            const Eigen::VectorXd column = stacked.jacobian.col(static_cast<Eigen::Index>(k));
            const Eigen::VectorXd own = project_off(old, column).standing_out;
            if (!(own.norm() > least_standing_out * column.norm()))
                continue;
            // In units of its own length: the gain of noise is the square of its projection, χ²
            // with one degree of freedom for each independent column.
            added.emplace_back(own / own.norm());
            is_one_sided = leaves_bounds(start, stacked.ids[k], -1.0) ||
                           leaves_bounds(start, stacked.ids[k], 1.0);
        }
        if (added.empty())
            return;
        Eigen::MatrixXd basis(stacked.residual.size(), static_cast<Eigen::Index>(added.size()));
        for (std::size_t k = 0; k < added.size(); ++k)
            basis.col(static_cast<Eigen::Index>(k)) = added[k];
        if (added.size() > 1) {
            const Eigen::HouseholderQR<Eigen::MatrixXd> solver(basis);
            basis = solver.householderQ() * Eigen::MatrixXd::Identity(basis.rows(), basis.cols());
        }
        if (noise_.size() == 0)
            noise_ = null_noise(base_, draws);
        score_.null_gains.resize(static_cast<std::size_t>(draws), 0.0);
        for (int draw = 0; draw < draws; ++draw) {
            const Eigen::VectorXd seen =
                basis.topRows(noise_.rows()).transpose() * noise_.col(draw);
            const bool counts = !(is_one_sided && added.size() == 1) || seen(0) > 0.0;
            double& gain = score_.null_gains[static_cast<std::size_t>(draw)];
            gain = std::max(gain, counts ? seen.squaredNorm() : 0.0);
        }
    }

    /// An effect without a number to fit: there, or not.
    void judge_fixed(int draws) {
        const StackedReadings with = compute(starts(fit::StartSize::Default).front());
        score_.gain =
            std::max(0.0, fitted_.residual.squaredNorm() -
                              solve_linear(with, std::vector<bool>(with.ids.size())).left);
        const StackedReadings added = compute(models_);
        const Projection projection =
            project_off(fitted_.jacobian, added.predicted - fitted_.predicted);
        const std::vector<physics::EffectParameter> parameters = effect_.effect->parameters();
        const std::vector<double>& values = models_.front().spec.effects.back().values;
        const auto largest =
            std::ranges::max_element(values, {}, [](double value) { return std::abs(value); });
        if (largest != values.end())
            size_.keep_fixed(parameters[static_cast<std::size_t>(largest - values.begin())],
                             *largest, projection);
        if (draws > 0)
            score_.null_gains.assign(static_cast<std::size_t>(draws), 0.0);
    }

    const fit::Fit& base_;
    const physics::SelectedEffect& effect_;
    std::span<const fit::ObservedRecording> recordings_;
    const fit::FitOptions& options_;
    StackedReadings fitted_;
    fit::StartModels models_;
    Eigen::MatrixXd noise_; ///< (readings, draws); drawn when the first start needs it
    EffectScore score_;
    VisibleSize size_; ///< writes into the score
};

} // namespace

EffectScore score_effect(const fit::Fit& base, const physics::SelectedEffect& effect,
                         std::span<const fit::ObservedRecording> recordings,
                         const fit::FitOptions& options, int draws) {
    EffectScore failed;
    failed.effect = effect.effect->name();
    try {
        return ScoreTest(base, effect, recordings, options).run(draws);
    } catch (const core::InputError& error) { // cannot be combined, or means nothing here
        failed.failure = error.what();
    } catch (const core::NumericalError& error) {
        failed.failure = error.what();
    }
    return failed;
}

} // namespace culm::diagnose
