// SPDX-License-Identifier: BSD-3-Clause
// Whether every byte of a study file's data is still what was written.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace culm::archive {

struct DamagedDataset {
    std::string name;                ///< absolute path in the file
    std::int64_t damaged_chunks = 0; ///< absent ones included
    std::int64_t chunks = 0;         ///< that the dataset should have
    std::string reason;              ///< of the first damage
};

struct Verification {
    std::int64_t datasets = 0;
    std::int64_t chunks = 0;
    std::vector<DamagedDataset> damaged; ///< in order of their names

    [[nodiscard]] bool is_whole() const { return damaged.empty(); }
};

/// Reads every chunk of every dataset, which makes HDF5 check its checksum, and the checksums of
/// the texts. StorageError or InputError if the file cannot be opened as a culm study at all.
[[nodiscard]] Verification verify(const std::filesystem::path& path);

} // namespace culm::archive
