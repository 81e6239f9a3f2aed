// SPDX-License-Identifier: BSD-3-Clause
// Checked HDF5 calls (a failure becomes a StorageError with file, action and HDF5's own reason),
// and move-only owners of HDF5 identifiers, one type per kind of object.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <utility>

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

/// Owns an identifier that is released by Close.
template <herr_t (*Close)(hid_t)>
class Hdf5Handle {
  public:
    Hdf5Handle() = default;
    explicit Hdf5Handle(hid_t id) : id_(id) {}
    ~Hdf5Handle() {
        if (id_ >= 0)
            Close(id_);
    }
    Hdf5Handle(Hdf5Handle&& other) noexcept : id_(std::exchange(other.id_, H5I_INVALID_HID)) {}
    Hdf5Handle& operator=(Hdf5Handle&& other) noexcept {
        std::swap(id_, other.id_);
        return *this;
    }
    Hdf5Handle(const Hdf5Handle&) = delete;
    Hdf5Handle& operator=(const Hdf5Handle&) = delete;

    [[nodiscard]] hid_t get() const { return id_; }
    [[nodiscard]] bool is_open() const { return id_ >= 0; }
    /// Closes the identifier now. Check the result, because closing writes data.
    [[nodiscard]] herr_t close() {
        return id_ >= 0 ? Close(std::exchange(id_, H5I_INVALID_HID)) : 0;
    }

  private:
    hid_t id_ = H5I_INVALID_HID;
};

using FileHandle = Hdf5Handle<H5Fclose>;
using GroupHandle = Hdf5Handle<H5Gclose>;
using DatasetHandle = Hdf5Handle<H5Dclose>;
using DataspaceHandle = Hdf5Handle<H5Sclose>;
using DatatypeHandle = Hdf5Handle<H5Tclose>;
using AttributeHandle = Hdf5Handle<H5Aclose>;
using PropertyListHandle = Hdf5Handle<H5Pclose>;

} // namespace culm::archive
