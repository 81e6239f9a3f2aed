// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/ladder.hpp"

#include "diagnose/mere_noise.hpp"
#include "diagnose/naming.hpp"
#include "fit/solve/residual_statistics.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace culm::diagnose {
namespace {

std::vector<std::string> difference(const std::vector<std::string>& larger,
                                    const std::vector<std::string>& smaller) {
    std::vector<std::string> added;
    for (const std::string& name : larger)
        if (std::ranges::find(smaller, name) == smaller.end())
            added.push_back(name);
    return added;
}

bool belongs_to(const std::string& parameter, const std::string& effect) {
    return parameter.starts_with(effect + ".");
}

/// Empty if at least one size of the effect is known to be there.
std::string absence_not_excluded(const fit::RecordingFit& fit, const std::string& effect) {
    bool has_size = false;
    std::string text;
    for (const fit::FittedParameter& parameter : fit.parameters) {
        if (!belongs_to(parameter.name, effect) || parameter.is_place)
            continue;
        has_size = true;
        if (!is_absent(parameter))
            return {};
        const bool is_inverse = parameter.fitted_as == physics::FittedAs::Inverse;
        text = fmt::format("{} = {:.4g} ± {:.2g} {}is no different from {}", parameter.name,
                           parameter.value, interval_half_width(parameter),
                           parameter.unit.empty() ? "" : parameter.unit + " ",
                           is_inverse ? "an infinite one" : fmt::format("{:g}", parameter.absent));
    }
    return has_size ? text : std::string();
}

std::string parameter_at_bound(const fit::RecordingFit& fit,
                               const std::vector<std::string>& effects) {
    for (const fit::FittedParameter& parameter : fit.parameters)
        for (const std::string& effect : effects)
            if (parameter.is_at_bound && belongs_to(parameter.name, effect))
                return bound_text(parameter);
    return {};
}

/// Why the step from `before` to `rung` is no gain; empty if it is one. `below` is the fitted rung
/// below, `before` itself or refused: then what is new must earn its own keep too, and what was
/// refused already is not asked for its size again.
std::string objection(const Rung& rung, const Rung& before, const Rung& below) {
    const fit::RecordingFit& fit = rung.fit.parts.front();
    const std::vector<std::string> fresh = difference(rung.fit.names, below.fit.names);
    if (!(rung.delta_bic <= -naming_gain))
        return rung.delta_bic > 0.0 ? fmt::format("BIC rises by {:.1f}", rung.delta_bic)
                                    : fmt::format("BIC falls by {:.1f}, less than {:g}",
                                                  -rung.delta_bic, naming_gain);
    if (!(rung.bic - below.bic <= -naming_gain))
        return fmt::format("BIC {} by {:.1f} against {}, which was no gain",
                           rung.bic > below.bic ? "rises" : "falls", std::abs(rung.bic - below.bic),
                           fmt::join(below.fit.names, " + "));
    if (std::string bound = parameter_at_bound(fit, fresh); !bound.empty())
        return bound;
    for (const std::string& effect : fresh)
        if (std::string text = absence_not_excluded(fit, effect); !text.empty())
            return text;
    if (!rung.held_out || !before.held_out)
        return "nothing was held out";
    return held_out_obstacle(*rung.held_out, *before.held_out);
}

/// Which of the parts that were held out a gain predicts better.
std::string held_out_words(const HeldOut& larger, const HeldOut& smaller) {
    const bool is_time = is_predicted_better(larger.last_third, smaller.last_third);
    const HeldOutPart& after = is_time ? larger.last_third : larger.one_height;
    const HeldOutPart& before = is_time ? smaller.last_third : smaller.one_height;
    return fmt::format("the {} is predicted better ({:.2f} times the noise, before {:.2f})",
                       is_time ? "last third of the time" : "height that was left out",
                       after.over_noise, before.over_noise);
}

double relative_change(const fit::RecordingFit& now, const fit::RecordingFit& before,
                       const char* name) {
    const fit::FittedParameter* const a = now.find(name);
    const fit::FittedParameter* const b = before.find(name);
    return a == nullptr || b == nullptr ? 0.0 : a->value / b->value - 1.0;
}

/// The rung with the smallest χ², whose residuals are closest to the noise.
const fit::RecordingFit* best_fit(const Ladder& ladder) {
    const fit::RecordingFit* best = nullptr;
    for (const Rung& rung : ladder.rungs)
        if (!rung.fit.failed() && (best == nullptr || rung.fit.rmse < best->rmse))
            best = &rung.fit.parts.front();
    return best;
}

HoldOut what_to_hold_out(const Ladder& ladder) {
    const fit::RecordingFit* const best = best_fit(ladder);
    return best == nullptr ? HoldOut{} : hold_out_of(ladder.left_out_row, *best);
}

void score(Ladder& ladder) {
    const fit::RecordingFit* const best = best_fit(ladder);
    if (best == nullptr)
        return;
    ladder.effective_readings = fit::effective_readings(fit::whitened_residuals(*best));
    for (Rung& rung : ladder.rungs) {
        if (rung.fit.failed())
            continue;
        const fit::RecordingFit& fit = rung.fit.parts.front();
        // Where the noise is not known the residuals of the best rung stand for it.
        const double noise = std::pow(typical_noise(*best), 2);
        const double size = best->is_noise_known
                                ? fit.chi_squared / std::max(1.0, best->reduced_chi_squared)
                                : std::pow(fit.rmse, 2) / noise * static_cast<double>(fit.readings);
        const auto count = static_cast<double>(std::max<std::size_t>(fit.readings, 1));
        const auto numbers = static_cast<double>(rung.fit.moves() ? fit.prediction.parameters : 0);
        rung.bic = size * ladder.effective_readings / count +
                   numbers * std::log(std::max(ladder.effective_readings, 2.0));
    }
}

/// What `rung` is worth against `before`, the last that was a gain, and `below`, the last fitted.
void judge_step(Rung& rung, const Rung& before, const Rung& below) {
    rung.added = difference(rung.fit.names, before.fit.names);
    if (rung.fit.failed()) {
        rung.why = "failed: " + rung.fit.reason;
        return;
    }
    rung.delta_bic = rung.bic - before.bic;
    if (before.fit.moves()) {
        rung.modulus_change = relative_change(rung.fit.parts.front(), before.fit.parts.front(),
                                              "bond_youngs_modulus");
        rung.damping_change =
            relative_change(rung.fit.parts.front(), before.fit.parts.front(), "bond_damping");
    }
    rung.why =
        rung.fit.moves() ? objection(rung, before, below) : "nothing moves the stem in this model";
    rung.is_gain = rung.why.empty();
    if (rung.is_gain)
        rung.why = fmt::format("BIC falls by {:.0f}, {}", -rung.delta_bic,
                               held_out_words(*rung.held_out, *before.held_out));
}

void judge_steps(Ladder& ladder) {
    std::size_t accepted = 0;
    std::size_t below = 0;
    for (std::size_t k = 1; k < ladder.rungs.size(); ++k) {
        Rung& rung = ladder.rungs[k];
        rung.compared_with = accepted;
        judge_step(rung, ladder.rungs[accepted], ladder.rungs[below]);
        if (!rung.fit.failed())
            below = k;
        if (rung.is_gain)
            accepted = k;
    }
}

bool contains(const std::vector<std::string>& larger, const std::vector<std::string>& smaller) {
    return difference(smaller, larger).empty();
}

/// The largest fitted model within `names`; the baseline if there is none.
const fit::Fit& model_within(const std::vector<std::string>& names, const Ladder& ladder) {
    const fit::Fit* within = &ladder.rungs.front().fit;
    for (const Rung& rung : ladder.rungs)
        if (!rung.fit.failed() && contains(names, rung.fit.names))
            within = &rung.fit;
    return *within;
}

/// Throws what a model that cannot be throws, before any chain is run.
void refuse_impossible(const std::vector<fit::SelectedEffects>& models,
                       const measure::Measurement& measurement, const fit::FitOptions& options) {
    const fit::StemModel baseline = fit::baseline_model(measurement, options.chain);
    for (const fit::SelectedEffects& effects : models)
        (void)fit::candidate_model(baseline, effects, measurement);
}

} // namespace

