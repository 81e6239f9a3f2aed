// SPDX-License-Identifier: BSD-3-Clause
#include "study/summary/archive_export.hpp"

#include "archive/study/description.hpp"
#include "archive/study/file.hpp"
#include "core/error.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <fstream>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ostream.h>

namespace culm::study {
namespace {

namespace fs = std::filesystem;
using archive::PointStatus;
using archive::StudyFile;

/// RFC 4180: in quotes if it needs them, quotes doubled.
std::string csv_text(const std::string& text) {
    if (text.find_first_of(",\"\r\n") == std::string::npos)
        return text;
    std::string quoted = "\"";
    for (const char c : text) {
        if (c == '"')
            quoted += '"';
        quoted += c;
    }
    return quoted + '"';
}

/// The shortest text that gives the same double; empty where there is no value.
std::string cell(double value) {
    return std::isnan(value) ? std::string() : fmt::format("{}", value);
}

std::string heading(const archive::Column& column) {
    return csv_text(column.unit == "1" ? column.name
                                       : fmt::format("{} [{}]", column.name, column.unit));
}

void write_points(const StudyFile& file, const fs::path& target) {
    const archive::StudyDescription& description = file.description();
    const fs::path path = target / "points.csv";
    std::ofstream table(path);
    std::vector<std::vector<double>> columns;
    fmt::print(table, "point,status");
    for (const archive::Column& column : description.factors) {
        fmt::print(table, ",{}", heading(column));
        columns.push_back(file.factor(column.name));
    }
    for (const archive::Column& column : description.results) {
        fmt::print(table, ",{}", heading(column));
        columns.push_back(file.result(column.name));
    }
    fmt::print(table, ",failure_kind,failure_reason\n");
    for (std::int64_t point = 0; point < file.point_count(); ++point) {
        fmt::print(table, "{},{}", point, to_string(file.status(point)));
        for (const std::vector<double>& column : columns)
            fmt::print(table, ",{}", cell(column[static_cast<std::size_t>(point)]));
        const bool is_failed = file.status(point) == PointStatus::Failed;
        fmt::print(table, ",{},{}\n",
                   is_failed ? csv_text(file.failure_kind(point)) : std::string(),
                   is_failed ? csv_text(file.failure_reason(point)) : std::string());
    }
    table.close();
    if (!table)
        throw core::StorageError(fmt::format("{}: cannot be written", path.string()));
}

} // namespace

ExportOutcome export_archive(const StudyFolder& folder, const fs::path& target) {
    if (!is_there(folder.archive()))
        throw core::InputError(
            fmt::format("{}: there is no study.h5 here; `culm archive merge {} -o OTHER` makes one "
                        "of the journals of a study that is not complete",
                        folder.path().string(), folder.path().string()));
    if (is_there(target / "points.csv"))
        throw core::InputError(
            fmt::format("{} is there already; choose another folder with -o or remove it",
                        (target / "points.csv").string()));
    const StudyFile file(folder.archive());
    create_folder(target);
    write_points(file, target);
    ExportOutcome outcome;
    outcome.points = file.point_count();
    outcome.missing = std::ranges::count(file.statuses(), PointStatus::Missing);
    return outcome;
}

} // namespace culm::study
