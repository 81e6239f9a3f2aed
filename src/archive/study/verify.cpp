// SPDX-License-Identifier: BSD-3-Clause
#include "archive/hdf5/handle.hpp"
#include "archive/hdf5/read.hpp"
#include "archive/study/file.hpp"
#include "core/error.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace culm::archive {

namespace {

using Extent = std::vector<hsize_t>;

/// Moves `start` to the next chunk in row-major order; false behind the last one.
bool advance(Extent& start, const Extent& shape, const Extent& chunk) {
    for (std::size_t axis = shape.size(); axis-- > 0;) {
        start[axis] += chunk[axis];
        if (start[axis] < shape[axis])
            return true;
        start[axis] = 0;
    }
    return false;
}

/// Checks the chunks of one dataset.
class ChunkReader {
  public:
    ChunkReader(const Hdf5Input& input, const std::string& name)
        : path_(input.path()), dataset_(input.open_dataset(name)), shape_(input.shape(name)),
          chunk_(shape_.size()), type_(H5Dget_type(dataset_.get())) {
        const PropertyListHandle list(
            checked(H5Dget_create_plist(dataset_.get()), "read the properties", path_));
        checked(H5Pget_chunk(list.get(), static_cast<int>(chunk_.size()), chunk_.data()),
                "read the chunk shape", path_);
        const H5T_class_t kind = H5Tget_class(type_.get());
        constexpr hsize_t largest_chunk = hsize_t{1} << 28U; // bytes; culm writes 512 KiB or so
        const hsize_t size = product(chunk_) * H5Tget_size(type_.get());
        if ((kind != H5T_INTEGER && kind != H5T_FLOAT && kind != H5T_ENUM && kind != H5T_STRING) ||
            H5Tis_variable_str(type_.get()) > 0 || size > largest_chunk)
            throw core::StorageError("culm does not write datasets of this form");
        buffer_.resize(static_cast<std::size_t>(size));
    }

    void read_all(DamagedDataset& result) {
        if (std::ranges::find(shape_, hsize_t{0}) != shape_.end())
            return; // no axis may be walked along where another one is empty
        if (const hsize_t absent = absent_chunks(); absent > most_absent) {
            result.chunks = result.damaged_chunks = static_cast<std::int64_t>(absent);
            result.reason = "a chunk is absent";
            return;
        }
        Extent start(shape_.size(), 0);
        do {
            ++result.chunks;
            const std::string reason = read(start);
            if (!reason.empty() && result.damaged_chunks++ == 0)
                result.reason = reason;
        } while (advance(start, shape_, chunk_));
    }

  private:
    /// If more chunks are absent, they are only counted and not examined one by one.
    static constexpr hsize_t most_absent = 10'000;

    /// Number of chunks that the shape requires and the file lacks.
    [[nodiscard]] hsize_t absent_chunks() const {
        // In long double, because a damaged shape may require more than 2^64 chunks.
        long double needed = 1.0L;
        for (std::size_t axis = 0; axis < shape_.size(); ++axis)
            needed *= std::ceil(static_cast<long double>(shape_[axis]) /
                                static_cast<long double>(chunk_[axis]));
        hsize_t stored = 0;
        const DataspaceHandle space(H5Dget_space(dataset_.get()));
        checked(H5Dget_num_chunks(dataset_.get(), space.get(), &stored), "count the chunks", path_);
        const long double absent = needed - static_cast<long double>(stored);
        return static_cast<hsize_t>(std::clamp(absent, 0.0L, 1e18L));
    }

