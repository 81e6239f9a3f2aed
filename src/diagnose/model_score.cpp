// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/model_score.hpp"

#include "fit/solve/residual_statistics.hpp"
#include "reduce/distributions.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/core.h>

namespace culm::diagnose {
namespace {

double readings(const fit::Fit& model) {
    return static_cast<double>(std::max<std::size_t>(model.readings, 1));
}

/// Of each recording its χ², or what stands for it where only the residuals of the best model give
/// the noise: then χ² is the number of its readings whatever the model.
double misfit(const fit::Fit& model, const Yardstick& yardstick) {
    if (model.misfits.empty())
        return model.chi_squared / yardstick.inflation;
    double known = 0.0;
    double unknown = 0.0;
    for (std::size_t m = 0; m < model.misfits.size(); ++m) {
        const fit::RecordingMisfit& own = model.misfits[m];
        const double ratio = m < yardstick.rmse.size() ? own.rmse / yardstick.rmse[m] : 1.0;
        if (own.is_noise_known)
            known += own.chi_squared;
        else
            unknown += ratio * ratio * static_cast<double>(own.readings);
    }
    return known / yardstick.inflation + unknown;
}

} // namespace

double interval_half_width(const fit::FittedParameter& parameter) {
    return reduce::normal_quantile_95 * parameter.standard_error;
}

bool is_absent(const fit::FittedParameter& parameter) {
    return !(std::abs(parameter.value - parameter.absent) > interval_half_width(parameter));
}

std::string bound_text(const fit::FittedParameter& parameter) {
    return fmt::format("{} stands at its bound, {:.4g}{}{}", parameter.name, parameter.value,
                       parameter.unit.empty() ? "" : " ", parameter.unit);
}

Yardstick yardstick(std::span<const fit::Fit> models) {
    const fit::Fit* best = nullptr;
    for (const fit::Fit& model : models)
        if (model.is_fitted() && (best == nullptr || model.rmse < best->rmse))
            best = &model;
    Yardstick out;
    if (best == nullptr)
        return out;
    for (const fit::RecordingMisfit& misfit : best->misfits)
        out.rmse.push_back(misfit.rmse);
    out.inflation = std::max(1.0, best->reduced_chi_squared);
    out.effective_readings = std::max(best->effective_readings, 2.0);
    out.share = std::min(1.0, out.effective_readings / readings(*best));
    return out;
}

double bic(const fit::Fit& model, const Yardstick& yardstick) {
    return misfit(model, yardstick) * yardstick.share +
           static_cast<double>(model.parameters.size()) * std::log(yardstick.effective_readings);
}

double gain_p_value(double gain, int added) {
    return fit::chi_squared_tail(std::max(gain, 0.0), std::max(added, 1));
}

double gain_p_value(const fit::Fit& smaller, const fit::Fit& larger, const Yardstick& yardstick) {
    return gain_p_value((misfit(smaller, yardstick) - misfit(larger, yardstick)) * yardstick.share,
                        static_cast<int>(larger.parameters.size()) -
                            static_cast<int>(smaller.parameters.size()));
}

bool is_rival(const fit::Fit& fit, const std::string& effect) {
    if (!fit.is_fitted())
        return false;
    bool has_size = false;
    bool is_there = false;
    for (const fit::FittedParameter& parameter : fit.parameters) {
        if (!parameter.name.starts_with(effect + ".") || parameter.is_place)
            continue;
        has_size = true;
        is_there = is_there || !is_absent(parameter);
    }
    return is_there || !has_size;
}

std::string naming_obstacle(const fit::Fit& fit, const std::string& effect) {
    if (fit.failed())
        return fit.reason;
    if (!fit.moves())
        return "nothing moves the stem in this model";
    bool has_size = false;
    bool is_there = false;
    std::string bound;
    std::string absent;
    for (const fit::FittedParameter& parameter : fit.parameters) {
        if (!parameter.name.starts_with(effect + "."))
            continue;
        const bool is_size = !parameter.is_place;
        has_size = has_size || is_size;
        const bool stands_absent = is_size && is_absent(parameter);
        is_there = is_there || (is_size && !parameter.is_at_bound && !stands_absent);
        if (parameter.is_at_bound)
            bound = bound_text(parameter);
        else if (stands_absent)
            absent = fmt::format("{} = {:.4g} ± {:.2g} is no different from none", parameter.name,
                                 parameter.value, interval_half_width(parameter));
    }
    const bool has_own_sizes = bound.find('@') != std::string::npos;
    if (!bound.empty() && !(has_own_sizes && is_there))
        return bound;
    return has_size && !is_there ? absent : std::string();
}

} // namespace culm::diagnose
