// SPDX-License-Identifier: BSD-3-Clause
// The file below HDF5 while a study file is written: a full disk must not crash the library.
#pragma once

#include "archive/file_descriptor.hpp"
#include "archive/hdf5_handle.hpp"

#include <filesystem>
#include <memory>
#include <string>

namespace culm::archive {

/// An HDF5 file driver for one new file. HDF5 1.10 does not survive a write that fails: it cannot
/// close the file any more and ends in a segmentation fault or in an endless loop at exit. So the
/// driver never reports a failed write to HDF5; it remembers the first one, drops all later ones,
/// and the owner asks for it.
class Hdf5WriteDriver {
  public:
    /// What the driver's functions work on.
    struct Target {
        FileDescriptor file;
        std::string error; ///< of the first failed write; empty: none
    };

    /// Creates or empties the file and locks it against other processes. StorageError.
    explicit Hdf5WriteDriver(const std::filesystem::path& path);

    /// File access properties with this driver, to be used for one H5Fcreate.
    [[nodiscard]] PropertyListHandle access_properties() const;
    /// StorageError with the reason of the first write that failed, if any did.
    void require_written() const;
    /// After H5Fclose: synchronises and closes the file. StorageError.
    void close();

  private:
    std::unique_ptr<Target> target_; // HDF5 keeps its address
    /// Held until the file is closed: H5Fclose releases the file's own hold on the driver, and
    /// calls the driver after that.
    Hdf5Handle<H5FDunregister> driver_;
};

} // namespace culm::archive
