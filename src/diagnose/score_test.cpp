// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/score_test.hpp"

#include "calibrate/joint_layout.hpp"
#include "core/error.hpp"
#include "diagnose/fit_starts.hpp"
#include "diagnose/null_noise.hpp"
#include "diagnose/stacked_readings.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/QR>

namespace culm::diagnose {
namespace {

constexpr double visible_at = 3.0; ///< standard deviations
constexpr int most_sizes = 6;      ///< runs that make sure of the smallest visible one
constexpr double same_size = 0.2;  ///< of its logarithm
constexpr int most_bounded = 4;    ///< parameters that are held in turn because they meet a bound
/// Part of a derivative that nothing imitates; less is rounding and the runs' own noise.
constexpr double least_standing_out = 1e-4;
/// Of Y in a start, within which it counts as the model as it is.
constexpr double largest_modulus_change = 0.1;

using Models = std::vector<calibrate::StemModel>;

const calibrate::FreeParameter* parameter_of(const calibrate::StemModel& model,
                                             const std::string& column) {
    const std::string name = column.substr(0, column.find('@'));
    for (const calibrate::FreeParameter& parameter : model.parameters)
        if (parameter.access.name == name)
            return &parameter;
    return nullptr;
}

class ScoreTest {
  public:
    ScoreTest(const ModelFit& base, const physics::SelectedEffect& effect,
              std::span<const measure::Measurement> recordings, const CandidateOptions& options)
        : base_(base), effect_(effect), recordings_(recordings), options_(options),
          fitted_(stacked_readings(base, recordings)) {
        for (std::size_t m = 0; m < recordings.size(); ++m)
            models_.push_back(candidate_model(base.parts[m].model, {effect}, recordings[m]));
    }

    [[nodiscard]] EffectScore run(int draws) {
        score_.effect = effect_.effect->name();
        if (!has_new_parameter()) {
            judge_fixed(draws);
            return score_;
        }
        std::vector<Models> absent = starts(StartSize::Absent);
        if (has_own_sizes(models_.front(), base_.parts.front()))
            absent.resize(1); // its places say nothing while it is absent
        for (const Models& start : absent)
            judge_start(start, draws);
        const bool vanishes = !(smallest_size_ < std::numeric_limits<double>::infinity());
        if (vanishes || draws > 0)
            settle_size();
        if (vanishes || has_own_sizes(models_.front(), base_.parts.front()))
            for (const Models& start : starts(StartSize::Told))
                judge_gain(compute(start), start);
        return score_;
    }

  private:
    [[nodiscard]] StackedReadings compute(const Models& models) const {
        return stacked_readings(models, recordings_, base_, options_.heartbeat);
    }
    /// Without derivatives, which take most of the time.
    [[nodiscard]] Eigen::VectorXd predicted(Models models) const {
        for (calibrate::StemModel& model : models)
            model.parameters.clear();
        return compute(models).predicted;
    }
    [[nodiscard]] bool is_new(const std::string& column) const {
        return std::ranges::find(fitted_.names, column) == fitted_.names.end();
    }
    [[nodiscard]] bool has_new_parameter() const {
        return models_.front().free_count() > base_.parts.front().model.free_count();
    }

    /// The k-th start of every recording together.
    [[nodiscard]] std::vector<Models> starts(StartSize size) const {
        std::vector<Models> all;
        for (std::size_t m = 0; m < models_.size(); ++m) {
            Models own = fit_starts(models_[m], base_.parts[m], size);
            all.resize(m == 0 ? own.size() : std::min(all.size(), own.size()));
            for (std::size_t k = 0; k < all.size(); ++k)
                all[k].push_back(std::move(own[k]));
        }
        return all;
    }

    void judge_start(const Models& start, int draws) {
        const StackedReadings stacked = compute(start);
        if (absent_.empty()) {
            absent_ = start;
            absent_predicted_ = stacked.predicted;
        }
        judge_gain(stacked, start);
        // Only beside the model as it is; a clamp as soft as its friction would need is another.
        const double modulus = base_.parts.front().model.spec.stem.bond_youngs_modulus;
        if (std::abs(start.front().spec.stem.bond_youngs_modulus / modulus - 1.0) <
            largest_modulus_change)
            judge_size(stacked, start);
        judge_noise(stacked, start, draws);
    }

