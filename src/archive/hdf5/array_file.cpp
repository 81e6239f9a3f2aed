// SPDX-License-Identifier: BSD-3-Clause
#include "archive/hdf5/array_file.hpp"

#include "archive/hdf5/write.hpp"
#include "core/error.hpp"

#include <algorithm>
#include <map>
#include <system_error>

#include <fmt/format.h>

namespace culm::archive {

namespace {

/// The groups of a file under construction, each created once, with those above it.
class Groups {
  public:
    explicit Groups(const Hdf5Output& output) : output_(output) {}

    [[nodiscard]] hid_t at(const std::string& path) {
        if (path.empty())
            return output_.root();
        const auto known = groups_.find(path);
        if (known != groups_.end())
            return known->second.get();
        const auto [parent, name] = place_of(path);
        return groups_.emplace(path, output_.create_group(parent, name)).first->second.get();
    }

    /// The group above the path, and the last name of the path.
    [[nodiscard]] std::pair<hid_t, std::string> place_of(const std::string& path) {
        const std::size_t slash = path.rfind('/');
        if (slash == std::string::npos)
            return {output_.root(), path};
        return {at(path.substr(0, slash)), path.substr(slash + 1)};
    }

  private:
    const Hdf5Output& output_;
    std::map<std::string, GroupHandle> groups_;
};

void write_array(const Hdf5Output& output, Groups& groups, const NamedArray& array) {
    const auto [parent, name] = groups.place_of(array.path);
    const std::vector<hsize_t> shape(array.shape.begin(), array.shape.end());
    std::vector<hsize_t> chunk = shape;
    chunk.front() = table_chunk_rows(shape.front());
    for (hsize_t& length : chunk) // an empty dataset has chunks too
        length = std::max<hsize_t>(length, 1);
    const DatasetHandle dataset = output.create_dataset(
        parent, name, {H5T_IEEE_F64LE, shape, chunk, 1, array.unit, array.description});
    if (array.values.empty())
        return;
    const std::vector<hsize_t> start(shape.size(), 0);
    output.write_block(dataset, start, shape, H5T_NATIVE_DOUBLE, array.values.data());
}

} // namespace

void write_array_file(const std::filesystem::path& path, std::span<const GroupTexts> groups,
                      std::span<const NamedArray> arrays) {
    // The file has another name until it is complete, so that a reader never finds half a file.
    std::filesystem::path unfinished = path;
    unfinished += ".tmp";
    {
        Hdf5Output output(unfinished);
        {
            // Groups must be closed before the file: HDF5 keeps a file open as long as an object in
            // it is.
            Groups created(output);
            for (const GroupTexts& group : groups)
                for (const auto& [name, text] : group.texts)
                    output.write_attribute(created.at(group.group), name, text);
            for (const NamedArray& array : arrays)
                write_array(output, created, array);
        }
        output.close();
    }
    std::error_code error;
    std::filesystem::rename(unfinished, path, error);
    if (error)
        throw core::StorageError(fmt::format("{}: cannot be renamed to {}: {}", unfinished.string(),
                                             path.string(), error.message()));
}

} // namespace culm::archive
