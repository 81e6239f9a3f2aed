// SPDX-License-Identifier: BSD-3-Clause
#include "study/summary_json.hpp"

#include <cmath>

namespace culm::study {
namespace {

using nlohmann::json;

json interval(const reduce::Coefficient& coefficient) {
    return json::array({number_json(coefficient.lower), number_json(coefficient.upper)});
}

json histogram(const reduce::ResidualSummary& residuals) {
    return {{"edges", residuals.histogram.edges}, {"counts", residuals.histogram.counts}};
}

} // namespace

json number_json(double value) {
    return std::isfinite(value) ? json(value) : json(nullptr);
}

json term_json(const reduce::Coefficient& coefficient) {
    return {{"term", coefficient.name},
            {"coefficient", number_json(coefficient.value)},
            {"standard_error", number_json(coefficient.standard_error)},
            {"interval", interval(coefficient)},
            {"p_value", number_json(coefficient.p_value)}};
}

json to_json(const reduce::RegressionOutcome& outcome, const char* predictor, const char* unit) {
    if (!outcome.regression)
        return {{"reason", outcome.reason}};
    const reduce::ResponseRegression& response = *outcome.regression;
    json out{
        {"predictor", predictor},
        {"unit", unit},
        {"points", response.points},
        {"intercept", number_json(response.single.intercept.value)},
        {"slope", number_json(response.single.slope.value)},
        {"interval",
         {{"intercept", interval(response.single.intercept)},
          {"slope", interval(response.single.slope)}}},
        {"adjusted_r2", number_json(response.single.regression.adjusted_r_squared)},
        {"residuals_percent", histogram(response.single.residuals)},
    };
    json terms = json::array();
    if (response.reduced) {
        for (const auto& coefficient : response.reduced->model.regression.coefficients)
            terms.push_back(term_json(coefficient));
        out["terms_adjusted_r2"] =
            number_json(response.reduced->model.regression.adjusted_r_squared);
        out["adjusted_r2_full"] = number_json(response.reduced->model.full_adjusted_r_squared);
        out["terms_residuals_percent"] = histogram(response.reduced->residuals);
        const auto& test = response.reduced->single_predictor_against_full;
        out["single_against_full"] = {{"f", number_json(test.f_statistic)},
                                      {"p_value", number_json(test.p_value)}};
    } else {
        out["terms_reason"] = response.no_reduced_reason;
    }
    out["terms"] = terms;
    return out;
}

json to_json(const StudySummary& summary) {
    json failed = json::array();
    for (const FailedPoint& point : summary.failed)
        failed.push_back({{"point", point.point}, {"kind", point.kind}, {"reason", point.reason}});
    json out{
        {"points", summary.points},
        {"completed", summary.completed},
        {"failed", failed},
        {"ranks", summary.ranks},
        {"wall_s", summary.wall_s},
        {"fit",
         {{"window_s", summary.reduce.window ? json(*summary.reduce.window) : json(nullptr)},
          {"amplitude", summary.reduce.is_amplitude_free ? "free" : "fixed"},
          {"significance", summary.reduce.significance}}},
        {"regression",
         {{"sqrt_youngs_modulus",
           to_json(summary.regression.sqrt_youngs_modulus, "frequency", "sqrt(Pa)")},
          {"bond_damping", to_json(summary.regression.bond_damping, "decay_per_cycle", "1")}}}};
    if (summary.replicates)
        add_to_json(out, *summary.replicates);
    return out;
}

} // namespace culm::study
