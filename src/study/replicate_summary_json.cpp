// SPDX-License-Identifier: BSD-3-Clause
// The spread of a study's stems as part of summary.json.
#include "study/replicate_summary.hpp"
#include "study/summary_json.hpp"

namespace culm::study {

namespace {

using nlohmann::json;

json bounds(const reduce::Bounds& interval) {
    return json::array({number_json(interval.lower), number_json(interval.upper)});
}

json to_json(const reduce::SampleSummary& population) {
    return {{"points", population.count},
            {"mean", number_json(population.mean)},
            {"mean_interval", bounds(population.mean_interval)},
            {"standard_deviation", number_json(population.standard_deviation)},
            {"standard_deviation_interval", bounds(population.standard_deviation_interval)},
            {"median", number_json(population.median)},
            {"central_90_percent", bounds(population.central_90_percent)},
            {"lowest", number_json(population.lowest)},
            {"highest", number_json(population.highest)}};
}

json to_json(const reduce::VarianceComponents& c) {
    json out{{"stems", c.stems},
             {"tests", c.tests},
             {"between",
              {{"variance", number_json(c.between)},
               {"interval", bounds(c.between_interval)},
               {"degrees_of_freedom", c.between_degrees_of_freedom}}},
             {"within",
              {{"variance", number_json(c.within)},
               {"interval", bounds(c.within_interval)},
               {"degrees_of_freedom", c.within_degrees_of_freedom}}},
             {"intraclass_correlation",
              {{"value", number_json(c.intraclass_correlation)},
               {"interval", bounds(c.intraclass_interval)}}},
             {"f", number_json(c.f_statistic)},
             {"p_value", number_json(c.p_value)}};
    if (!c.reason.empty())
        out["reason"] = c.reason;
    return out;
}

json to_json(const reduce::Share& share) {
    return {{"value", number_json(share.value)}, {"interval", bounds(share.interval)}};
}

json to_json(const reduce::Sensitivity& sensitivity) {
    json indices = json::array();
    for (const reduce::GroupSensitivity& group : sensitivity.groups)
        indices.push_back({{"group", group.name},
                           {"first_order", to_json(group.first_order)},
                           {"total", to_json(group.total)}});
    return {{"points", sensitivity.points},
            {"degree", sensitivity.degree},
            {"terms", sensitivity.terms},
            {"predicted_share", number_json(sensitivity.predicted_share)},
            {"mean", number_json(sensitivity.mean)},
            {"standard_deviation", number_json(sensitivity.standard_deviation)},
            {"interactions", number_json(sensitivity.interactions)},
            {"indices", indices}};
}

} // namespace

void add_to_json(json& out, const ReplicateSummary& summary) {
    json population = json::object();
    json components = json::object();
    json sensitivity = json::object();
    for (const ResponseSpread& response : summary.responses) {
        population[response.name] = to_json(response.population);
        if (response.components)
            components[response.name] = to_json(*response.components);
        if (response.sensitivity)
            sensitivity[response.name] = to_json(*response.sensitivity);
    }
    out["population"] = population;
    if (!components.empty()) {
        components["method"] = "one-way random effects, unweighted means";
        out["variance_components"] = components;
    }
    if (!summary.no_sensitivity_reason.empty()) {
        out["sensitivity"] = {{"reason", summary.no_sensitivity_reason}};
        return;
    }
    json groups = json::array();
    for (const FactorGroup& group : summary.groups)
        groups.push_back({{"name", group.name}, {"factors", group.factors}});
    sensitivity["method"] = "polynomial chaos, degree by leave-one-out error";
    sensitivity["groups"] = groups;
    out["sensitivity"] = sensitivity;
}

} // namespace culm::study