    /// The gain of one linear step from here that stays within the effect's bounds.
    void judge_gain(const StackedReadings& stacked, const Models& start) {
        std::vector<bool> is_held(stacked.names.size(), false);
        LinearSolution solution = solve_linear(stacked, is_held);
        for (int pass = 0; pass < most_bounded; ++pass) {
            bool is_inside = true;
            for (std::size_t k = 0; k < stacked.names.size(); ++k)
                if (const double change = solution.change(static_cast<Eigen::Index>(k));
                    is_new(stacked.names[k]) && !is_held[k] &&
                    (leaves_bounds(start, stacked.names[k], change) ||
                     oversteps(start, stacked.names[k], change))) {
                    is_held[k] = true;
                    is_inside = false;
                }
            if (is_inside)
                break;
            solution = solve_linear(stacked, is_held);
        }
        score_.added = static_cast<int>(stacked.names.size() - fitted_.names.size());
        score_.gain = std::max(score_.gain, fitted_.residual.squaredNorm() - solution.left);
    }

    [[nodiscard]] static bool leaves_bounds(const Models& start, const std::string& column,
                                            double change) {
        const calibrate::StemModel& model = start.front();
        const calibrate::FreeParameter* const parameter = parameter_of(model, column);
        if (parameter == nullptr || parameter->is_place)
            return false;
        const double value = parameter->access.get(model.spec);
        return (value <= parameter->lower && change < 0.0) ||
               (value >= parameter->upper && change > 0.0);
    }

    /// A step from a size of its own that would end beyond the bounds, at a negative mass say.
    [[nodiscard]] static bool oversteps(const Models& start, const std::string& column,
                                        double change) {
        const calibrate::StemModel& model = start.front();
        const calibrate::FreeParameter* const parameter = parameter_of(model, column);
        if (parameter == nullptr || parameter->is_place ||
            parameter->fitted_as != physics::FittedAs::Itself)
            return false;
        const double value = parameter->access.get(model.spec);
        return value > parameter->lower && value < parameter->upper &&
               (value + change < parameter->lower || value + change > parameter->upper);
    }

    /// Columns of what is fitted without the effect, at this start.
    [[nodiscard]] Eigen::MatrixXd old_columns(const StackedReadings& stacked) const {
        std::vector<Eigen::Index> old;
        for (std::size_t k = 0; k < stacked.names.size(); ++k)
            if (!is_new(stacked.names[k]))
                old.push_back(static_cast<Eigen::Index>(k));
        return stacked.jacobian(Eigen::all, old);
    }

    /// The size at which the first of the effect's sizes is seen, if its first order tells.
    void judge_size(const StackedReadings& stacked, const Models& start) {
        for (std::size_t k = 0; k < stacked.names.size(); ++k) {
            const calibrate::FreeParameter* const parameter =
                parameter_of(start.front(), stacked.names[k]);
            if (!is_new(stacked.names[k]) || parameter == nullptr || parameter->is_place)
                continue;
            const Eigen::VectorXd derivative = stacked.jacobian.col(static_cast<Eigen::Index>(k));
            const Projection projection = project_off(old_columns(stacked), derivative);
            const double standing_out = projection.standing_out.norm();
            const double at = parameter->access.get(start.front().spec);
            // The change of a compliance is that of the stiffness over −k².
            const double size =
                visible_at / standing_out /
                (parameter->fitted_as == physics::FittedAs::Inverse ? at * at : 1.0);
            if (!(standing_out > least_standing_out * derivative.norm())) {
                if (score_.parameter.empty())
                    name_size(*parameter);
            } else if (size < smallest_size_) {
                const double change = value_of(*parameter, at, size) < at ? -1.0 : 1.0;
                keep_size(*parameter, at, size, projection,
                          change * visible_at / standing_out * projection.imitation);
                absent_ = start;
                absent_predicted_ = stacked.predicted;
            }
            return;
        }
    }

    void name_size(const calibrate::FreeParameter& parameter) {
        score_.parameter = parameter.access.name.substr(score_.effect.size() + 1);
        score_.unit = parameter.unit;
        score_.smallest_visible = std::numeric_limits<double>::infinity();
        score_.is_beyond_bounds = true;
    }

