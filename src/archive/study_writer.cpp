// SPDX-License-Identifier: BSD-3-Clause
#include "archive/study_writer.hpp"

#include "archive/file_descriptor.hpp"
#include "archive/hdf5_call.hpp"
#include "archive/hdf5_write.hpp"
#include "archive/study_format.hpp"
#include "archive/study_histories.hpp"
#include "archive/study_results.hpp"
#include "archive/study_table.hpp"
#include "core/error.hpp"

#include <array>
#include <numeric>
#include <string>
#include <system_error>
#include <vector>

#include <fmt/format.h>

namespace culm::archive {

namespace {

std::filesystem::path temporary_path(const std::filesystem::path& target) {
    return target.string() + ".tmp";
}

/// Removes the temporary file unless it has been given its final name.
class TemporaryFile {
  public:
    explicit TemporaryFile(const std::filesystem::path& target)
        : target_(target), path_(temporary_path(target)) {}
    ~TemporaryFile() {
        std::error_code ignored; // nothing can be done about it in a destructor
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
}

void write_h5md(const Hdf5Output& output, const StudyDescription& description) {
    const GroupHandle h5md = output.create_group(output.root(), "h5md");
    output.write_attribute(h5md.get(), "version", std::array<std::int32_t, 2>{1, 1});
    const GroupHandle author = output.create_group(h5md.get(), "author");
    output.write_attribute(author.get(), "name", description.author);
    const GroupHandle creator = output.create_group(h5md.get(), "creator");
    output.write_attribute(creator.get(), "name", std::string("culm"));
    output.write_attribute(creator.get(), "version", description.version);
}

void write_provenance(const Hdf5Output& output, const StudyDescription& description) {
    // An attribute in an object header must stay below 64 KiB; long texts also deserve a checksum.
    constexpr std::size_t longest_attribute = 8192;
    const GroupHandle group = output.create_group(output.root(), "provenance");
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
}

void write_design(const Hdf5Output& output, const StudyDescription& description,
                  std::span<const double> design) {
    const GroupHandle group = output.create_group(output.root(), "design");
    const std::vector<hsize_t> shape{static_cast<hsize_t>(description.points)};
    const std::vector<hsize_t> start{0};
    std::vector<std::int64_t> points(static_cast<std::size_t>(description.points));
    std::iota(points.begin(), points.end(), 0);
    const DatasetHandle dataset = output.create_dataset(
        group.get(), "point",
        {H5T_STD_I64LE, shape, {table_chunk_rows(shape[0])}, 1, "1", "place in the design"});
    output.write_block(dataset, start, shape, H5T_NATIVE_INT64, points.data());
    TableWriter table(output, group, description.factors, shape[0]);
    for (std::size_t row = 0; row < points.size(); ++row)
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
    if (description.stored.positions)
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
}

} // namespace

void write_study_file(const std::filesystem::path& path, const StudyDescription& description,
                      std::span<const double> design, const RecordSource& record_of_point) {
    validate(description);
    if (design.size() != static_cast<std::size_t>(description.points) * description.factors.size())
        throw core::InputError(
            fmt::format("study description: the design has {} values; {} points and {} factors "
                        "need one for each pair",
                        design.size(), description.points, description.factors.size()));
    const Hdf5Silence silence;
    Hdf5Output output(temporary_path(path));
    TemporaryFile temporary(path); // after the output has the file: never another process's one
    write_root(output, description);
    write_h5md(output, description);
    write_provenance(output, description);
    write_design(output, description, design);
    write_points(output, description, record_of_point);
    output.close();
    temporary.move_to_target();
}

} // namespace culm::archive
