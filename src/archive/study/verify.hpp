// SPDX-License-Identifier: BSD-3-Clause
// Checks whether every byte of a study file's data is unchanged, and whether HDF5 can open the file
// without crashing.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace culm::archive {

struct DamagedDataset {
    std::string name;                ///< absolute path in the file
    std::int64_t damaged_chunks = 0; ///< absent ones included
    std::int64_t chunks = 0;         ///< required by the dataset's shape
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

/// HDF5 1.10 keeps short texts in a heap without checksums and does not check the sizes in it: a
/// flipped bit there may crash the process that reads it, or keep it busy forever. A child process
/// therefore reads everything except the numbers first, for a limited time. Returns how the child
/// died; empty if it did not. Not for processes with several threads.
[[nodiscard]] std::string death_while_opening(const std::filesystem::path& path);

} // namespace culm::archive
