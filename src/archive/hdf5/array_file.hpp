// SPDX-License-Identifier: BSD-3-Clause
// A small HDF5 file of named arrays of doubles.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace culm::archive {

/// One dataset.
struct NamedArray {
    std::string path; ///< within the file, as in "model_1/residual"; its groups are created
    std::string unit; ///< "1": dimensionless
    std::string description;
    std::vector<std::size_t> shape;
    std::vector<double> values; ///< row-major; NaN: none
};

/// Texts that a group carries; "" is the file itself.
struct GroupTexts {
    std::string group;
    std::vector<std::pair<std::string, std::string>> texts;
};

/// Writes a new file; an existing one is kept until the new one is complete. Datasets have a unit,
/// a description and checksums, as in study.h5. Throws core::StorageError.
void write_array_file(const std::filesystem::path& path, std::span<const GroupTexts> groups,
                      std::span<const NamedArray> arrays);

} // namespace culm::archive
