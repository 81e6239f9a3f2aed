// SPDX-License-Identifier: BSD-3-Clause
#include "fit/fit_model.hpp"

#include <algorithm>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace culm::fit {
namespace {

/// Has a number that `smaller` does not have come to nothing? Then the fit may have ended beside a
/// part of its model that explains more.
bool is_doubtful(const Fit& fit, const Fit& smaller) {
    return fit.failed() ||
           std::ranges::any_of(fit.parameters, [&](const FittedParameter& parameter) {
               const bool is_new =
                   std::ranges::find(smaller.parameters, parameter.id, &FittedParameter::id) ==
                   smaller.parameters.end();
               return is_new && !parameter.is_place &&
                      (parameter.is_at_bound || is_absent(parameter));
           });
}

bool is_worse(const Fit& fit, const Fit& part) {
    return fit.failed() || fit.weighted_rms > allowed_excess * part.weighted_rms;
}

} // namespace

Fit fit_with_parts(const SelectedEffects& effects, const Fit& smaller,
                   std::span<const ObservedRecording> recordings, const FitOptions& options) {
    Fit whole = fit_model(effects, smaller, recordings, options);
    const auto added = std::ranges::count_if(
        effects, [&](const auto& each) { return !contains(smaller.effects, each); });
    if (added < 2 || !is_doubtful(whole, smaller))
        return whole;
    std::optional<Fit> best;
    for (std::size_t k = 0; k < effects.size(); ++k) {
        if (contains(smaller.effects, effects[k]) || !has_fitted_number(*effects[k].effect))
            continue;
        SelectedEffects rest = effects;
        rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(k));
        // Effects that are added together may compensate each other from the first step on. From
        // the best of the smaller models only one of them is new.
        Fit part = fit_with_parts(rest, smaller, recordings, options);
        whole.runs += part.runs;
        if (part.is_fitted() && (!best || part.weighted_rms < best->weighted_rms))
            best = std::move(part);
    }
    if (!best || !is_worse(whole, *best))
        return whole;
    Fit again = fit_model(effects, *best, recordings, options);
    again.runs += whole.runs;
    if (is_worse(again, *best)) {
        again.reason =
            fmt::format("no start leads to a fit as good as that of {}, which it contains",
                        fmt::join(best->names, " + "));
        again.status = FitStatus::Failed;
        again.parts.clear();
    }
    return again;
}

} // namespace culm::fit
