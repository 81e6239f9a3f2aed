// SPDX-License-Identifier: BSD-3-Clause
#include "fit/fit_numbers.hpp"

#include "fit/fit_model.hpp"

#include <algorithm>
#include <cmath>

namespace culm::fit {

Fit to_numbers(const Fit& fit) {
    Fit out = fit;
    out.parts.clear();
    out.system = {};
    out.covariance.resize(0, 0);
    if (fit.failed() && fit.reason.empty())
        out.reason = "there is no fit";
    return out;
}

Fit to_numbers_with_points(const Fit& fit) {
    Fit out = to_numbers(fit);
    for (const RecordingFit& part : fit.parts)
        out.points.push_back(known_point(part));
    return out;
}

double deviance(const Fit& fit) {
    double sum = 0.0;
    for (const Pull& pull : fit.pulls)
        sum += pull.value * pull.value;
    for (const RecordingMisfit& own : fit.misfits)
        sum += own.is_noise_known ? own.chi_squared
                                  : 2.0 * static_cast<double>(own.readings) * std::log(own.rmse);
    return sum;
}

StartModels models_of(const Fit& numbers, std::span<const ObservedRecording> recordings,
                      const FitOptions& options) {
    StartModels models;
    for (const ObservedRecording& recording : recordings)
        models.push_back(observed_model(numbers.effects, recording, options.chain));
    const JointLayout layout = joint_layout(models, recordings);
    for (std::size_t m = 0; m < models.size(); ++m)
        for (std::size_t k = 0; k < layout.shares[m].size(); ++k) {
            const auto [place, factor] = layout.shares[m][k];
            const auto found =
                std::ranges::find(numbers.parameters, layout.ids[place], &FittedParameter::id);
            if (found != numbers.parameters.end())
                models[m].set_value(k, factor * found->value);
        }
    return models;
}

Fit rerun(const Fit& numbers, std::span<const ObservedRecording> recordings,
          const FitOptions& options) {
    JointOptions here{options};
    here.largest_iterations = 0;
    here.is_held = !numbers.moves();
    here.with_inputs = numbers.moves() && options.with_inputs;
    const StartModels models = models_of(numbers, recordings, options);
    if (numbers.points.size() >= models.size()) // they may be those of more recordings
        here.known.assign(numbers.points.begin(), numbers.points.begin() + std::ssize(models));
    for (std::size_t m = 0; m < models.size() && !here.known.empty(); ++m) {
        const ChainPrediction& known = here.known[m].prediction;
        if (known.spheres != models[m].spec.stem.sphere_count ||
            known.parameters != models[m].free_count() ||
            known.readings.size() != recordings[m].deflections.size())
            here.known.clear();
    }
    Fit out = fit_jointly(models, recordings, std::move(here));
    out.status = numbers.status;
    out.reason = numbers.reason;
    out.effects = numbers.effects;
    return out;
}

} // namespace culm::fit
