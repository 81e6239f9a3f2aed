// SPDX-License-Identifier: BSD-3-Clause
#include "archive/study/writer.hpp"

#include "archive/file_descriptor.hpp"
#include "archive/hdf5/handle.hpp"
#include "archive/hdf5/write.hpp"
#include "archive/trajectory/h5md.hpp"
#include "core/error.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include <fmt/format.h>

namespace culm::archive {

namespace {

/// Writes the columns of one group, with one chunk of rows in memory.
class TableWriter {
  public:
    /// Creates the datasets, and the attribute `columns` that lists their names in order.
    TableWriter(const Hdf5Output& output, const GroupHandle& group, std::span<const Column> columns,
                hsize_t rows)
        : output_(output), rows_(rows), chunk_rows_(table_chunk_rows(rows)),
          buffers_(columns.size()) {
        std::vector<std::string> names;
        for (const Column& column : columns) {
            names.push_back(column.name);
            datasets_.push_back(output.create_dataset(
                group.get(), column.name,
                {H5T_IEEE_F64LE, {rows}, {chunk_rows_}, 1, column.unit, column.description}));
        }
        if (!names.empty()) // an attribute cannot be empty in a way that every reader understands
            output.write_attribute(group.get(), "columns", names);
    }

    /// One value per column. Rows are collected until a chunk of each column is full: a chunk that
    /// is written in parts would be decompressed and compressed again for each part.
    void append(std::span<const double> row) {
        for (std::size_t column = 0; column < buffers_.size(); ++column)
            buffers_[column].push_back(row[column]);
        ++buffered_;
        if (buffered_ == chunk_rows_ || written_ + buffered_ == rows_)
            flush();
    }

  private:
    void flush() {
        const std::vector<hsize_t> start{written_};
        const std::vector<hsize_t> count{buffered_};
        for (std::size_t column = 0; column < buffers_.size(); ++column) {
            output_.write_block(datasets_[column], start, count, H5T_NATIVE_DOUBLE,
                                buffers_[column].data());
            buffers_[column].clear();
        }
        written_ += buffered_;
        buffered_ = 0;
    }

    const Hdf5Output& output_;
    hsize_t rows_;
    hsize_t chunk_rows_;
    hsize_t written_ = 0;
    hsize_t buffered_ = 0;
    std::vector<DatasetHandle> datasets_;
    std::vector<std::vector<double>> buffers_; ///< (columns, rows of a chunk)
};

/// Longest failure text that is stored, in bytes; a longer one ends with "…".
constexpr std::size_t longest_failure_text = 1024;

/// The text in at most longest_failure_text bytes, never cut inside a UTF-8 character.
std::string shortened(const std::string& text) {
    if (text.size() <= longest_failure_text)
        return text;
    const std::string ellipsis = "…";
    std::size_t end = longest_failure_text - ellipsis.size();
    const auto continues_character = [](char c) {
        return (static_cast<unsigned char>(c) & 0xC0U) == 0x80U;
    };
    while (end > 0 && continues_character(text[end]))
        --end;
    return text.substr(0, end) + ellipsis;
}

/// Writes the points in order of their ids. Keeps states and reasons of failure in memory.
class ResultsWriter {
  public:
    ResultsWriter(const Hdf5Output& output, const StudyDescription& description)
        : output_(output), group_(output.create_group(output.root(), "results")),
          table_(output, group_, description.results, static_cast<hsize_t>(description.points)),
          no_values_(description.results.size(), std::numeric_limits<double>::quiet_NaN()) {}

    /// The next point; nullptr if it is missing.
    void append(const PointRecord* record) {
        const PointStatus status = record == nullptr ? PointStatus::Missing : record->status();
        statuses_.push_back(static_cast<std::uint8_t>(status));
        if (status == PointStatus::Failed) {
            failure_kinds_.emplace(statuses_.size() - 1, shortened(record->failure_kind));
            failure_reasons_.emplace(statuses_.size() - 1, shortened(record->failure_reason));
        }
        table_.append(status == PointStatus::Completed ? record->values : no_values_);
    }