    /// Reads the chunk at `start`; returns the error, or an empty text.
    std::string read(const Extent& start) {
        unsigned mask = 0;
        haddr_t address = HADDR_UNDEF;
        hsize_t size = 0;
        if (H5Dget_chunk_info_by_coord(dataset_.get(), start.data(), &mask, &address, &size) < 0)
            return hdf5_reason();
        // H5Dread would return fill values here without an error.
        if (address == HADDR_UNDEF)
            return "a chunk is absent";
        // A bit of the mask means that a filter was skipped for this chunk, perhaps because the
        // mask is damaged.
        if (mask != 0)
            return "a chunk is stored without its checksum";
        Extent count(shape_.size());
        for (std::size_t axis = 0; axis < count.size(); ++axis)
            count[axis] = std::min(chunk_[axis], shape_[axis] - start[axis]);
        const DataspaceHandle space(H5Dget_space(dataset_.get()));
        H5Sselect_hyperslab(space.get(), H5S_SELECT_SET, start.data(), nullptr, count.data(),
                            nullptr);
        const DataspaceHandle memory(
            H5Screate_simple(static_cast<int>(count.size()), count.data(), nullptr));
        if (H5Dread(dataset_.get(), type_.get(), memory.get(), space.get(), H5P_DEFAULT,
                    buffer_.data()) < 0)
            return hdf5_reason();
        return {};
    }

    std::filesystem::path path_;
    DatasetHandle dataset_;
    Extent shape_;
    Extent chunk_;
    DatatypeHandle type_;
    std::vector<std::byte> buffer_;
};

DamagedDataset examine(const Hdf5Input& input, const std::string& name) {
    DamagedDataset result;
    result.name = name;
    try {
        if (input.shape(name).empty()) {
            result.chunks = 1;
            (void)input.text(name);
        } else {
            ChunkReader(input, name).read_all(result);
        }
    } catch (const core::StorageError& error) {
        result.chunks = std::max<std::int64_t>(result.chunks, 1);
        result.damaged_chunks = std::max<std::int64_t>(result.damaged_chunks, 1);
        result.reason = error.what();
    }
    return result;
}

herr_t collect_dataset(hid_t, const char* name, const H5O_info_t* info, void* data) {
    if (info->type == H5O_TYPE_DATASET)
        static_cast<std::vector<std::string>*>(data)->push_back(std::string("/") + name);
    return 0;
}

std::vector<std::string> dataset_names(const Hdf5Input& input) {
    std::vector<std::string> names;
    // Native order: for sorted order HDF5 1.10.8 makes a table of a group's links, and frees
    // uninitialised entries of it if the group is damaged.
    checked(H5Ovisit2(input.root(), H5_INDEX_NAME, H5_ITER_NATIVE, &collect_dataset, &names,
                      H5O_INFO_BASIC),
            "list the datasets", input.path());
    std::ranges::sort(names);
    return names;
}

/// Whole chunks do not show that a table has one number for each point. Trajectories in other files
/// have a checksum each.
void examine_numbers(const StudyFile& file, Verification& verification) {
    const StudyDescription& description = file.description();
    const auto examine = [&](const std::string& name, const auto& read) {
        try {
            static_cast<void>(read());
        } catch (const core::StorageError& error) {
            verification.damaged.push_back({name, 1, 1, error.what()});
        }
    };
    for (const Column& column : description.factors)
        examine("/design/" + column.name, [&] { return file.factor(column.name); });
    for (const Column& column : description.results)
        examine("/results/" + column.name, [&] { return file.result(column.name); });
    const std::int64_t trajectories = description.stored.positions ? file.point_count() : 0;
    for (std::int64_t point = 0; point < trajectories; ++point)
        examine("/particles/" + particle_group_name(point), [&] {
            if (!file.trajectory(point))
                return std::vector<double>();
            ++verification.datasets;
            ++verification.chunks;
            return file.positions(point);
        });
}

} // namespace

Verification verify(const std::filesystem::path& path) {
    const Hdf5Silence silence;
    require_survival(path, [&path] { (void)dataset_names(Hdf5Input(path)); });
    const Hdf5Input input(path);
    Verification verification;
    for (const std::string& name : dataset_names(input)) {
        const DamagedDataset result = examine(input, name);
        ++verification.datasets;
        verification.chunks += result.chunks;
        if (result.damaged_chunks > 0)
            verification.damaged.push_back(result);
    }
    if (verification.is_whole())
        examine_numbers(StudyFile(path), verification);
    return verification;
}

} // namespace culm::archive
