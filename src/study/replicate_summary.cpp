// SPDX-License-Identifier: BSD-3-Clause
#include "study/replicate_summary.hpp"

#include "core/error.hpp"
#include "study/factor_groups.hpp"

#include <algorithm>
#include <cmath>

namespace culm::study {

namespace {

std::vector<double> finite(std::span<const double> values) {
    std::vector<double> kept;
    std::ranges::copy_if(values, std::back_inserter(kept),
                         [](double value) { return std::isfinite(value); });
    return kept;
}

/// Are all stems of one population? In a Latin hypercube or a Sobol sequence without replicates
/// every design point is a stem of it; elsewhere stems are compared with those of their point.
bool is_one_population(const StudyConfig& config) {
    return config.design.replicates == 1 && (config.design.type == DesignType::LatinHypercube ||
                                             config.design.type == DesignType::Sobol);
}

reduce::VarianceComponents components_of(const Study& study, std::span<const double> values) {
    const Design& design = study.design;
    std::vector<reduce::StemTests> stems;
    for (std::int64_t point = 0; point < design.point_count(); point += design.tests) {
        const auto tests = finite(values.subspan(static_cast<std::size_t>(point),
                                                 static_cast<std::size_t>(design.tests)));
        if (!tests.empty())
            stems.push_back({is_one_population(study.config)
                                 ? 0
                                 : static_cast<std::size_t>(point / design.replicates),
                             tests});
    }
    return reduce::variance_components(stems);
}

/// Sensitivities of both responses, or the reason why there are none.
void add_sensitivities(const Study& study, std::span<const double> decay_per_cycle,
                       std::span<const double> frequency, ReplicateSummary& summary) {
    if (study.config.design.type == DesignType::List) {
        summary.no_sensitivity_reason = "the points of a list have no distribution";
        return;
    }
    std::vector<std::int64_t> points;
    for (std::size_t point = 0; point < frequency.size(); ++point)
        if (std::isfinite(frequency[point]) && std::isfinite(decay_per_cycle[point]))
            points.push_back(static_cast<std::int64_t>(point));
    Eigen::MatrixXd responses(static_cast<Eigen::Index>(points.size()), 2);
    for (Eigen::Index row = 0; row < responses.rows(); ++row) {
        const auto point = static_cast<std::size_t>(points[static_cast<std::size_t>(row)]);
        responses.row(row) << decay_per_cycle[point], frequency[point];
    }
    std::vector<reduce::InputGroup> groups;
    for (const auto& factors : dependent_factors(study.config)) {
        groups.push_back(input_group(study, factors, points));
        FactorGroup group{groups.back().name, {}};
        for (const std::size_t factor : factors)
            group.factors.emplace_back(study.config.factors[factor].parameter->key);
        summary.groups.push_back(std::move(group));
    }
    try {
        auto found = reduce::analyse_sensitivity(groups, responses);
        for (std::size_t k = 0; k < found.size(); ++k)
            summary.responses[k].sensitivity = std::move(found[k]);
    } catch (const core::NumericalError& error) {
        summary.no_sensitivity_reason = error.what();
    }
}

} // namespace

std::optional<ReplicateSummary> summarise_replicates(const Study& study,
                                                     std::span<const double> decay_per_cycle,
                                                     std::span<const double> frequency) {
    if (study.config.factors.empty())
        return std::nullopt;
    ReplicateSummary summary;
    summary.has_distributions = std::ranges::any_of(study.config.factors, &Factor::is_redrawn);
    summary.responses.push_back({"decay_per_cycle", "1", {}, {}, {}});
    summary.responses.push_back({"frequency", "Hz", {}, {}, {}});
    const std::span<const double> values[] = {decay_per_cycle, frequency};
    for (std::size_t k = 0; k < summary.responses.size(); ++k) {
        summary.responses[k].population = reduce::summarise(finite(values[k]));
        if (study.design.tests > 1)
            summary.responses[k].components = components_of(study, values[k]);
    }
    add_sensitivities(study, decay_per_cycle, frequency, summary);
    return summary;
}

} // namespace culm::study