    /// After the last point.
    void finish() {
        const hsize_t rows = statuses_.size();
        const DatatypeHandle type = status_type();
        output_.write_dataset(group_.get(), "status",
                              {type.get(),
                               {rows},
                               {table_chunk_rows(rows)},
                               1,
                               "1",
                               "0: completed, 1: failed, 2: missing (not computed)"},
                              type.get(), statuses_.data());
        write_texts("failure_kind", failure_kinds_,
                    "short name of the kind of failure, else empty");
        write_texts("failure_reason", failure_reasons_, "why the point has no answer, else empty");
    }

  private:
    using TextsByRow = std::map<std::size_t, std::string>; ///< the other rows are empty

    void write_texts(const std::string& name, const TextsByRow& texts,
                     const std::string& description) const {
        std::size_t width = 1;
        for (const auto& [row, text] : texts)
            width = std::max(width, text.size());
        constexpr std::size_t chunk_bytes = 65536;
        const hsize_t rows = statuses_.size();
        const hsize_t chunk = std::min<hsize_t>(rows, std::max<hsize_t>(1, chunk_bytes / width));
        const DatatypeHandle type = fixed_text_type(width);
        const DatasetHandle dataset = output_.create_dataset(
            group_.get(), name, {type.get(), {rows}, {chunk}, 1, "1", description});
        for (hsize_t begin = 0; begin < rows; begin += chunk) {
            const std::vector<hsize_t> start{begin};
            const std::vector<hsize_t> count{std::min(chunk, rows - begin)};
            std::string block(count[0] * width, '\0');
            // Few of millions of points fail, so the map contains only rows with a text.
            const auto end = texts.lower_bound(begin + count[0]);
            for (auto text = texts.lower_bound(begin); text != end; ++text)
                std::ranges::copy(text->second, block.begin() + static_cast<std::ptrdiff_t>(
                                                                    (text->first - begin) * width));
            output_.write_block(dataset, start, count, type.get(), block.data());
        }
    }

    const Hdf5Output& output_;
    GroupHandle group_;
    TableWriter table_;
    std::vector<double> no_values_; ///< a row of NaN
    std::vector<std::uint8_t> statuses_;
    TextsByRow failure_kinds_;
    TextsByRow failure_reasons_;
};

/// Deflate is slow and hardly reduces histories: the low bytes of a double are almost random.
constexpr int table_compression = 0;
constexpr hsize_t largest_chunk_bytes =
    hsize_t{512} * 1024; ///< two fit HDF5's default chunk cache, 1 MiB

/// Samples in a chunk when one sample has `doubles_per_sample` doubles. The chunks are as equal as
/// possible, because HDF5 also stores the unused part of the last one.
hsize_t chunk_samples(hsize_t samples, hsize_t doubles_per_sample) {
    const hsize_t fitting = largest_chunk_bytes / (sizeof(double) * doubles_per_sample);
    const hsize_t largest = std::clamp<hsize_t>(fitting, 1, samples);
    const hsize_t chunks = (samples + largest - 1) / largest;
    return (samples + chunks - 1) / chunks;
}

/// Writes the points in order of their ids, with one history in memory at a time.
class HistoriesWriter {
  public:
    HistoriesWriter(const Hdf5Output& output, const StudyDescription& description)
        : output_(output), description_(description) {
        const StoredHistories& stored = description.stored;
        if (!stored.tip && !stored.heights && !stored.positions)
            return;
        histories_ = create_histories(output, description);
        create_tables();
        if (stored.positions)
            particles_ = output.create_group(output.root(), "particles");
    }

    /// Appends the next point. nullptr: it has no histories (failed or missing), so it gets NaN in
    /// the tables and no particle group.
    void append(const PointRecord* record) {
        if (tip_.is_open())
            append_row(tip_, 1, record == nullptr ? nullptr : &record->tip_deflection);
        if (heights_.is_open())
            append_row(heights_, description_.heights.size(),
                       record == nullptr ? nullptr : &record->height_deflection);
        if (particles_.is_open() && record != nullptr)
            write_trajectory(*record);
        ++next_point_;
    }

    /// After the last point.
    void finish() {
        if (places_.empty())
            return;
        const auto rows = static_cast<hsize_t>(description_.points);
        output_.write_dataset(
            histories_.get(), "trajectory_place",
            {.type = H5T_STD_I64LE,
             .shape = {rows, 4},
             .chunk = {table_chunk_rows(rows), 4},
             .description = "positions in other files: rank, file, slot, CRC-32; -1: none there"},
            H5T_NATIVE_INT64, places_.data());
    }