Ladder climb(const measure::Measurement& measurement,
             const std::vector<fit::SelectedEffects>& models, const fit::FitOptions& options) {
    refuse_mere_noise(measurement, options.window);
    Ladder ladder;
    const std::span<const measure::Measurement> alone(&measurement, 1);
    refuse_impossible(models, measurement, options);
    ladder.rungs.emplace_back().fit = fit::fit_model({}, {}, alone, options);
    for (const fit::SelectedEffects& effects : models) {
        Rung rung;
        rung.fit = fit::fit_with_parts(effects, model_within(fit::model_names(effects), ladder),
                                       alone, options);
        ladder.rungs.push_back(std::move(rung));
    }
    if (!ladder.rungs.front().fit.failed())
        ladder.left_out_row = row_to_leave_out(ladder.rungs.front().fit.parts.front());
    const HoldOut hold_out = what_to_hold_out(ladder);
    for (Rung& rung : ladder.rungs) {
        ladder.comparison.push_back(std::nullopt);
        if (rung.fit.failed())
            continue;
        rung.held_out = predict_held_out(rung.fit, hold_out, measurement, options);
        ladder.comparison.back() = ladder.comparisons.size();
        ladder.comparisons.push_back(compare(rung.fit, measurement));
    }
    score(ladder);
    judge_steps(ladder);
    return ladder;
}

} // namespace culm::diagnose
