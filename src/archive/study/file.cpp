// SPDX-License-Identifier: BSD-3-Clause
#include "archive/study/file.hpp"

#include "archive/hdf5/handle.hpp"
#include "archive/hdf5/read.hpp"
#include "archive/hdf5/write.hpp"
#include "archive/study/description.hpp"
#include "archive/trajectory/reader.hpp"
#include "core/error.hpp"
#include "core/nearest_name.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <utility>

#include <fmt/format.h>

namespace culm::archive {

namespace {

constexpr const char* trajectory_places = "/histories/trajectory_place";

/// The version of culm that wrote the file; its location is the same in every format.
std::string writer_of(const Hdf5Input& input) {
    return input.has("/h5md/creator") && input.has_attribute("/h5md/creator", "version")
               ? input.text_attribute("/h5md/creator", "version")
               : "an unknown version";
}

void require_format(const Hdf5Input& input) {
    const std::string name = input.path().string();
    if (!input.has_attribute("/", "format") ||
        input.text_attribute("/", "format") != study_format_name)
        throw core::InputError(
            fmt::format("{} is an HDF5 file, but not a culm study: its attribute \"format\" is not "
                        "\"{}\"",
                        name, study_format_name));
    const std::string version = input.text_attribute("/", "format_version");
    int major = 0;
    // Only the major number is compared: a minor version adds and changes nothing.
    const auto parsed = std::from_chars(version.data(), version.data() + version.size(), major);
    if (parsed.ec != std::errc() || major != study_format_major)
        throw core::InputError(fmt::format(
            "{} has format version {}; this culm reads version {}.x. It was written by {}: that "
            "version, or the newest one, reads it",
            name, version, study_format_major, writer_of(input)));
}

std::vector<Column> read_columns(const Hdf5Input& input, const std::string& table) {
    std::vector<Column> columns;
    if (!input.has_attribute(table, "columns"))
        return columns;
    for (const std::string& name : input.text_list_attribute(table, "columns")) {
        const std::string dataset = fmt::format("{}/{}", table, name);
        columns.push_back({name, input.text_attribute(dataset, "unit"),
                           input.has_attribute(dataset, "description")
                               ? input.text_attribute(dataset, "description")
                               : std::string()});
    }
    return columns;
}

Texts read_provenance(const Hdf5Input& input) {
    const std::string group = "/provenance";
    Texts entries;
    if (!input.has_attribute(group, "entries"))
        return entries;
    for (const std::string& name : input.text_list_attribute(group, "entries")) {
        const std::string dataset = fmt::format("{}/{}", group, name);
        entries.emplace_back(name, input.has(dataset) ? input.text(dataset)
                                                      : input.text_attribute(group, name));
    }
    return entries;
}

StudyDescription read_description(const Hdf5Input& input) {
    StudyDescription description;
    description.points = input.integer_attribute("/", "points");
    description.factors = read_columns(input, "/design");
    description.results = read_columns(input, "/results");
    description.stored = {input.has("/histories/tip_deflection"),
                          input.has("/histories/height_deflection"), input.has("/particles")};
    if (input.has("/histories/time"))
        description.times = input.doubles("/histories/time");
    if (input.has("/histories/heights"))
        description.heights = input.doubles("/histories/heights");
    description.spheres = static_cast<int>(input.integer_attribute("/", "spheres"));
    description.trajectory_compression =
        static_cast<int>(input.integer_attribute("/", "trajectory_compression"));
    description.single_precision = input.has_attribute("/", "trajectory_precision") && // format 1.1
                                   input.text_attribute("/", "trajectory_precision") == "float32";
    description.identity = input.text("/provenance/identity");
    description.version = input.text_attribute("/h5md/creator", "version");
    description.provenance = read_provenance(input);
    return description;
}

std::vector<PointStatus> read_statuses(const Hdf5Input& input, std::int64_t points) {
    std::vector<PointStatus> statuses;
    for (const std::uint8_t number : input.statuses("/results/status")) {
        if (number > static_cast<std::uint8_t>(PointStatus::Missing))
            throw core::StorageError(fmt::format("{}: /results/status has the unknown number {}",
                                                 input.path().string(), number));
        statuses.push_back(static_cast<PointStatus>(number));
    }
    if (statuses.size() != static_cast<std::size_t>(points))
        throw core::StorageError(fmt::format("{}: /results/status has {} points instead of {}",
                                             input.path().string(), statuses.size(), points));
    return statuses;
}

} // namespace

StudyFile::StudyFile(const std::filesystem::path& path) {
    require_survival(path, [&] { open(path); });
    open(path);
}

void StudyFile::open(const std::filesystem::path& path) {
    const Hdf5Silence silence;
    input_ = std::make_shared<const Hdf5Input>(path);
    trajectories_ = std::make_shared<TrajectoryFolder>(path.parent_path() / trajectory_folder_name);
    require_format(*input_);
    description_ = read_description(*input_);
    statuses_ = read_statuses(*input_, description_.points);
}

const std::filesystem::path& StudyFile::path() const {
    return input_->path();
}

void StudyFile::require_point(std::int64_t point) const {
    if (point < 0 || point >= description_.points)
        throw core::InputError(fmt::format("{}: there is no point {}; the points are 0 to {}",
                                           path().string(), point, description_.points - 1));
}

PointStatus StudyFile::status(std::int64_t point) const {
    require_point(point);
    return statuses_[static_cast<std::size_t>(point)];
}

std::vector<double> StudyFile::require_size(const std::string& dataset, std::vector<double> values,
                                            std::size_t size) const {
    if (values.size() != size)
        throw core::StorageError(fmt::format("{}: {} has {} numbers instead of {}", path().string(),
                                             dataset, values.size(), size));
    return values;
}

std::vector<double> StudyFile::column(const std::string& table, const std::vector<Column>& columns,
                                      const std::string& name) const {
    std::vector<std::string> names;
    for (const Column& candidate : columns) {
        if (candidate.name == name) {
            const Hdf5Silence silence;
            return require_size(fmt::format("{}/{}", table, name),
                                input_->doubles(fmt::format("{}/{}", table, name)),
                                statuses_.size());
        }
        names.push_back(candidate.name);
    }
    throw core::InputError(fmt::format("{}: {} has no column \"{}\"{}", path().string(), table,
                                       name, core::did_you_mean(name, names)));
}

std::vector<double> StudyFile::history(bool stored, const char* what, std::int64_t point,
                                       const std::string& dataset, std::size_t size) const {
    if (!stored)
        throw core::InputError(
            fmt::format("{}: this study does not store {}", path().string(), what));
    if (status(point) != PointStatus::Completed)
        throw core::InputError(fmt::format("{}: point {} is {}; it has no {}", path().string(),
                                           point, to_string(status(point)), what));
    const Hdf5Silence silence;
    std::vector<double> values = dataset.starts_with("/histories/")
                                     ? input_->doubles_at(dataset, static_cast<hsize_t>(point))
                                     : input_->doubles(dataset);
    // A NaN is HDF5's fill value for an absent chunk: a completed point's history has none.
    if (!values.empty() &&
        std::ranges::all_of(values, [](double value) { return std::isnan(value); }))
        throw core::StorageError(
            fmt::format("{}: {} is absent for a completed point; `culm archive verify` lists what "
                        "is damaged",
                        path().string(), dataset));
    return require_size(dataset, std::move(values), size);
}

std::vector<double> StudyFile::tip_deflection(std::int64_t point) const {
    return history(description_.stored.tip, "tip histories", point, "/histories/tip_deflection",
                   description_.times.size());
}

std::vector<double> StudyFile::height_deflection(std::int64_t point) const {
    return history(description_.stored.heights, "height histories", point,
                   "/histories/height_deflection",
                   description_.times.size() * description_.heights.size());
}

std::optional<TrajectoryPlace> StudyFile::trajectory(std::int64_t point) const {
    if (!description_.stored.positions || status(point) != PointStatus::Completed)
        return std::nullopt;
    if (!places_) {
        const Hdf5Silence silence;
        places_ = input_->has(trajectory_places)
                      ? require_size(trajectory_places, input_->doubles(trajectory_places),
                                     4 * statuses_.size())
                      : std::vector<double>();
    }
    const auto number = [&](std::size_t column) {
        constexpr double largest = std::numeric_limits<std::uint32_t>::max();
        const double stored = (*places_)[4 * static_cast<std::size_t>(point) + column];
        return static_cast<std::uint32_t>(std::fmin(std::fmax(stored, 0.0), largest));
    };
    if (places_->empty() || (*places_)[4 * static_cast<std::size_t>(point)] < 0.0)
        return std::nullopt;
    return TrajectoryPlace{number(0), number(1), number(2), number(3)};
}

std::vector<double> StudyFile::positions(std::int64_t point) const {
    const std::size_t size =
        description_.times.size() * static_cast<std::size_t>(description_.spheres) * 3;
    const std::string dataset =
        fmt::format("/particles/{}/position/value", particle_group_name(point));
    if (const auto place = trajectory(point))
        return require_size(dataset, trajectories_->read(*place), size);
    return history(description_.stored.positions, "positions", point, dataset, size);
}

std::string StudyFile::text_of_failure(const std::string& dataset, std::int64_t point) const {
    require_point(point);
    const Hdf5Silence silence;
    return input_->text_at(dataset, static_cast<hsize_t>(point));
}

std::vector<double> StudyFile::result_values(std::int64_t point) const {
    const auto chunk =
        static_cast<std::int64_t>(table_chunk_rows(static_cast<hsize_t>(description_.points)));
    // Columns are stored in chunks. Reading single rows would decompress every chunk once for each
    // of its rows.
    if (const std::int64_t first = point / chunk * chunk; first != first_result_row_) {
        first_result_row_ = -1; // in case a column cannot be read
        result_rows_.clear();
        const std::int64_t rows = std::min(chunk, description_.points - first);
        for (const Column& result_column : description_.results)
            result_rows_.push_back(input_->doubles_at("/results/" + result_column.name,
                                                      static_cast<hsize_t>(first),
                                                      static_cast<hsize_t>(rows)));
        first_result_row_ = first;
    }
    std::vector<double> values;
    values.reserve(result_rows_.size());
    for (const std::vector<double>& rows : result_rows_)
        values.push_back(rows[static_cast<std::size_t>(point - first_result_row_)]);
    return values;
}

std::optional<PointRecord> StudyFile::record(std::int64_t point) const {
    if (status(point) == PointStatus::Missing)
        return std::nullopt;
    PointRecord record;
    record.point = point;
    record.completed = status(point) == PointStatus::Completed;
    if (!record.completed) {
        record.failure_kind = failure_kind(point);
        record.failure_reason = failure_reason(point);
        return record;
    }
    const Hdf5Silence silence;
    record.values = result_values(point);
    const StoredHistories& stored = description_.stored;
    if (stored.tip)
        record.tip_deflection = tip_deflection(point);
    if (stored.heights)
        record.height_deflection = height_deflection(point);
    record.trajectory = trajectory(point);
    if (stored.positions && !record.trajectory)
        record.positions = positions(point);
    return record;
}

} // namespace culm::archive