    /// The value of a parameter that is `size` away from its absence at `at`. Of a stiffness the
    /// compliance is the size; a factor that is 1 without the effect is weakened.
    [[nodiscard]] static double value_of(const calibrate::FreeParameter& parameter, double at,
                                         double size) {
        if (parameter.fitted_as == physics::FittedAs::Inverse)
            return 1.0 / (1.0 / at + size);
        return parameter.absent > parameter.lower && parameter.absent > 0.0
                   ? parameter.absent * std::exp(-size)
                   : parameter.absent + size;
    }

    [[nodiscard]] static double size_of(const calibrate::FreeParameter& parameter, double at,
                                        double value) {
        if (parameter.fitted_as == physics::FittedAs::Inverse)
            return 1.0 / value - 1.0 / at;
        return parameter.absent > parameter.lower && parameter.absent > 0.0
                   ? -std::log(value / parameter.absent)
                   : value - parameter.absent;
    }

    /// `size`: how far from its absence the effect is seen; `imitated`: the change of what is
    /// fitted without it that does most of the same.
    void keep_size(const calibrate::FreeParameter& parameter, double at, double size,
                   const Projection& projection, const Eigen::VectorXd& imitated) {
        name_size(parameter);
        smallest_size_ = size;
        score_.smallest_visible = value_of(parameter, at, size);
        score_.is_beyond_bounds =
            score_.smallest_visible < parameter.lower || score_.smallest_visible > parameter.upper;
        keep_direction(projection, imitated);
    }

    void keep_direction(const Projection& projection, const Eigen::VectorXd& imitated) {
        const double norm = projection.standing_out.norm();
        score_.direction.assign(projection.standing_out.data(),
                                projection.standing_out.data() + projection.standing_out.size());
        for (double& entry : score_.direction)
            entry /= norm;
        imitated_ = imitated;
        score_.youngs_modulus_bias = bias("bond_youngs_modulus");
        score_.damping_bias = bias("bond_damping");
    }
    [[nodiscard]] double bias(const char* name) const {
        const auto found = std::ranges::find(fitted_.names, name);
        if (found == fitted_.names.end())
            return 0.0;
        const calibrate::FittedParameter* const value = base_.parts.front().find(name);
        return value == nullptr ? 0.0 : imitated_(found - fitted_.names.begin()) / value->value;
    }

    /// Takes back what the fit without the effect does to hide it.
    void take_back(const Eigen::VectorXd& imitated, Models& models) const {
        const calibrate::JointLayout layout =
            calibrate::joint_layout(models, recordings_, belongs_to_recording);
        for (std::size_t m = 0; m < models.size(); ++m)
            for (std::size_t k = 0; k < layout.shares[m].size(); ++k) {
                const calibrate::JointLayout::Share& share = layout.shares[m][k];
                const auto old = std::ranges::find(fitted_.names, layout.names[share.place]);
                if (old == fitted_.names.end())
                    continue;
                const double change = -share.factor * imitated(old - fitted_.names.begin());
                if (k == models[m].parameters.size()) {
                    models[m].release_time += change;
                    continue;
                }
                const calibrate::FreeParameter& own = models[m].parameters[k];
                own.access.set(models[m].spec, std::clamp(own.access.get(models[m].spec) + change,
                                                          own.lower, own.upper));
            }
    }

    void judge_noise(const StackedReadings& stacked, const Models& start, int draws) {
        if (draws == 0)
            return;
        const Eigen::MatrixXd old = old_columns(stacked);
        std::vector<Eigen::VectorXd> added;
        bool is_one_sided = false;
        for (std::size_t k = 0; k < stacked.names.size(); ++k) {
            if (!is_new(stacked.names[k]))
                continue;
            const Eigen::VectorXd column = stacked.jacobian.col(static_cast<Eigen::Index>(k));
            const Eigen::VectorXd own = project_off(old, column).standing_out;
            if (!(own.norm() > least_standing_out * column.norm()))
                continue;
            added.push_back(own / own.norm());
            is_one_sided = leaves_bounds(start, stacked.names[k], -1.0) ||
                           leaves_bounds(start, stacked.names[k], 1.0);
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
            const Eigen::VectorXd seen = basis.transpose() * noise_.col(draw);
            const bool counts = !(is_one_sided && added.size() == 1) || seen(0) > 0.0;
            double& gain = score_.null_gains[static_cast<std::size_t>(draw)];
            gain = std::max(gain, counts ? seen.squaredNorm() : 0.0);
        }
    }

