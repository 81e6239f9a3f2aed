// SPDX-License-Identifier: BSD-3-Clause
// Checked HDF5 calls: a failure becomes a StorageError with file, action and HDF5's own reason.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include <hdf5.h>

namespace culm::archive {

/// Keeps HDF5 from printing its errors while it lives.
class Hdf5Silence {
  public:
    Hdf5Silence() {
        H5Eget_auto2(H5E_DEFAULT, &function_, &data_);
        H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
    }
    ~Hdf5Silence() { H5Eset_auto2(H5E_DEFAULT, function_, data_); }
    Hdf5Silence(const Hdf5Silence&) = delete;
    Hdf5Silence& operator=(const Hdf5Silence&) = delete;

  private:
    H5E_auto2_t function_ = nullptr;
    void* data_ = nullptr;
};

/// The innermost message of HDF5's error stack, which names the cause ("data error detected by
/// Fletcher32 checksum"); with advice when a file lock was refused.
[[nodiscard]] std::string hdf5_reason();

/// Throws StorageError "<path>: cannot <action>: <hdf5_reason()>".
[[noreturn]] void throw_hdf5_error(std::string_view action, const std::filesystem::path& path);

/// The result of an HDF5 call, unless it is negative: then throw_hdf5_error.
template <class Result>
Result checked(Result result, std::string_view action, const std::filesystem::path& path) {
    if (result < 0)
        throw_hdf5_error(action, path);
    return result;
}

} // namespace culm::archive
