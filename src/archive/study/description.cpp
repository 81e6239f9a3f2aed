// SPDX-License-Identifier: BSD-3-Clause
#include "archive/study/description.hpp"

#include "core/error.hpp"

#include <set>
#include <span>
#include <string_view>

#include <fmt/format.h>

namespace culm::archive {

namespace {

void validate_names(std::span<const Column> columns, const std::string& table,
                    std::set<std::string, std::less<>> taken) {
    for (const Column& column : columns) {
        // The rules of HDF5: '/' separates groups and "." is the group itself.
        if (column.name.empty() || column.name == "." ||
            column.name.find('/') != std::string::npos ||
            column.name.find('\0') != std::string::npos)
            throw core::InputError(
                fmt::format("{} column \"{}\": a name must not be empty, \".\", or contain '/'",
                            table, column.name));
        if (!taken.insert(column.name).second)
            throw core::InputError(fmt::format(
                "{} column \"{}\": the name is used twice or reserved", table, column.name));
    }
}

void require(bool condition, std::string_view text) {
    if (!condition)
        throw core::InputError(fmt::format("study description: {}", text));
}

} // namespace

void validate(const StudyDescription& description) {
    validate_names(description.factors, "design", {"point"});
    validate_names(description.results, "results", {"status", "failure_kind", "failure_reason"});
    std::vector<Column> texts;
    for (const auto& [name, text] : description.provenance)
        texts.push_back({name, {}, {}});
    validate_names(texts, "provenance", {"identity", "entries"});

    const StoredHistories& stored = description.stored;
    require(description.points > 0,
            fmt::format("{} points; at least 1 is needed", description.points));
    require(!(stored.tip || stored.heights || stored.positions) || !description.times.empty(),
            "histories are stored, but there are no sample times");
    require(!stored.heights || !description.heights.empty(),
            "height histories are stored, but there are no heights");
    require(!stored.positions || description.spheres > 0,
            "positions are stored, but the number of spheres is not positive");
    require(description.trajectory_compression >= 0 && description.trajectory_compression <= 9,
            fmt::format("trajectory compression {}; allowed are 0 to 9",
                        description.trajectory_compression));
}

} // namespace culm::archive
