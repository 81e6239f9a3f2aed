// SPDX-License-Identifier: BSD-3-Clause
// Creating groups, attributes and datasets as the study file uses them.
#pragma once

#include "archive/file_descriptor.hpp"
#include "archive/hdf5/handle.hpp"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace culm::archive {

/// An HDF5 file driver for one new file. HDF5 1.10 does not survive a write that fails: it can no
/// longer close the file and ends in a segmentation fault or in an endless loop at exit. Therefore
/// the driver never reports a failed write to HDF5. It stores the first error and skips all later
/// writes; require_written() throws the error.
class Hdf5WriteDriver {
  public:
    /// The data that the driver's functions use.
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
    /// Kept until the file is closed, because H5Fclose still calls the driver after it has released
    /// its own reference to it.
    Hdf5Handle<H5FDunregister> driver_;
};

/// Layout of a dataset; with chunks it has a fletcher32 checksum per chunk.
struct DatasetLayout {
    hid_t type = H5I_INVALID_HID; ///< in the file, little-endian
    std::vector<hsize_t> shape;
    std::vector<hsize_t> chunk; ///< empty: contiguous
    int compression = 1;        ///< deflate level behind the shuffle filter; 0: neither
    std::string unit = "1";
    std::string description; ///< no attribute if empty
};

/// A new HDF5 file under construction. Every failure is a StorageError with its path.
class Hdf5Output {
  public:
    /// Replaces a file of that name, unless another process is writing it. The HDF5 1.10 file
    /// format is used because its metadata carry checksums.
    explicit Hdf5Output(std::filesystem::path path);

    [[nodiscard]] hid_t root() const { return file_.get(); }
    [[nodiscard]] const std::filesystem::path& path() const { return path_; }

    [[nodiscard]] GroupHandle create_group(hid_t parent, const std::string& name) const;
    [[nodiscard]] DatasetHandle create_dataset(hid_t parent, const std::string& name,
                                               const DatasetLayout& layout) const;
    /// A contiguous dataset whose space is allocated and not written; returns its address in the
    /// file, bytes.
    [[nodiscard]] std::uint64_t reserve_dataset(hid_t parent, const std::string& name,
                                                const DatasetLayout& layout) const;
    /// Creates the link `name` in `parent` to the object `target` (absolute).
    void link(const std::string& target, hid_t parent, const std::string& name) const;
    /// The same to an object of another file, whose path is relative to the folder of this one.
    void link_external(const std::string& file, const std::string& target, hid_t parent,
                       const std::string& name) const;

    /// Variable-length UTF-8 attributes, which h5py reads as str.
    void write_attribute(hid_t object, const std::string& name, const std::string& text) const;
    void write_attribute(hid_t object, const std::string& name,
                         std::span<const std::string> texts) const;
    void write_attribute(hid_t object, const std::string& name, std::int64_t value) const;
    void write_attribute(hid_t object, const std::string& name,
                         std::span<const std::int32_t> values) const;

    /// Scalar fixed-length UTF-8 dataset, of any length, with the attribute crc32: a scalar cannot
    /// be chunked, so HDF5 has no checksum for it.
    void write_text(hid_t parent, const std::string& name, const std::string& text) const;

    /// The block [start, start + count) of a dataset from memory of the type `memory_type`.
    void write_block(const DatasetHandle& dataset, std::span<const hsize_t> start,
                     std::span<const hsize_t> count, hid_t memory_type, const void* values) const;
    /// A whole dataset, created and written from memory of the type `memory_type`.
    void write_dataset(hid_t parent, const std::string& name, const DatasetLayout& layout,
                       hid_t memory_type, const void* values) const;
    /// The same for a one-dimensional dataset of doubles.
    void write_series(hid_t parent, const std::string& name, const std::string& unit,
                      std::span<const double> values) const;
    /// The numbers 0 … count − 1 as a dataset.
    void write_numbering(hid_t parent, const std::string& name, std::size_t count,
                         const std::string& description) const;

    /// Writes the remaining data, synchronises and closes.
    void close();

  private:
    void write_attribute_values(hid_t object, const std::string& name, hid_t file_type,
                                hid_t memory_type, const DataspaceHandle& space,
                                const void* values) const;

    std::filesystem::path path_;
    Hdf5WriteDriver driver_; // before file_: closing the file still writes
    FileHandle file_;
};

/// Variable-length UTF-8 text.
[[nodiscard]] DatatypeHandle variable_text_type();
/// UTF-8 text of a fixed number of bytes (at least 1), padded with zeros.
[[nodiscard]] DatatypeHandle fixed_text_type(std::size_t bytes);
/// Enumeration of PointStatus in one byte.
[[nodiscard]] DatatypeHandle status_type();

/// Rows of a table in one chunk, for tables of this many rows.
[[nodiscard]] hsize_t table_chunk_rows(hsize_t rows);

} // namespace culm::archive
