// SPDX-License-Identifier: BSD-3-Clause
// Move-only owners of HDF5 identifiers, one type per kind of object.
#pragma once

#include <utility>

#include <hdf5.h>

namespace culm::archive {

/// Owns an identifier that is given back with Close.
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
    /// Gives the identifier back now; the result is to be checked, for closing writes.
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
