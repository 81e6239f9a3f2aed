// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/criterion.hpp"

#include "fit/solve/residual_statistics.hpp"

#include <algorithm>
#include <cmath>

namespace culm::diagnose {
namespace {

double readings(const fit::Fit& model) {
    return static_cast<double>(std::max<std::size_t>(model.readings, 1));
}

/// Of each recording its χ², or what stands for it where only the residuals of the best model give
/// the noise: then χ² is the number of its readings whatever the model.
double misfit(const fit::Fit& model, const Criterion& criterion) {
    if (model.misfits.empty())
        return model.chi_squared / criterion.inflation;
    double known = 0.0;
    double unknown = 0.0;
    for (std::size_t m = 0; m < model.misfits.size(); ++m) {
        const fit::RecordingMisfit& own = model.misfits[m];
        const double ratio = m < criterion.rmse.size() ? own.rmse / criterion.rmse[m] : 1.0;
        if (own.is_noise_known)
            known += own.chi_squared;
        else
            unknown += ratio * ratio * static_cast<double>(own.readings);
    }
    return known / criterion.inflation + unknown;
}

const fit::Fit* better(const fit::Fit* best, const fit::Fit& model) {
    return model.is_fitted() && (best == nullptr || is_likelier(model, *best)) ? &model : best;
}

/// −2 ln L of the readings, less a constant.
double deviance(const fit::Fit& model) {
    if (model.misfits.empty())
        return model.chi_squared;
    double sum = 0.0;
    for (const fit::RecordingMisfit& own : model.misfits)
        sum += own.is_noise_known ? own.chi_squared
                                  : 2.0 * static_cast<double>(own.readings) * std::log(own.rmse);
    return sum;
}

Criterion criterion_of(const fit::Fit* best) {
    Criterion out;
    if (best == nullptr)
        return out;
    for (const fit::RecordingMisfit& misfit : best->misfits)
        out.rmse.push_back(misfit.rmse);
    out.inflation = std::max(1.0, best->reduced_chi_squared);
    out.effective_readings = std::max(best->effective_readings, 2.0);
    // Correlated residuals carry less evidence than their number says: χ² counts by the share of
    // the readings that are independent, and so does n of the penalty.
    out.share = std::min(1.0, out.effective_readings / readings(*best));
    return out;
}

} // namespace

bool is_likelier(const fit::Fit& one, const fit::Fit& other) {
    return deviance(one) < deviance(other);
}

Criterion criterion(std::span<const fit::Fit> models) {
    const fit::Fit* best = nullptr;
    for (const fit::Fit& model : models)
        best = better(best, model);
    return criterion_of(best);
}

Criterion criterion(const fit::Fit& one, std::span<const fit::Fit> others) {
    const fit::Fit* best = better(nullptr, one);
    for (const fit::Fit& model : others)
        best = better(best, model);
    return criterion_of(best);
}

double bic(const fit::Fit& model, const Criterion& criterion) {
    return misfit(model, criterion) * criterion.share +
           static_cast<double>(count_without_errors(model.parameters)) *
               std::log(criterion.effective_readings);
}

double gain_p_value(double gain, int added) {
    return fit::chi_squared_tail(std::max(gain, 0.0), std::max(added, 1));
}

double gain_p_value(const fit::Fit& smaller, const fit::Fit& larger, const Criterion& criterion) {
    return gain_p_value((misfit(smaller, criterion) - misfit(larger, criterion)) * criterion.share,
                        static_cast<int>(larger.parameters.size()) -
                            static_cast<int>(smaller.parameters.size()));
}

} // namespace culm::diagnose
