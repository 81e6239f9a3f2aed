// SPDX-License-Identifier: BSD-3-Clause
// Version and location of this program, and the origin of a result: the member "provenance" of the
// JSON documents.
#pragma once

#include "farm/communicator.hpp"
#include "present/provenance.hpp"

#include <chrono>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace culm::cli {

/// Version number and commit.
[[nodiscard]] std::string version_text();

/// Facts for an archive's provenance: version, compiler, architecture, libraries.
[[nodiscard]] std::vector<std::pair<std::string, std::string>> build_provenance();

/// The path `place` relative to this program's folder. Throws core::StorageError if that folder is
/// unknown.
[[nodiscard]] std::filesystem::path beside_own_program(const std::string& place);

/// Replaces this process by `python3 share/culm/postprocess/NAME arguments...`; the variable
/// CULM_PYTHON names another Python. `needs` says in the error message what the program requires.
/// Throws core::StorageError if the program is missing or cannot be run.
[[noreturn]] void run_python_program(const std::string& name,
                                     const std::vector<std::string>& arguments,
                                     const std::string& needs);

/// stem.toml and deflection.csv of every folder, and uncertainty.csv if it exists.
[[nodiscard]] std::vector<std::filesystem::path>
measurement_files(const std::vector<std::filesystem::path>& folders);

/// Effect files among the effects that an option names: "gravity,./drag.toml".
[[nodiscard]] std::vector<std::filesystem::path> effect_files(const std::string& effects);

/// Constructed when a command begins and read when it ends. No other part of a document depends on
/// the number of ranks, the time or the machine.
class RunProvenance {
  public:
    /// `communicator` is null without a launcher; it must outlive this. Rank 0 reads the input
    /// files once each to compute their checksums.
    RunProvenance(const std::vector<std::filesystem::path>& inputs,
                  const farm::Communicator* communicator);

    /// Version, compiler, build, libraries, date of the beginning, command, wall and processor time
    /// (of all ranks since they were started), ranks, and of every input file its size and CRC-32;
    /// complete on rank 0. Collective.
    [[nodiscard]] present::Provenance document() const;
    /// Path, size and CRC-32 of every input file; on rank 0.
    [[nodiscard]] const std::vector<present::InputFile>& inputs() const { return inputs_; }

  private:
    const farm::Communicator* communicator_;
    std::string date_;
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
    std::vector<present::InputFile> inputs_;
};

} // namespace culm::cli
