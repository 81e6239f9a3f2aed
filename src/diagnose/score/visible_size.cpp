// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/score/visible_size.hpp"

#include "core/error.hpp"
#include "fit/solve/layout.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace culm::diagnose {
namespace {

constexpr double visible_at = 3.0; ///< standard deviations
constexpr int most_runs = 6;       ///< to make sure of it
constexpr double same_size = 0.2;  ///< of its logarithm

bool is_factor(const fit::FreeParameter& parameter) {
    return parameter.absent > parameter.lower && parameter.absent > 0.0;
}

bool is_among(const physics::ParameterId& column, const StackedReadings& fitted) {
    return std::ranges::find(fitted.ids, column) != fitted.ids.end();
}

} // namespace

const fit::FreeParameter* parameter_of(const fit::StemModel& model,
                                       const physics::ParameterId& column) {
    for (const fit::FreeParameter& parameter : model.parameters)
        if (parameter.access.id == column.in_one_model())
            return &parameter;
    return nullptr;
}

Eigen::MatrixXd columns_of(const StackedReadings& fitted, const StackedReadings& stacked) {
    std::vector<Eigen::Index> old;
    for (std::size_t k = 0; k < stacked.ids.size(); ++k)
        if (is_among(stacked.ids[k], fitted))
            old.push_back(static_cast<Eigen::Index>(k));
    return stacked.jacobian(Eigen::all, old);
}

void VisibleSize::judge(const StackedReadings& stacked, const fit::StartModels& start) {
    if (absent_.empty()) {
        absent_ = start;
        absent_predicted_ = stacked.predicted;
    }
    for (std::size_t k = 0; k < stacked.ids.size(); ++k) {
        const fit::FreeParameter* const parameter = parameter_of(start.front(), stacked.ids[k]);
        if (is_among(stacked.ids[k], fitted_) || parameter == nullptr || parameter->is_place)
            continue;
        const Eigen::VectorXd derivative = stacked.jacobian.col(static_cast<Eigen::Index>(k));
        const Projection projection = project_off(columns_of(fitted_, stacked), derivative);
        // Readings are in units of their noise, so this norm is the gain √Δχ² per unit of the
        // parameter, and visible_at over it the size that stands out by so many deviations.
        const double standing_out = projection.standing_out.norm();
        const double at = parameter->access.get(start.front().spec);
        // The change of a compliance is that of the stiffness over −k².
        const double size = visible_at / standing_out /
                            (parameter->fitted_as == physics::FittedAs::Inverse ? at * at : 1.0);
        if (!(standing_out > least_standing_out * derivative.norm())) {
            if (score_.parameter.empty())
                name(*parameter);
        } else if (size < size_) {
            absent_ = start;
            absent_at_ = at;
            absent_predicted_ = stacked.predicted;
            const double change = value_of(*parameter, size) < at ? -1.0 : 1.0;
            keep(*parameter, size, projection,
                 change * visible_at / standing_out * projection.imitation);
        }
        return;
    }
}

void VisibleSize::settle(const fit::StartModels& default_start) {
    if (absent_.empty())
        return;
    const fit::FreeParameter* const found =
        parameter_of(absent_.front(), {score_.effect, score_.parameter, {}});
    if (found == nullptr)
        return;
    const fit::FreeParameter own = *found;
    absent_at_ = own.access.get(absent_.front().spec);
    // An effect that is even in its size (a camera's roll, cos) has no derivative where it is
    // absent: its signature grows with the square, from the default size down.
    double power = 1.0;
    double size = size_;
    Eigen::VectorXd imitated = imitated_;
    if (!is_known()) {
        power = 2.0;
        size = size_of(own, own.access.get(default_start.front().spec));
        imitated = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(fitted_.ids.size()));
    }
    // The signature grows as a power of the size, p = 1 where the first order tells and 2 where it
    // vanishes. Each run corrects both, as a secant does on logarithmic axes.
    double before = 0.0;
    double growth = 1.0;
    for (int run = 0; run < most_runs; ++run) {
        const double wanted = value_of(own, size);
        const double value = std::clamp(wanted, own.lower, own.upper);
        if (value != wanted) { // a run at the bound tells as well
            const double share = size_of(own, value) / size;
            imitated *= share;
            growth *= share;
            size *= share;
        }
        const Projection projection = trace(own, value, imitated);
        const double standing_out = projection.standing_out.norm();
        if (!(standing_out > 0.0))
            return;
        if (run > 0 && standing_out != before && growth != 1.0)
            power = std::clamp(std::log(standing_out / before) / std::log(growth), 0.5, 4.0);
        before = standing_out;
        growth = std::pow(visible_at / standing_out, 1.0 / power);
        imitated = growth * (imitated + projection.imitation);
        size *= growth;
        keep(own, size, projection, imitated);
        const bool is_impossible = value != wanted && score_.is_beyond_bounds;
        if (std::abs(std::log(growth)) < same_size || is_impossible)
            return;
    }
}

