// SPDX-License-Identifier: BSD-3-Clause
#include "fit/fit_numbers.hpp"

#include "fit/solve/layout.hpp"
#include "fit/solve/reading_errors.hpp"
#include "fit/solve/residual_statistics.hpp"
#include "fit/solve/second_mode_errors.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace culm::fit {
Fit numbers_of(const Fit& fit) {
    Fit out = fit;
    for (const RecordingFit& part : fit.parts) {
        std::vector<ReadingErrors::Term>& terms = out.model_terms.emplace_back();
        if (part.model.errors)
            std::ranges::copy_if(part.model.errors->terms, std::back_inserter(terms),
                                 &ReadingErrors::Term::is_of_model);
    }
    out.parts.clear();
    out.places.clear();
    out.noise.clear();
    out.covariance.resize(0, 0);
    if (fit.failed() && fit.reason.empty())
        out.reason = "there is no fit";
    return out;
}

double deviance(const Fit& fit) {
    if (fit.misfits.empty())
        return fit.chi_squared;
    double sum = 0.0;
    for (const RecordingMisfit& own : fit.misfits)
        sum += own.is_noise_known ? own.chi_squared
                                  : 2.0 * static_cast<double>(own.readings) * std::log(own.rmse);
    return sum;
}

std::vector<StemModel> models_of(const Fit& numbers, std::span<const ObservedRecording> recordings,
                                 const FitOptions& options) {
    std::vector<StemModel> models;
    for (std::size_t m = 0; m < recordings.size(); ++m)
        models.push_back(observed_model(
            numbers.effects,
            m < numbers.model_terms.size() ? with_model_terms(recordings[m], numbers.model_terms[m])
                                           : recordings[m],
            options.chain));
    const JointLayout layout = joint_layout(models, recordings);
    for (std::size_t m = 0; m < models.size(); ++m)
        for (std::size_t k = 0; k < layout.shares[m].size(); ++k) {
            const auto [place, factor] = layout.shares[m][k];
            const auto told =
                std::ranges::find(numbers.parameters, layout.ids[place], &FittedParameter::id);
            if (told != numbers.parameters.end())
                models[m].set_value(k, factor * told->value);
        }
    return models;
}

// One run per recording with all parameters fixed is cheaper than sending residuals and Jacobians,
// and every rank obtains the same bits.
Fit restored(const Fit& numbers, std::span<const ObservedRecording> recordings,
             const FitOptions& options) {
    Fit out = numbers;
    out.model_terms.clear();
    out.runs = static_cast<int>(recordings.size());
    const std::vector<StemModel> models = models_of(numbers, recordings, options);
    const JointLayout layout = joint_layout(models, recordings);
    for (std::size_t m = 0; m < models.size(); ++m) {
        out.parts.push_back(fit_chain_with_held(models[m], recordings[m],
                                                std::vector<bool>(models[m].free_count(), true),
                                                options.solve()));
        std::vector<std::size_t>& places = out.places.emplace_back();
        for (std::size_t k = 0; k < layout.shares[m].size(); ++k) {
            const JointLayout::Share& share = layout.shares[m][k];
            const auto found =
                std::ranges::find(out.parameters, layout.ids[share.place], &FittedParameter::id);
            places.push_back(static_cast<std::size_t>(found - out.parameters.begin()));
            if (found == out.parameters.end())
                continue;
            FittedParameter& own = out.parts[m].parameters[k];
            own.standard_error = share.factor * found->standard_error;
            own.is_at_bound = found->is_at_bound;
        }
    }
    return out;
}

} // namespace culm::fit