    /// An effect without a number to fit: there, or not.
    void judge_fixed(int draws) {
        const StackedReadings with = compute(starts(StartSize::Default).front());
        score_.gain =
            std::max(0.0, fitted_.residual.squaredNorm() -
                              solve_linear(with, std::vector<bool>(with.names.size())).left);
        const StackedReadings added = compute(models_);
        const Projection projection =
            project_off(fitted_.jacobian, added.predicted - fitted_.predicted);
        const double standing_out = projection.standing_out.norm();
        const std::vector<physics::EffectParameter> parameters = effect_.effect->parameters();
        const std::vector<double>& values = models_.front().spec.effects.back().values;
        const auto largest =
            std::ranges::max_element(values, {}, [](double value) { return std::abs(value); });
        if (largest != values.end() && *largest != 0.0 && standing_out > 0.0) {
            const physics::EffectParameter& parameter =
                parameters[static_cast<std::size_t>(largest - values.begin())];
            score_.parameter = parameter.name;
            score_.unit = parameter.unit;
            score_.smallest_visible = std::abs(*largest) * visible_at / standing_out;
            score_.is_beyond_bounds = score_.smallest_visible > parameter.upper;
            keep_direction(projection, visible_at / standing_out * projection.imitation);
        }
        if (draws > 0)
            score_.null_gains.assign(static_cast<std::size_t>(draws), 0.0);
    }

    /// Runs of the size at which the effect should be seen: its trace need not grow in proportion,
    /// as that of two planes of bending, which grows with the square. Where the first order tells
    /// nothing, from the default size on.
    void settle_size() {
        const calibrate::FreeParameter* const found =
            parameter_of(absent_.front(), score_.effect + "." + score_.parameter);
        if (found == nullptr)
            return;
        const calibrate::FreeParameter own = *found;
        const double at = own.access.get(absent_.front().spec);
        const bool is_linear = smallest_size_ < std::numeric_limits<double>::infinity();
        double size = smallest_size_;
        Eigen::VectorXd imitated = imitated_;
        if (!is_linear) {
            size = own.access.get(starts(StartSize::Default).front().front().spec) - at;
            imitated = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(fitted_.names.size()));
        }
        double before = 0.0;
        double power = is_linear ? 1.0 : 2.0;
        double growth = 1.0;
        for (int pass = 0; pass < most_sizes; ++pass) {
            const double wanted = value_of(own, at, size);
            const double value = std::clamp(wanted, own.lower, own.upper);
            if (value != wanted) { // at a bound the power is learnt as well
                const double possible = size_of(own, at, value);
                imitated *= possible / size;
                growth *= possible / size;
                size = possible;
            }
            Models models = absent_;
            take_back(imitated, models);
            for (calibrate::StemModel& model : models)
                own.access.set(model.spec, value);
            const Projection projection =
                project_off(fitted_.jacobian, predicted(std::move(models)) - absent_predicted_);
            const double standing_out = projection.standing_out.norm();
            if (!(standing_out > 0.0))
                return;
            if (pass > 0 && standing_out != before && growth != 1.0)
                power = std::clamp(std::log(standing_out / before) / std::log(growth), 0.5, 4.0);
            before = standing_out;
            growth = std::pow(visible_at / standing_out, 1.0 / power);
            imitated = growth * (imitated + projection.imitation);
            keep_size(own, at, size * growth, projection, imitated);
            const bool is_possible = value == wanted || !score_.is_beyond_bounds;
            if (std::abs(std::log(growth)) < same_size || !is_possible)
                return;
            size *= growth;
        }
    }

    const ModelFit& base_;
    const physics::SelectedEffect& effect_;
    std::span<const measure::Measurement> recordings_;
    const CandidateOptions& options_;
    StackedReadings fitted_;
    Models models_;
    Eigen::MatrixXd noise_; ///< (readings, draws); drawn when the first start needs it
    EffectScore score_;
    double smallest_size_ = std::numeric_limits<double>::infinity(); ///< away from its absence
    Models absent_; ///< the start that has told it, else the first
    Eigen::VectorXd absent_predicted_;
    Eigen::VectorXd
        imitated_; ///< change of the fitted numbers that hides the smallest visible size
};

} // namespace

EffectScore score_effect(const ModelFit& base, const physics::SelectedEffect& effect,
                         std::span<const measure::Measurement> recordings,
                         const CandidateOptions& options, int draws) {
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
