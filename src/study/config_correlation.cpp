// SPDX-License-Identifier: BSD-3-Clause
// The section [correlation] of a study file.
#include "core/error.hpp"
#include "study/config_context.hpp"
#include "study/config_hints.hpp"
#include "study/config_reader.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace culm::study {

namespace {

/// The factors named, by their places; nothing with the errors recorded.
std::optional<std::vector<std::size_t>>
read_members(const TableReader& reader, const toml::node& node, const StudyConfig& config) {
    std::vector<std::string> valid;
    for (const Factor& factor : config.factors)
        valid.emplace_back(factor.parameter->key);
    std::vector<std::size_t> members;
    const toml::array* names = node.as_array();
    if (names == nullptr || names->size() < 2 || !names->is_homogeneous<std::string>()) {
        reader.error("factors", "must be a list of at least two factors");
        return std::nullopt;
    }
    for (const toml::node& name : *names) {
        const auto key = name.value_or<std::string>("");
        const auto found = std::ranges::find(valid, key);
        if (found == valid.end()) {
            reader.error("factors",
                         fmt::format("{} is not in [factors]{}", key, did_you_mean(key, valid)));
            return std::nullopt;
        }
        members.push_back(static_cast<std::size_t>(found - valid.begin()));
    }
    auto sorted = members;
    std::ranges::sort(sorted);
    if (std::ranges::adjacent_find(sorted) != sorted.end()) {
        reader.error("factors", "must name each factor once only");
        return std::nullopt;
    }
    return members;
}

/// What of the factors makes a correlation impossible, if anything.
std::string complaint_about(const std::vector<std::size_t>& members, const StudyConfig& config) {
    for (const std::size_t member : members) {
        const Factor& factor = config.factors[member];
        if (!factor.is_redrawn)
            return fmt::format("{} must be a distribution", factor.parameter->key);
        if (factor.measured && factor.measured->keeps_rows)
            return fmt::format("{} has rows = \"together\", and so the correlations of its file",
                               factor.parameter->key);
        if (factor.is_per_test != config.factors[members.front()].is_per_test)
            return fmt::format("{} and {} must have the same level, stem or test",
                               config.factors[members.front()].parameter->key,
                               factor.parameter->key);
    }
    return {};
}

/// (size, size), row-major; nothing with the errors recorded.
std::optional<std::vector<double>> read_matrix(const TableReader& reader, const toml::node& node,
                                               std::size_t size) {
    const auto refuse = [&](const std::string& reason) {
        reader.error("rank", reason);
        return std::nullopt;
    };
    const std::string shape =
        fmt::format("must be {0} lists of {0} numbers, one for each factor", size);
    const toml::array* rows = node.as_array();
    if (rows == nullptr || rows->size() != size)
        return refuse(shape);
    std::vector<double> matrix;
    for (const toml::node& row : *rows) {
        const toml::array* numbers = row.as_array();
        if (numbers == nullptr || numbers->size() != size)
            return refuse(shape);
        for (const toml::node& number : *numbers) {
            const auto value = number.value<double>();
            if (!number.is_number() || !value || !(std::abs(*value) <= 1.0))
                return refuse("must hold numbers in [-1, 1]");
            matrix.push_back(*value);
        }
    }
    for (std::size_t i = 0; i < size; ++i) {
        if (matrix[i * size + i] != 1.0)
            return refuse("must have ones on its diagonal");
        for (std::size_t j = 0; j < i; ++j)
            if (matrix[i * size + j] != matrix[j * size + i])
                return refuse(fmt::format("must be symmetric: row {} has {}, row {} has {}", i + 1,
                                          matrix[i * size + j], j + 1, matrix[j * size + i]));
    }
    return matrix;
}

} // namespace

void read_correlation(ConfigContext& context) {
    const toml::table* table = context.section("correlation");
    if (table == nullptr)
        return;
    const TableReader reader(table, "correlation", "correlation", context.errors);
    reader.refuse_unknown_keys();
    const toml::node* factors = table->get("factors");
    const toml::node* rank = table->get("rank");
    if (factors == nullptr || rank == nullptr) {
        reader.error(factors == nullptr ? "factors" : "rank", "[correlation] needs it");
        return;
    }
    // Factors that could not be read would only seem to be missing.
    if (context.errors.count() > 0)
        return;
    const auto members = read_members(reader, *factors, context.config);
    const auto matrix = members ? read_matrix(reader, *rank, members->size()) : std::nullopt;
    if (!members || !matrix)
        return;
    if (const std::string complaint = complaint_about(*members, context.config);
        !complaint.empty()) {
        reader.error("factors", complaint);
        return;
    }
    if (context.config.design.criterion != HypercubeCriterion::None)
        reader.error("factors", "not together with design.criterion: the correlations decide the "
                                "order of the values");
    try {
        context.config.correlation =
            FactorCorrelation{*members, RankCorrelation(members->size(), *matrix)};
    } catch (const core::InputError& error) {
        reader.error("rank", error.what());
    }
}

} // namespace culm::study
