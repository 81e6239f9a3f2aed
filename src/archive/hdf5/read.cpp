// SPDX-License-Identifier: BSD-3-Clause
#include "archive/hdf5/read.hpp"

#include "archive/bytes.hpp"
#include "archive/file_descriptor.hpp"
#include "archive/hdf5/handle.hpp"
#include "archive/hdf5/write.hpp"
#include "core/error.hpp"

#include <algorithm>
#include <cerrno>
#include <exception>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

namespace culm::archive {

namespace {

void strip_padding(std::string& text) {
    text.erase(text.find_last_not_of('\0') + 1);
}

hid_t refuse_to_follow(const char*, hid_t, const void*, std::size_t, hid_t, hid_t) {
    return H5I_INVALID_HID;
}

/// An external link in a hostile file would open other files of this machine with the rights of the
/// user who reads the archive. In this process such links can be made and are not followed.
FileHandle open_without_external_links(const std::filesystem::path& path) {
    H5L_class_t kind{};
    kind.version = H5L_LINK_CLASS_T_VERS;
    kind.id = H5L_TYPE_EXTERNAL;
    kind.trav_func = &refuse_to_follow;
    checked(H5Lregister(&kind), "switch off external links", path);
    const PropertyListHandle access(checked(H5Pcreate(H5P_FILE_ACCESS), "set up access", path));
    // HDF5 ignores only one of the errors of a file system without locks.
    const bool locks = FileDescriptor(path, FileDescriptor::Access::Read).can_be_locked();
    checked(H5Pset_file_locking(access.get(), locks, true), "set file locking", path);
    return FileHandle(checked(H5Fopen(path.c_str(), H5F_ACC_RDONLY, access.get()),
                              "open it as an HDF5 file", path));
}

bool is_fixed_text(hid_t type) {
    return H5Tget_class(type) == H5T_STRING && H5Tis_variable_str(type) == 0;
}

/// In the child: reads, prints nothing, writes no core file, and ends.
[[noreturn]] void read_and_exit(const std::function<void()>& reading) {
    // A crash is possible here and must not fill the user's folder with core files.
    const rlimit nothing{0, 0};
    (void)::setrlimit(RLIMIT_CORE, &nothing);
    // s of processor time, which fork sets to zero; an intact file takes milliseconds. A lower
    // limit of the parent stays.
    constexpr rlim_t most_seconds = 20;
    rlimit patience{most_seconds, most_seconds};
    if (rlimit of_parent{}; ::getrlimit(RLIMIT_CPU, &of_parent) == 0)
        patience.rlim_cur = std::min(most_seconds, of_parent.rlim_cur);
    (void)::setrlimit(RLIMIT_CPU, &patience);
    if (const int silence = ::open("/dev/null", O_WRONLY); silence >= 0)
        (void)::dup2(silence, STDERR_FILENO); // the C library reports a broken heap there
    try {
        reading();
    } catch (const std::exception&) { // a normal error: the parent will meet the same
    }
    ::_exit(0);
}

} // namespace

void require_survival(const std::filesystem::path& path, const std::function<void()>& reading) {
    const pid_t child = ::fork();
    if (child < 0)
        return; // fork failed: the parent reads the file without this test
    if (child == 0)
        read_and_exit(reading);
    int state = 0;
    while (::waitpid(child, &state, 0) < 0 && errno == EINTR) {
    }
    if (WIFSIGNALED(state))
        throw core::StorageError(
            fmt::format("{}: damaged in a part that has no checksum: HDF5 itself crashes or does "
                        "not terminate (signal {})",
                        path.string(), WTERMSIG(state)));
}

Hdf5Input::Hdf5Input(std::filesystem::path path)
    : path_(std::move(path)), file_(open_without_external_links(path_)) {}

void Hdf5Input::refuse(const std::string& object, const std::string& why) const {
    throw core::StorageError(fmt::format("{}: {} {}", path_.string(), object, why));
}

bool Hdf5Input::has(const std::string& object) const {
    // H5Lexists fails, instead of returning false, if a group in the path is missing.
    for (std::size_t end = object.find('/', 1); end != std::string::npos;
         end = object.find('/', end + 1))
        if (H5Lexists(root(), object.substr(0, end).c_str(), H5P_DEFAULT) <= 0)
            return false;
    return H5Lexists(root(), object.c_str(), H5P_DEFAULT) > 0;
}

bool Hdf5Input::has_attribute(const std::string& object, const std::string& name) const {
    return checked(H5Aexists_by_name(root(), object.c_str(), name.c_str(), H5P_DEFAULT),
                   fmt::format("look for the attribute {} of {}", name, object), path_) > 0;
}

AttributeHandle Hdf5Input::open_attribute(const std::string& object,
                                          const std::string& name) const {
    return AttributeHandle(
        checked(H5Aopen_by_name(root(), object.c_str(), name.c_str(), H5P_DEFAULT, H5P_DEFAULT),
                fmt::format("open the attribute {} of {}", name, object), path_));
}

std::string Hdf5Input::text_attribute(const std::string& object, const std::string& name) const {
    const std::vector<std::string> texts = text_list_attribute(object, name);
    if (texts.size() != 1)
        throw core::StorageError(fmt::format("{}: the attribute {} of {} is not one text",
                                             path_.string(), name, object));
    return texts.front();
}

std::vector<std::string> Hdf5Input::text_list_attribute(const std::string& object,
                                                        const std::string& name) const {
    const std::string action = fmt::format("read the attribute {} of {}", name, object);
    const AttributeHandle attribute = open_attribute(object, name);
    const DataspaceHandle space(checked(H5Aget_space(attribute.get()), action, path_));
    const auto count =
        static_cast<std::size_t>(checked(H5Sget_simple_extent_npoints(space.get()), action, path_));
    constexpr std::size_t most_texts = 100'000; // HDF5 itself bounds what is stored: 64 KiB
    if (count > most_texts)
        refuse(object, fmt::format("has {} texts in the attribute {}", count, name));
    std::vector<char*> pointers(count, nullptr);
    const DatatypeHandle type = variable_text_type();
    checked(H5Aread(attribute.get(), type.get(), pointers.data()), action, path_);
    std::vector<std::string> texts;
    texts.reserve(count);
    for (const char* pointer : pointers)
        texts.emplace_back(pointer == nullptr ? "" : pointer);
    // HDF5 has allocated each text separately.
    checked(H5Dvlen_reclaim(type.get(), space.get(), H5P_DEFAULT, pointers.data()), action, path_);
    return texts;
}

std::int64_t Hdf5Input::integer_attribute(const std::string& object,
                                          const std::string& name) const {
    const std::string action = fmt::format("read the attribute {} of {}", name, object);
    std::int64_t value = 0;
    const AttributeHandle attribute = open_attribute(object, name);
    const DataspaceHandle space(checked(H5Aget_space(attribute.get()), action, path_));
    if (checked(H5Sget_simple_extent_npoints(space.get()), action, path_) != 1)
        refuse(object, fmt::format("has more or less than one number in the attribute {}", name));
    checked(H5Aread(attribute.get(), H5T_NATIVE_INT64, &value), action, path_);
    return value;
}

DatasetHandle Hdf5Input::open_dataset(const std::string& name) const {
    DatasetHandle dataset(
        checked(H5Dopen2(root(), name.c_str(), H5P_DEFAULT), "open the dataset " + name, path_));
    const PropertyListHandle list(
        checked(H5Dget_create_plist(dataset.get()), "read the properties of " + name, path_));
    if (H5Pget_layout(list.get()) == H5D_VIRTUAL || H5Pget_external_count(list.get()) != 0)
        refuse(name, "keeps its numbers in other files, which culm never writes");
    return dataset;
}

hsize_t Hdf5Input::element_count(const std::string& dataset, std::size_t element_size) const {
    // Deflate compresses at most a thousandfold, so the stored size limits the number of values. A
    // dataset without chunks is refused too; HDF5 would return fill values for it.
    constexpr long double largest_ratio = 1100.0L;
    const std::vector<hsize_t> extent = shape(dataset);
    long double size = static_cast<long double>(element_size);
    for (const hsize_t length : extent)
        size *= static_cast<long double>(length);
    const auto stored = static_cast<long double>(H5Dget_storage_size(open_dataset(dataset).get()));
    if (size > stored * largest_ratio)
        refuse(dataset, "announces more numbers than the file holds");
    return product(extent);
}

std::vector<hsize_t> Hdf5Input::shape(const std::string& dataset) const {
    const std::string action = "read the shape of " + dataset;
    const DatasetHandle handle = open_dataset(dataset);
    const DataspaceHandle space(checked(H5Dget_space(handle.get()), action, path_));
    const int rank = checked(H5Sget_simple_extent_ndims(space.get()), action, path_);
    std::vector<hsize_t> extent(static_cast<std::size_t>(rank));
    checked(H5Sget_simple_extent_dims(space.get(), extent.data(), nullptr), action, path_);
    return extent;
}

std::string Hdf5Input::text(const std::string& dataset) const {
    const DatasetHandle handle = open_dataset(dataset);
    const DatatypeHandle type(checked(H5Dget_type(handle.get()), "read " + dataset, path_));
    if (!is_fixed_text(type.get()) || element_count(dataset, H5Tget_size(type.get())) != 1)
        refuse(dataset, "is not one text of a fixed length");
    std::string content(H5Tget_size(type.get()), '\0');
    checked(H5Dread(handle.get(), type.get(), H5S_ALL, H5S_ALL, H5P_DEFAULT, content.data()),
            "read " + dataset, path_);
    strip_padding(content);
    if (integer_attribute(dataset, "crc32") != static_cast<std::int64_t>(crc32(content)))
        throw core::StorageError(
            fmt::format("{}: the text {} does not match its checksum", path_.string(), dataset));
    return content;
}

std::string Hdf5Input::text_at(const std::string& dataset, hsize_t row) const {
    const std::string action = "read " + dataset;
    const DatasetHandle handle = open_dataset(dataset);
    const DatatypeHandle type(checked(H5Dget_type(handle.get()), action, path_));
    const DataspaceHandle space(checked(H5Dget_space(handle.get()), action, path_));
    if (!is_fixed_text(type.get()) || shape(dataset).size() != 1)
        refuse(dataset, "is not a list of texts of a fixed length");
    const hsize_t one = 1;
    checked(H5Sselect_hyperslab(space.get(), H5S_SELECT_SET, &row, nullptr, &one, nullptr), action,
            path_);
    const DataspaceHandle memory(H5Screate_simple(1, &one, nullptr));
    std::string content(H5Tget_size(type.get()), '\0');
    checked(
        H5Dread(handle.get(), type.get(), memory.get(), space.get(), H5P_DEFAULT, content.data()),
        action, path_);
    strip_padding(content);
    return content;
}

std::vector<double> Hdf5Input::doubles(const std::string& dataset) const {
    std::vector<double> values(element_count(dataset, sizeof(double)));
    const DatasetHandle handle = open_dataset(dataset);
    checked(H5Dread(handle.get(), H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()),
            "read " + dataset, path_);
    return values;
}

std::vector<double> Hdf5Input::doubles_at(const std::string& dataset, hsize_t row,
                                          hsize_t rows) const {
    const std::string action = "read " + dataset;
    std::vector<hsize_t> count = shape(dataset);
    // Subtract: a row number from a damaged file may be so large that row + rows overflows.
    if (count.empty() || rows > count.front() || row > count.front() - rows)
        refuse(dataset, fmt::format("has no row {}", row + rows - 1));
    static_cast<void>(element_count(dataset, sizeof(double)));
    std::vector<hsize_t> start(count.size(), 0);
    start.front() = row;
    count.front() = rows;
    std::vector<double> values(product(count));
    const DatasetHandle handle = open_dataset(dataset);
    const DataspaceHandle space(checked(H5Dget_space(handle.get()), action, path_));
    checked(H5Sselect_hyperslab(space.get(), H5S_SELECT_SET, start.data(), nullptr, count.data(),
                                nullptr),
            action, path_);
    const DataspaceHandle memory(
        H5Screate_simple(static_cast<int>(count.size()), count.data(), nullptr));
    checked(H5Dread(handle.get(), H5T_NATIVE_DOUBLE, memory.get(), space.get(), H5P_DEFAULT,
                    values.data()),
            action, path_);
    return values;
}

std::vector<std::uint8_t> Hdf5Input::statuses(const std::string& dataset) const {
    std::vector<std::uint8_t> values(element_count(dataset, 1));
    const DatasetHandle handle = open_dataset(dataset);
    checked(
        H5Dread(handle.get(), status_type().get(), H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()),
        "read " + dataset, path_);
    return values;
}

} // namespace culm::archive