  private:
    void create_tables() {
        const auto points = static_cast<hsize_t>(description_.points);
        const hsize_t samples = description_.times.size();
        if (description_.stored.tip)
            tip_ =
                output_.create_dataset(histories_.get(), "tip_deflection",
                                       {H5T_IEEE_F64LE,
                                        {points, samples},
                                        {1, chunk_samples(samples, 1)},
                                        table_compression,
                                        "m",
                                        "lateral deflection of the tip; NaN where there is none"});
        if (!description_.stored.heights)
            return;
        const hsize_t heights = description_.heights.size();
        output_.write_series(histories_.get(), "heights", "m", description_.heights);
        heights_ =
            output_.create_dataset(histories_.get(), "height_deflection",
                                   {H5T_IEEE_F64LE,
                                    {points, samples, heights},
                                    {1, chunk_samples(samples, heights), heights},
                                    table_compression,
                                    "m",
                                    "lateral deflection at /histories/heights; NaN where there "
                                    "is none"});
    }

    void append_row(const DatasetHandle& dataset, hsize_t doubles_per_sample,
                    const std::vector<double>* row) {
        // NaN is written explicitly, so that an absent chunk always means damage.
        if (row == nullptr)
            nothing_.assign(description_.times.size() * doubles_per_sample,
                            std::numeric_limits<double>::quiet_NaN());
        const std::array<hsize_t, 3> start{next_point_, 0, 0};
        const std::array<hsize_t, 3> count{1, description_.times.size(), doubles_per_sample};
        const std::size_t rank = &dataset == &tip_ ? 2 : 3;
        output_.write_block(dataset, std::span(start).first(rank), std::span(count).first(rank),
                            H5T_NATIVE_DOUBLE, row == nullptr ? nothing_.data() : row->data());
    }

    /// One H5MD 1.1 particle group, here or as a link to the file that contains it.
    void write_trajectory(const PointRecord& record) {
        const std::string name = particle_group_name(record.point);
        if (const auto& place = record.trajectory) {
            places_.resize(static_cast<std::size_t>(description_.points), {-1, -1, -1, -1});
            places_[static_cast<std::size_t>(record.point)] = {place->rank, place->file,
                                                               place->slot, place->crc32};
            output_.link_external(fmt::format("{}/{}", trajectory_folder_name, place->file_name()),
                                  place->group(), particles_.get(), name);
            return;
        }
        DatasetLayout layout = position_layout(description_);
        layout.chunk = layout.shape;
        layout.chunk.front() = chunk_samples(layout.shape[0], 3 * layout.shape[1]);
        layout.compression = description_.trajectory_compression;
        output_.write_dataset(create_particle_group(output_, "/particles/" + name).get(), "value",
                              layout, H5T_NATIVE_DOUBLE, record.positions.data());
    }

    const Hdf5Output& output_;
    const StudyDescription& description_;
    hsize_t next_point_ = 0;
    std::vector<std::array<std::int64_t, 4>> places_; ///< of trajectories in other files, by point
    std::vector<double> nothing_;                     ///< a row without a history
    GroupHandle histories_;
    GroupHandle particles_;
    DatasetHandle tip_;
    DatasetHandle heights_;
};

std::filesystem::path temporary_path(const std::filesystem::path& target) {
    return target.string() + ".tmp";
}

/// Removes the temporary file unless it has been given its final name.
class TemporaryFile {
  public:
    explicit TemporaryFile(const std::filesystem::path& target)
        : target_(target), path_(temporary_path(target)) {}
    ~TemporaryFile() {
        std::error_code ignored; // a destructor cannot report it
        if (!is_kept_)
            std::filesystem::remove(path_, ignored);
    }
    TemporaryFile(const TemporaryFile&) = delete;
    TemporaryFile& operator=(const TemporaryFile&) = delete;

    void move_to_target() {
        std::error_code error;
        std::filesystem::rename(path_, target_, error);
        if (error)
            throw_storage_error("rename to " + target_.string() + " the file", path_,
                                error.value());
        is_kept_ = true;
        const std::filesystem::path folder = target_.parent_path();
        sync_path(folder.empty() ? "." : folder);
    }

