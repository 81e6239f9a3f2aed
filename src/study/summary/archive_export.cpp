// SPDX-License-Identifier: BSD-3-Clause
#include "study/summary/archive_export.hpp"

#include "archive/study/description.hpp"
#include "archive/study/file.hpp"
#include "archive/study/histories.hpp"
#include "core/error.hpp"

#include <cmath>
#include <cstddef>
#include <fstream>
#include <string>
#include <system_error>
#include <vector>

#include <fmt/format.h>
#include <fmt/ostream.h>

namespace culm::study {
namespace {

namespace fs = std::filesystem;
using archive::PointStatus;
using archive::StudyFile;

/// A file that is written completely; otherwise it throws.
class TextFile {
  public:
    explicit TextFile(fs::path path) : path_(std::move(path)), out_(path_) {}
    std::ofstream& stream() { return out_; }
    void finish() {
        out_.close();
        if (!out_)
            throw core::StorageError(fmt::format("{}: cannot be written", path_.string()));
    }

  private:
    fs::path path_;
    std::ofstream out_;
};

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

const char* name_of(PointStatus status) {
    return status == PointStatus::Completed ? "completed"
           : status == PointStatus::Failed  ? "failed"
                                            : "missing";
}

void write_points(const StudyFile& file, const fs::path& target) {
    const archive::StudyDescription& description = file.description();
    TextFile table(target / "points.csv");
    std::vector<std::vector<double>> columns;
    fmt::print(table.stream(), "point,status");
    for (const archive::Column& column : description.factors) {
        fmt::print(table.stream(), ",{}", heading(column));
        columns.push_back(file.factor(column.name));
    }
    for (const archive::Column& column : description.results) {
        fmt::print(table.stream(), ",{}", heading(column));
        columns.push_back(file.result(column.name));
    }
    fmt::print(table.stream(), ",failure_kind,failure_reason\n");
    for (std::int64_t point = 0; point < file.point_count(); ++point) {
        fmt::print(table.stream(), "{},{}", point, name_of(file.status(point)));
        for (const std::vector<double>& column : columns)
            fmt::print(table.stream(), ",{}", cell(column[static_cast<std::size_t>(point)]));
        const bool is_failed = file.status(point) == PointStatus::Failed;
        fmt::print(table.stream(), ",{},{}\n",
                   is_failed ? csv_text(file.failure_kind(point)) : std::string(),
                   is_failed ? csv_text(file.failure_reason(point)) : std::string());
    }
    table.finish();
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
    std::error_code error;
    fs::create_directories(target, error);
    if (error)
        throw core::StorageError(
            fmt::format("cannot create the folder {}: {}", target.string(), error.message()));
    write_points(file, target);
    ExportOutcome outcome;
    outcome.points = file.point_count();
    for (std::int64_t point = 0; point < file.point_count(); ++point)
        outcome.missing += file.status(point) == PointStatus::Missing ? 1 : 0;
    return outcome;
}

} // namespace culm::study