void VisibleSize::keep_fixed(const physics::EffectParameter& parameter, double value,
                             const Projection& projection) {
    const double standing_out = projection.standing_out.norm();
    if (value == 0.0 || !(standing_out > 0.0))
        return;
    score_.parameter = parameter.name;
    score_.unit = parameter.unit;
    score_.smallest_visible = std::abs(value) * visible_at / standing_out;
    score_.is_beyond_bounds = score_.smallest_visible > parameter.upper;
    keep_direction(projection, visible_at / standing_out * projection.imitation);
}

/// `size`: how far from its absence the effect is seen; `imitated`: the change of what is fitted
/// without it that does most of the same.
void VisibleSize::keep(const fit::FreeParameter& parameter, double size,
                       const Projection& projection, const Eigen::VectorXd& imitated) {
    name(parameter);
    size_ = size;
    score_.smallest_visible = value_of(parameter, size);
    score_.is_beyond_bounds =
        score_.smallest_visible < parameter.lower || score_.smallest_visible > parameter.upper;
    keep_direction(projection, imitated);
}

void VisibleSize::name(const fit::FreeParameter& parameter) {
    score_.parameter = parameter.access.id.name;
    score_.unit = parameter.unit;
    score_.smallest_visible = std::numeric_limits<double>::infinity();
    score_.is_beyond_bounds = true;
}

void VisibleSize::keep_direction(const Projection& projection, const Eigen::VectorXd& imitated) {
    const double norm = projection.standing_out.norm();
    score_.direction.assign(projection.standing_out.data(),
                            projection.standing_out.data() + projection.standing_out.size());
    for (double& entry : score_.direction)
        entry /= norm;
    imitated_ = imitated;
    score_.youngs_modulus_bias = bias(physics::bond_youngs_modulus);
    score_.damping_bias = bias(physics::bond_damping);
}

double VisibleSize::bias(const physics::ParameterId& id) const {
    const auto found = std::ranges::find(fitted_.ids, id);
    const fit::FittedParameter* const value = base_.parts.front().find(id);
    return found == fitted_.ids.end() || value == nullptr
               ? 0.0
               : imitated_(found - fitted_.ids.begin()) / value->value;
}

/// What a run with this value leaves once the other numbers are back where the fit without the
/// effect has moved them from, without derivatives, which take most of the time.
Projection VisibleSize::trace(const fit::FreeParameter& parameter, double value,
                              const Eigen::VectorXd& imitated) const {
    fit::StartModels models = without_imitation(imitated);
    for (fit::StemModel& model : models) {
        parameter.access.set(model.spec, value);
        model.parameters.clear();
    }
    const StackedReadings with = stacked_readings(models, recordings_, base_, options_.heartbeat);
    return project_off(fitted_.jacobian, with.predicted - absent_predicted_);
}

fit::StartModels VisibleSize::without_imitation(const Eigen::VectorXd& imitated) const {
    const fit::JointLayout layout =
        fit::joint_layout(absent_, recordings_, fit::belongs_to_recording);
    Eigen::VectorXd change = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(layout.ids.size()));
    for (std::size_t k = 0; k < layout.ids.size(); ++k)
        if (const auto old = std::ranges::find(fitted_.ids, layout.ids[k]);
            old != fitted_.ids.end())
            change(static_cast<Eigen::Index>(k)) = -imitated(old - fitted_.ids.begin());
    return moved(absent_, layout, change);
}

/// Of a stiffness the compliance is the size; a factor that is 1 without the effect is weakened.
double VisibleSize::value_of(const fit::FreeParameter& parameter, double size) const {
    if (parameter.fitted_as == physics::FittedAs::Inverse)
        return 1.0 / (1.0 / absent_at_ + size);
    return is_factor(parameter) ? parameter.absent * std::exp(-size) : parameter.absent + size;
}

double VisibleSize::size_of(const fit::FreeParameter& parameter, double value) const {
    if (parameter.fitted_as == physics::FittedAs::Inverse)
        return 1.0 / value - 1.0 / absent_at_;
    return is_factor(parameter) ? -std::log(value / parameter.absent) : value - parameter.absent;
}

} // namespace culm::diagnose
