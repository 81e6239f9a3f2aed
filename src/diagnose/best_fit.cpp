// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/best_fit.hpp"

#include "calibrate/joint_layout.hpp"
#include "core/error.hpp"
#include "diagnose/model_fit.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/core.h>

namespace culm::diagnose {
namespace {

/// A larger model may end this much above the one that it contains: the runs have noise.
constexpr double allowed_excess = 1.001;
constexpr int screening_iterations = 3;
constexpr int most_restarts = 2;
/// Of χ², in units of the reduced χ²: worth another solution.
constexpr double needed_gain = 0.5;

/// Root mean square of residual over weight.
double weighted_rms(std::span<const calibrate::ChainFit> parts,
                    const std::vector<std::vector<double>>& weights) {
    double sum = 0.0;
    std::size_t count = 0;
    for (std::size_t m = 0; m < parts.size(); ++m)
        for (std::size_t place = 0; place < parts[m].residuals.size(); ++place)
            if (const double residual = parts[m].residuals[place]; !std::isnan(residual)) {
                const double scaled = residual / weights[m][place % parts[m].prediction.rows];
                sum += scaled * scaled;
                ++count;
            }
    return count > 0 ? std::sqrt(sum / static_cast<double>(count)) : 0.0;
}

/// Of the residuals, m.
double rms(std::span<const calibrate::ChainFit> parts) {
    double sum = 0.0;
    std::size_t count = 0;
    for (const calibrate::ChainFit& part : parts) {
        sum += part.rmse * part.rmse * static_cast<double>(part.readings);
        count += part.readings;
    }
    return count > 0 ? std::sqrt(sum / static_cast<double>(count)) : 0.0;
}

} // namespace

BestFit::BestFit(std::span<const measure::Measurement> recordings, const CandidateOptions& options,
                 std::vector<std::vector<double>> weights)
    : recordings_(recordings), options_(options), weights_(std::move(weights)) {}

void BestFit::try_start(const JointStart& start, bool is_first_guess) {
    ++starts_;
    try {
        calibrate::JointFit fit = solved(start, joint_options(is_first_guess));
        if (!fit.has_converged) // a long valley: half-way is no end
            fit = solved(start_from(fit), joint_options(false));
        fit = settled(std::move(fit));
        if (!fit.has_converged)
            failure_ = fit.reason;
        else if (!best_ || fit.weighted_rms < best_->weighted_rms)
            best_ = std::move(fit);
    } catch (const core::NumericalError& error) {
        failure_ = error.what();
    }
}

BegunFit BestFit::begin(const JointStart& start, bool is_first_guess) {
    calibrate::JointOptions few = joint_options(is_first_guess);
    few.chain.largest_iterations = screening_iterations;
    few.is_held = places(start);
    const calibrate::JointFit fit = solved(start, few);
    return {start_from(fit), fit.weighted_rms, fit.chi_squared};
}

void BestFit::go_on(std::vector<BegunFit> begun) {
    std::ranges::stable_sort(begun, {}, &BegunFit::weighted_rms);
    starts_ += static_cast<int>(begun.size());
    for (const BegunFit& fit : begun) {
        if (best_ &&
            !(fit.chi_squared <
              best_->chi_squared - needed_gain * std::max(1.0, best_->reduced_chi_squared)))
            break;
        try_start(fit.models, false);
        --starts_;
    }
}

void BestFit::try_starts(const std::vector<JointStart>& starts, bool is_first_guess) {
    if (starts.size() == 1)
        return try_start(starts.front(), is_first_guess);
    std::vector<BegunFit> begun;
    for (const JointStart& start : starts)
        try {
            begun.push_back(begin(start, is_first_guess));
        } catch (const core::NumericalError& error) {
            failure_ = error.what();
            ++starts_;
        }
    go_on(std::move(begun));
}

void BestFit::try_larger(const std::vector<JointStart>& starts,
                         std::optional<std::vector<BegunFit>> begun,
                         std::span<const calibrate::ChainFit> smaller, bool is_nested) {
    if (begun)
        go_on(std::move(*begun));
    else
        try_starts(starts, false);
    if (best_ && best_->out_of_reach)
        return; // wherever it ends is too far off
    if (!is_nested || !is_as_good_as(smaller))
        try_starts(starts, true);
    if (!is_nested || !best_ || is_as_good_as(smaller))
        return;
    failure_ = fmt::format("no start leads to a fit as good as that of the model it contains (rms "
                           "{:.4g} mm, without it {:.4g} mm)",
                           1e3 * best_->rmse, 1e3 * rms(smaller));
    best_.reset();
}

bool BestFit::is_as_good_as(std::span<const calibrate::ChainFit> smaller) const {
    return best_ && best_->weighted_rms <= allowed_excess * weighted_rms(smaller, best_->weights);
}

calibrate::JointFit BestFit::solved(const JointStart& start,
                                    const calibrate::JointOptions& options) {
    calibrate::JointFit fit = calibrate::fit_jointly(start, recordings_, options);
    runs_ += fit.runs;
    return fit;
}

/// Places, angles and time scales: while an effect has hardly any size they have hardly any
/// derivative, and a first step would throw them far away.
std::vector<bool> BestFit::places(const JointStart& start) const {
    const calibrate::JointLayout layout =
        calibrate::joint_layout(start, recordings_, belongs_to_recording);
    std::vector<bool> held;
    for (const calibrate::JointLayout::Owner& owner : layout.owners) {
        const std::vector<calibrate::FreeParameter>& parameters = start[owner.model].parameters;
        held.push_back(owner.parameter < parameters.size() && parameters[owner.parameter].is_place);
    }
    return held;
}

calibrate::JointOptions BestFit::joint_options(bool is_first_guess) const {
    calibrate::JointOptions joint;
    joint.chain.window = options_.window;
    joint.chain.is_first_guess = is_first_guess;
    joint.chain.wanted_chi_squared = options_.wanted_chi_squared;
    joint.chain.heartbeat = options_.heartbeat;
    joint.belongs_to_recording = belongs_to_recording;
    joint.weights = weights_;
    return joint;
}

/// A solution can end early where its steps meet a bound: it begins again from there, with the
/// parameters at a bound held, until that gains nothing.
calibrate::JointFit BestFit::settled(calibrate::JointFit fit) {
    for (int again = 0; again < most_restarts && !fit.out_of_reach; ++again) {
        calibrate::JointOptions options = joint_options(false);
        for (const calibrate::FittedParameter& parameter : fit.parameters)
            options.is_held.push_back(parameter.is_at_bound);
        if (std::ranges::none_of(options.is_held, [](bool held) { return held; }))
            break; // nothing was in the way of the steps
        calibrate::JointFit next = solved(start_from(fit), options);
        const double gain = fit.chi_squared - next.chi_squared;
        const bool is_settled = !(gain > needed_gain * std::max(1.0, next.reduced_chi_squared));
        // What is held has no covariance: the last solution without held ones is kept.
        if (next.has_converged && !is_settled)
            fit = std::move(next);
        if (is_settled)
            break;
    }
    return fit;
}

JointStart start_from(const calibrate::JointFit& fit) {
    JointStart start;
    for (const calibrate::ChainFit& part : fit.parts)
        start.push_back(part.model);
    return start;
}

} // namespace culm::diagnose
