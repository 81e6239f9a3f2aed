// SPDX-License-Identifier: BSD-3-Clause
#include "archive/hdf5/write.hpp"

#include "archive/bytes.hpp"
#include "archive/hdf5/handle.hpp"
#include "archive/point_record.hpp"
#include "core/error.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <numeric>
#include <span>

#include <hdf5.h>
#if __has_include(<H5FDdevelop.h>) // the declarations for drivers, from HDF5 1.14 on
#include <H5FDdevelop.h>
#endif

namespace culm::archive {

namespace {

using Target = Hdf5WriteDriver::Target;

/// HDF5's object for the open file; HDF5 uses only the base.
struct DriverFile : H5FD_t {
    Target* target = nullptr;
    haddr_t end_of_allocation = 0;
    haddr_t end_of_file = 0; ///< as if every write had succeeded
};

/// Runs an action on the file; does nothing after the first StorageError.
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

/// HDF5 hands over its copy of what access_properties() set: the address of the target.
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

/// As HDF5's own POSIX driver, without the flags for access by POSIX descriptor and for concurrent
/// readers.
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
    // As in HDF5's own drivers, allocated bytes that are not written yet read as zeros.
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

/// Objects store no time, so that two archives of the same content have the same bytes.
PropertyListHandle properties_without_times(hid_t kind, const std::filesystem::path& path) {
    PropertyListHandle list(H5Pcreate(kind));
    checked(H5Pset_obj_track_times(list.get(), false), "switch off object times", path);
    return list;
}

FileHandle create_file(const Hdf5WriteDriver& driver, const std::filesystem::path& path) {
    const PropertyListHandle access = driver.access_properties();
    // Both bounds are fixed, so that a newer library writes the same bytes.
    checked(H5Pset_libver_bounds(access.get(), H5F_LIBVER_V110, H5F_LIBVER_V110),
            "set the file format", path);
    // Closing the file also closes objects in it that are still open after an exception.
    checked(H5Pset_fclose_degree(access.get(), H5F_CLOSE_STRONG), "set up access", path);
    const PropertyListHandle creation = properties_without_times(H5P_FILE_CREATE, path);
    return FileHandle(checked(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, creation.get(), access.get()),
                              "create the file", path));
}

/// Properties of a dataset; the checksum is the last filter, so that it guards the stored bytes.
PropertyListHandle creation_properties(const DatasetLayout& layout,
                                       const std::filesystem::path& path) {
    PropertyListHandle list = properties_without_times(H5P_DATASET_CREATE, path);
    if (layout.chunk.empty()) {
        checked(H5Pset_alloc_time(list.get(), H5D_ALLOC_TIME_EARLY), "allocate the space", path);
        checked(H5Pset_fill_time(list.get(), H5D_FILL_TIME_NEVER), "leave out fill values", path);
        return list;
    }
    checked(H5Pset_chunk(list.get(), static_cast<int>(layout.chunk.size()), layout.chunk.data()),
            "set a chunk shape", path);
    if (layout.compression > 0) {
        checked(H5Pset_shuffle(list.get()), "set the shuffle filter", path);
        checked(H5Pset_deflate(list.get(), static_cast<unsigned>(layout.compression)),
                "set the deflate filter", path);
    }
    checked(H5Pset_fletcher32(list.get()), "set the checksum filter", path);
    if (H5Tget_class(layout.type) == H5T_FLOAT) {
        // Values that were never written must not read as a plausible zero.
        const double fill = std::numeric_limits<double>::quiet_NaN();
        checked(H5Pset_fill_value(list.get(), H5T_NATIVE_DOUBLE, &fill), "set a fill value", path);
    }
    return list;
}

DataspaceHandle scalar_space() {
    return DataspaceHandle(H5Screate(H5S_SCALAR));
}

DataspaceHandle list_space(std::size_t size) {
    const hsize_t extent = size;
    return DataspaceHandle(H5Screate_simple(1, &extent, nullptr));
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

DatatypeHandle variable_text_type() {
    DatatypeHandle type(H5Tcopy(H5T_C_S1));
    H5Tset_size(type.get(), H5T_VARIABLE);
    H5Tset_cset(type.get(), H5T_CSET_UTF8);
    return type;
}

/// HDF5 stores texts of variable length in a heap without checksums. Texts of fixed length are part
/// of the dataset's chunks, which have checksums.
DatatypeHandle fixed_text_type(std::size_t bytes) {
    DatatypeHandle type(H5Tcopy(H5T_C_S1));
    H5Tset_size(type.get(), std::max<std::size_t>(bytes, 1));
    H5Tset_cset(type.get(), H5T_CSET_UTF8);
    H5Tset_strpad(type.get(), H5T_STR_NULLPAD);
    return type;
}

DatatypeHandle status_type() {
    DatatypeHandle type(H5Tenum_create(H5T_STD_U8LE));
    for (const PointStatus status :
         {PointStatus::Completed, PointStatus::Failed, PointStatus::Missing})
        H5Tenum_insert(type.get(), to_string(status), &status);
    return type;
}

hsize_t table_chunk_rows(hsize_t rows) {
    constexpr hsize_t largest = 8192; // 64 KiB of doubles
    return std::min(rows, largest);
}

Hdf5Output::Hdf5Output(std::filesystem::path path)
    : path_(std::move(path)), driver_(path_), file_(create_file(driver_, path_)) {}

GroupHandle Hdf5Output::create_group(hid_t parent, const std::string& name) const {
    const PropertyListHandle list = properties_without_times(H5P_GROUP_CREATE, path_);
    checked(H5Pset_attr_creation_order(list.get(), H5P_CRT_ORDER_TRACKED | H5P_CRT_ORDER_INDEXED),
            "track the order of attributes", path_);
    return GroupHandle(
        checked(H5Gcreate2(parent, name.c_str(), H5P_DEFAULT, list.get(), H5P_DEFAULT),
                "create the group " + name, path_));
}

DatasetHandle Hdf5Output::create_dataset(hid_t parent, const std::string& name,
                                         const DatasetLayout& layout) const {
    const std::string action = "create the dataset " + name;
    const DataspaceHandle space(checked(
        H5Screate_simple(static_cast<int>(layout.shape.size()), layout.shape.data(), nullptr),
        action, path_));
    const PropertyListHandle list = creation_properties(layout, path_);
    DatasetHandle dataset(checked(H5Dcreate2(parent, name.c_str(), layout.type, space.get(),
                                             H5P_DEFAULT, list.get(), H5P_DEFAULT),
                                  action, path_));
    write_attribute(dataset.get(), "unit", layout.unit);
    if (!layout.description.empty())
        write_attribute(dataset.get(), "description", layout.description);
    return dataset;
}

std::uint64_t Hdf5Output::reserve_dataset(hid_t parent, const std::string& name,
                                          const DatasetLayout& layout) const {
    const haddr_t address = H5Dget_offset(create_dataset(parent, name, layout).get());
    if (address == HADDR_UNDEF)
        throw_hdf5_error("allocate the dataset " + name, path_);
    return address;
}

void Hdf5Output::link(const std::string& target, hid_t parent, const std::string& name) const {
    checked(H5Lcreate_hard(root(), target.c_str(), parent, name.c_str(), H5P_DEFAULT, H5P_DEFAULT),
            "link " + name + " to " + target, path_);
}

void Hdf5Output::link_external(const std::string& file, const std::string& target, hid_t parent,
                               const std::string& name) const {
    checked(H5Lcreate_external(file.c_str(), target.c_str(), parent, name.c_str(), H5P_DEFAULT,
                               H5P_DEFAULT),
            "link " + name + " to " + file, path_);
}

void Hdf5Output::write_attribute_values(hid_t object, const std::string& name, hid_t file_type,
                                        hid_t memory_type, const DataspaceHandle& space,
                                        const void* values) const {
    const std::string action = "write the attribute " + name;
    const AttributeHandle attribute(
        checked(H5Acreate2(object, name.c_str(), file_type, space.get(), H5P_DEFAULT, H5P_DEFAULT),
                action, path_));
    checked(H5Awrite(attribute.get(), memory_type, values), action, path_);
}

void Hdf5Output::write_attribute(hid_t object, const std::string& name,
                                 const std::string& text) const {
    const char* pointer = text.c_str();
    const DatatypeHandle type = variable_text_type();
    write_attribute_values(object, name, type.get(), type.get(), scalar_space(), &pointer);
}

void Hdf5Output::write_attribute(hid_t object, const std::string& name,
                                 std::span<const std::string> texts) const {
    std::vector<const char*> pointers;
    for (const std::string& text : texts)
        pointers.push_back(text.c_str());
    const DatatypeHandle type = variable_text_type();
    write_attribute_values(object, name, type.get(), type.get(), list_space(pointers.size()),
                           pointers.data());
}

void Hdf5Output::write_attribute(hid_t object, const std::string& name, std::int64_t value) const {
    write_attribute_values(object, name, H5T_STD_I64LE, H5T_NATIVE_INT64, scalar_space(), &value);
}

void Hdf5Output::write_attribute(hid_t object, const std::string& name,
                                 std::span<const std::int32_t> values) const {
    write_attribute_values(object, name, H5T_STD_I32LE, H5T_NATIVE_INT32, list_space(values.size()),
                           values.data());
}

void Hdf5Output::write_text(hid_t parent, const std::string& name, const std::string& text) const {
    const std::string action = "write the text " + name;
    const DatatypeHandle type = fixed_text_type(text.size());
    const DataspaceHandle space = scalar_space();
    const PropertyListHandle list = properties_without_times(H5P_DATASET_CREATE, path_);
    const DatasetHandle dataset(checked(H5Dcreate2(parent, name.c_str(), type.get(), space.get(),
                                                   H5P_DEFAULT, list.get(), H5P_DEFAULT),
                                        action, path_));
    checked(H5Dwrite(dataset.get(), type.get(), H5S_ALL, H5S_ALL, H5P_DEFAULT, text.c_str()),
            action, path_);
    write_attribute(dataset.get(), "unit", std::string("1"));
    write_attribute(dataset.get(), "crc32", static_cast<std::int64_t>(crc32(text)));
}

void Hdf5Output::write_block(const DatasetHandle& dataset, std::span<const hsize_t> start,
                             std::span<const hsize_t> count, hid_t memory_type,
                             const void* values) const {
    const DataspaceHandle file_space(
        checked(H5Dget_space(dataset.get()), "examine a dataset", path_));
    checked(H5Sselect_hyperslab(file_space.get(), H5S_SELECT_SET, start.data(), nullptr,
                                count.data(), nullptr),
            "select a block", path_);
    const DataspaceHandle memory_space(
        checked(H5Screate_simple(static_cast<int>(count.size()), count.data(), nullptr),
                "describe a block", path_));
    const herr_t result = H5Dwrite(dataset.get(), memory_type, memory_space.get(), file_space.get(),
                                   H5P_DEFAULT, values);
    driver_.require_written();
    checked(result, "write a dataset", path_);
}

void Hdf5Output::write_dataset(hid_t parent, const std::string& name, const DatasetLayout& layout,
                               hid_t memory_type, const void* values) const {
    const DatasetHandle dataset = create_dataset(parent, name, layout);
    const std::vector<hsize_t> start(layout.shape.size(), 0);
    write_block(dataset, start, layout.shape, memory_type, values);
}

void Hdf5Output::write_series(hid_t parent, const std::string& name, const std::string& unit,
                              std::span<const double> values) const {
    const hsize_t rows = values.size();
    write_dataset(parent, name, {H5T_IEEE_F64LE, {rows}, {table_chunk_rows(rows)}, 1, unit, {}},
                  H5T_NATIVE_DOUBLE, values.data());
}

void Hdf5Output::write_numbering(hid_t parent, const std::string& name, std::size_t count,
                                 const std::string& description) const {
    std::vector<std::int64_t> numbers(count);
    std::iota(numbers.begin(), numbers.end(), 0);
    write_dataset(parent, name,
                  {H5T_STD_I64LE, {count}, {table_chunk_rows(count)}, 1, "1", description},
                  H5T_NATIVE_INT64, numbers.data());
}

void Hdf5Output::close() {
    const herr_t result = file_.close();
    driver_.require_written();
    checked(result, "close the file", path_);
    driver_.close();
}

} // namespace culm::archive
