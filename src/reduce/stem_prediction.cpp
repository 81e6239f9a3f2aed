// SPDX-License-Identifier: BSD-3-Clause
#include "reduce/stem_prediction.hpp"

#include "core/error.hpp"
#include "reduce/distributions.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <vector>

#include <fmt/format.h>

namespace culm::reduce {

namespace {

/// The law's slope along a predictor at the reading.
double slope_along(Term along, const LinearRegression& law, std::span<const Term> terms,
                   const StemReading& reading) {
    double slope = 0.0;
    for (std::size_t j = 0; j < terms.size(); ++j) {
        if (terms[j] == along)
            slope += law.coefficients[j].value;
        if (terms[j] == Term::Interaction)
            slope += law.coefficients[j].value *
                     (along == Term::First ? reading.frequency : reading.decay_per_cycle);
    }
    return slope;
}

Prediction predict_response(const LinearRegression& law, std::span<const Term> terms,
                            const StemReading& reading) {
    std::vector<double> regressors;
    for (const Term term : terms)
        regressors.push_back(term_value(term, reading.decay_per_cycle, reading.frequency));
    Prediction prediction = predict(law, regressors);
    const double reading_error = std::hypot(
        slope_along(Term::First, law, terms, reading) * reading.decay_per_cycle_standard_error,
        slope_along(Term::Second, law, terms, reading) * reading.frequency_standard_error);
    prediction.mean_standard_error = std::hypot(prediction.mean_standard_error, reading_error);
    prediction.standard_error = std::hypot(prediction.standard_error, reading_error);
    const double reach = student_t_factor(law.degrees_of_freedom) * prediction.standard_error;
    prediction.lower = prediction.value - reach;
    prediction.upper = prediction.value + reach;
    return prediction;
}

ParameterPrediction predict_parameter(const RegressionOutcome& outcome,
                                      const StemReading& reading) {
    ParameterPrediction result;
    if (!outcome.regression) {
        result.reason = outcome.reason;
        return result;
    }
    const SinglePredictorLaw& single = outcome.regression->single;
    const std::array single_terms = {Term::Intercept, single.predictor};
    result.by_single_law = predict_response(single.regression, single_terms, reading);
    if (outcome.regression->reduced) {
        const InteractionModel& model = outcome.regression->reduced->model;
        result.by_reduced_model = predict_response(model.regression, model.terms, reading);
    } else {
        result.reason = outcome.regression->no_reduced_reason;
    }
    return result;
}

/// From √Y to Y; empty, with a reason, where the root is not positive.
void square(std::optional<Prediction>& prediction, std::string& reason) {
    if (!prediction)
        return;
    if (prediction->value <= 0.0) {
        reason = fmt::format("the law gives a square root of Young's modulus of {:g}: the reading "
                             "lies far outside of the study",
                             prediction->value);
        prediction.reset();
        return;
    }
    const double root = prediction->value;
    const double lower = std::max(prediction->lower, 0.0);
    prediction = Prediction{root * root, 2.0 * root * prediction->mean_standard_error,
                            2.0 * root * prediction->standard_error, lower * lower,
                            prediction->upper * prediction->upper};
}

} // namespace

StemPrediction predict_stem(const StudyRegression& study, const StemReading& reading) {
    for (const double number :
         {reading.decay_per_cycle, reading.frequency, reading.decay_per_cycle_standard_error,
          reading.frequency_standard_error})
        if (!std::isfinite(number))
            throw core::NumericalError(
                core::FailureKind::FitFailed,
                fmt::format("the stem's reading (decay per cycle {:g}, frequency {:g} Hz) or its "
                            "standard errors are not finite",
                            reading.decay_per_cycle, reading.frequency));
    StemPrediction prediction;
    prediction.bond_youngs_modulus = predict_parameter(study.sqrt_youngs_modulus, reading);
    square(prediction.bond_youngs_modulus.by_single_law, prediction.bond_youngs_modulus.reason);
    square(prediction.bond_youngs_modulus.by_reduced_model, prediction.bond_youngs_modulus.reason);
    prediction.bond_damping = predict_parameter(study.bond_damping, reading);
    prediction.is_inside_design = study.decay_per_cycle.contains(reading.decay_per_cycle) &&
                                  study.frequency.contains(reading.frequency);
    return prediction;
}

} // namespace culm::reduce
