// SPDX-License-Identifier: BSD-3-Clause
#include "archive/hdf5_write_driver.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <span>

#include <hdf5.h>
#if __has_include(<H5FDdevelop.h>) // from HDF5 1.14 on, what a driver needs stands apart
#include <H5FDdevelop.h>
#endif

#include "archive/hdf5_call.hpp"
#include "core/error.hpp"

namespace culm::archive {

namespace {

using Target = Hdf5WriteDriver::Target;

/// What HDF5 holds of the open file; it knows the base only.
struct DriverFile : H5FD_t {
    Target* target = nullptr;
    haddr_t end_of_allocation = 0;
    haddr_t end_of_file = 0; ///< as if every write had succeeded
};

/// Runs an action on the file; after the first StorageError, nothing any more.
template <class Action>
void attempt(H5FD_t* file, Action action) {
    Target& target = *static_cast<DriverFile*>(file)->target;
    if (!target.error.empty())
        return;
    try {
        action(target.file);
    } catch (const core::StorageError& error) {
        target.error = error.what();
    }
}

H5FD_t* open_file(const char*, unsigned, hid_t access, haddr_t) {
    const void* info = H5Pget_driver_info(access);
    if (info == nullptr)
        return nullptr;
    auto* file = new DriverFile{};
    file->target = *static_cast<Target* const*>(info);
    return file;
}

herr_t close_file(H5FD_t* file) {
    delete static_cast<DriverFile*>(file);
    return 0;
}

herr_t query(const H5FD_t*, unsigned long* flags) {
    if (flags != nullptr)
        *flags = H5FD_FEAT_AGGREGATE_METADATA | H5FD_FEAT_ACCUMULATE_METADATA |
                 H5FD_FEAT_DATA_SIEVE | H5FD_FEAT_AGGREGATE_SMALLDATA |
                 H5FD_FEAT_DEFAULT_VFD_COMPATIBLE;
    return 0;
}

haddr_t end_of_allocation(const H5FD_t* file, H5FD_mem_t) {
    return static_cast<const DriverFile*>(file)->end_of_allocation;
}

herr_t set_end_of_allocation(H5FD_t* file, H5FD_mem_t, haddr_t address) {
    static_cast<DriverFile*>(file)->end_of_allocation = address;
    return 0;
}

haddr_t end_of_file(const H5FD_t* file, H5FD_mem_t) {
    return static_cast<const DriverFile*>(file)->end_of_file;
}

herr_t read_bytes(H5FD_t* file, H5FD_mem_t, hid_t, haddr_t address, std::size_t size,
                  void* buffer) {
    const std::span bytes(static_cast<std::byte*>(buffer), size);
    std::size_t got = 0;
    attempt(file,
            [&](const FileDescriptor& descriptor) { got = descriptor.read_at(bytes, address); });
    // As HDF5's own drivers do: what was allocated but not written yet reads as zeros.
    std::fill(bytes.begin() + static_cast<std::ptrdiff_t>(got), bytes.end(), std::byte{});
    return 0;
}

herr_t write_bytes(H5FD_t* file, H5FD_mem_t, hid_t, haddr_t address, std::size_t size,
                   const void* buffer) {
    auto& end = static_cast<DriverFile*>(file)->end_of_file;
    end = std::max<haddr_t>(end, address + size);
    attempt(file, [&](FileDescriptor& descriptor) {
        descriptor.write_at(std::span(static_cast<const std::byte*>(buffer), size), address);
    });
    return 0;
}

herr_t truncate_file(H5FD_t* file, hid_t, hbool_t) {
    auto& driver_file = *static_cast<DriverFile*>(file);
    if (driver_file.end_of_file != driver_file.end_of_allocation)
        attempt(file, [&](FileDescriptor& descriptor) {
            descriptor.truncate(driver_file.end_of_allocation);
        });
    driver_file.end_of_file = driver_file.end_of_allocation;
    return 0;
}

/// Filled member by member: other HDF5 versions order and extend the structure differently.
H5FD_class_t driver_class() {
    H5FD_class_t driver{};
#ifdef H5FD_CLASS_VERSION
    driver.version = H5FD_CLASS_VERSION;
    driver.value = static_cast<H5FD_class_value_t>(600); // above 512: not registered with HDF5
#endif
    driver.name = "culm_write";
    driver.maxaddr = static_cast<haddr_t>(std::numeric_limits<std::int64_t>::max());
    driver.fc_degree = H5F_CLOSE_WEAK;
    driver.fapl_size = sizeof(Target*);
    driver.open = &open_file;
    driver.close = &close_file;
    driver.query = &query;
    driver.get_eoa = &end_of_allocation;
    driver.set_eoa = &set_end_of_allocation;
    driver.get_eof = &end_of_file;
    driver.read = &read_bytes;
    driver.write = &write_bytes;
    driver.truncate = &truncate_file;
    constexpr std::array<H5FD_mem_t, H5FD_MEM_NTYPES> free_lists = H5FD_FLMAP_DICHOTOMY;
    std::copy(free_lists.begin(), free_lists.end(), std::begin(driver.fl_map));
    return driver;
}

} // namespace

Hdf5WriteDriver::Hdf5WriteDriver(const std::filesystem::path& path)
    : target_(std::make_unique<Target>(
          Target{FileDescriptor(path, FileDescriptor::Access::ReadWriteCreate), {}})) {
    target_->file.lock_exclusively(); // before it is emptied: another process may be writing it
    target_->file.truncate(0);
    const H5FD_class_t driver = driver_class();
    driver_ =
        Hdf5Handle<H5FDunregister>(checked(H5FDregister(&driver), "register a file driver", path));
}

PropertyListHandle Hdf5WriteDriver::access_properties() const {
    const std::filesystem::path& path = target_->file.path();
    PropertyListHandle access(checked(H5Pcreate(H5P_FILE_ACCESS), "set up access", path));
    Target* const target = target_.get();
    checked(H5Pset_driver(access.get(), driver_.get(), static_cast<const void*>(&target)),
            "set the file driver", path);
    return access;
}

void Hdf5WriteDriver::require_written() const {
    if (!target_->error.empty())
        throw core::StorageError(target_->error);
}

void Hdf5WriteDriver::close() {
    require_written();
    target_->file.sync_data();
    target_->file.close();
}

} // namespace culm::archive
