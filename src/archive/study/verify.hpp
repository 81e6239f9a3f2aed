// SPDX-License-Identifier: BSD-3-Clause
// Whether every byte of a study file's data is still what was written, and whether HDF5 can open
// the file without crashing.
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

/// HDF5 1.10 keeps short texts in a heap without checksums and believes the sizes in it: a flipped
/// bit there may end the process that reads it, or keep it busy forever. So a child process first
/// reads everything except the numbers, for a limited time. Empty if it survived (whatever it
/// thinks of the file), else what happened to it. Not for processes with several threads.
[[nodiscard]] std::string death_while_opening(const std::filesystem::path& path);

} // namespace culm::archive