  private:
    std::filesystem::path target_;
    std::filesystem::path path_;
    bool is_kept_ = false;
};

void write_root(const Hdf5Output& output, const StudyDescription& description) {
    const hid_t root = output.root();
    output.write_attribute(root, "format", std::string(study_format_name));
    output.write_attribute(root, "format_version",
                           fmt::format("{}.{}", study_format_major, study_format_minor));
    output.write_attribute(root, "points", description.points);
    output.write_attribute(root, "spheres", std::int64_t{description.spheres});
    output.write_attribute(root, "trajectory_compression",
                           std::int64_t{description.trajectory_compression});
    output.write_attribute(root, "trajectory_precision",
                           std::string(description.single_precision ? "float32" : "float64"));
}

GroupHandle write_provenance(const Hdf5Output& output, const StudyDescription& description) {
    // An attribute in an object header is limited to 64 KiB; long texts also need a checksum.
    constexpr std::size_t longest_attribute = 8192;
    GroupHandle group = output.create_group(output.root(), "provenance");
    std::vector<std::string> names;
    for (const auto& [name, text] : description.provenance) {
        names.push_back(name);
        if (name == "config" || text.size() > longest_attribute)
            output.write_text(group.get(), name, text);
        else
            output.write_attribute(group.get(), name, text);
    }
    if (!names.empty())
        output.write_attribute(group.get(), "entries", names);
    output.write_text(group.get(), "identity", description.identity);
    return group;
}

void write_design(const Hdf5Output& output, const StudyDescription& description,
                  std::span<const double> design) {
    const GroupHandle group = output.create_group(output.root(), "design");
    const auto points = static_cast<std::size_t>(description.points);
    output.write_numbering(group.get(), "point", points, "place in the design");
    TableWriter table(output, group, description.factors, points);
    for (std::size_t row = 0; row < points; ++row)
        table.append(design.subspan(row * description.factors.size(), description.factors.size()));
}

/// StorageError unless a record's arrays have the sizes that the description promises.
void require_fitting(const PointRecord& record, std::int64_t point,
                     const StudyDescription& description) {
    const auto require = [point](std::string_view what, std::size_t found, std::size_t expected) {
        if (found != expected)
            throw core::StorageError(fmt::format("record of point {}: {} {}, but the study has {}",
                                                 point, found, what, expected));
    };
    if (record.point != point)
        throw core::StorageError(
            fmt::format("record of point {} was found in the place of {}", record.point, point));
    if (!record.completed)
        return;
    const std::size_t samples = description.times.size();
    const auto spheres = static_cast<std::size_t>(description.spheres);
    require("results", record.values.size(), description.results.size());
    if (description.stored.tip)
        require("samples of the tip", record.tip_deflection.size(), samples);
    if (description.stored.heights)
        require("deflections at heights", record.height_deflection.size(),
                samples * description.heights.size());
    if (description.stored.positions && !record.trajectory)
        require("coordinates", record.positions.size(), samples * spheres * 3);
}

void write_points(const Hdf5Output& output, const StudyDescription& description,
                  const RecordSource& record_of_point) {
    ResultsWriter results(output, description);
    HistoriesWriter histories(output, description);
    for (std::int64_t point = 0; point < description.points; ++point) {
        const std::optional<PointRecord> record = record_of_point(point);
        if (record)
            require_fitting(*record, point, description);
        results.append(record ? &*record : nullptr);
        histories.append(record && record->completed ? &*record : nullptr);
    }
    results.finish();
    histories.finish();
}

} // namespace

void write_study_file(const std::filesystem::path& path, const StudyDescription& description,
                      std::span<const double> design, const RecordSource& record_of_point,
                      const ClosingEntries& closing_entries) {
    const Hdf5Silence silence;
    Hdf5Output output(temporary_path(path));
    TemporaryFile temporary(path); // after the output has locked it: not another process's file
    write_root(output, description);
    write_h5md(output, description);
    const GroupHandle provenance = write_provenance(output, description);
    write_design(output, description, design);
    write_points(output, description, record_of_point);
    if (closing_entries)
        for (const auto& [name, number] : closing_entries())
            output.write_attribute(provenance.get(), name, number);
    // The content is on the disk before the file gets its name. Otherwise a power cut could replace
    // an existing archive by an empty file.
    output.close();
    temporary.move_to_target();
}

} // namespace culm::archive
