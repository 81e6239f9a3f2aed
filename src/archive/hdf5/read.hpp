// SPDX-License-Identifier: BSD-3-Clause
// Reading groups, attributes and datasets of a study file.
#pragma once

#include "archive/hdf5/handle.hpp"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <numeric>
#include <string>
#include <vector>

namespace culm::archive {

/// Number of elements of a shape.
[[nodiscard]] inline hsize_t product(const std::vector<hsize_t>& shape) {
    return std::accumulate(shape.begin(), shape.end(), hsize_t{1}, std::multiplies<>());
}

/// HDF5 1.10 keeps short texts in a heap without checksums and does not check the sizes in it: a
/// flipped bit there may crash the process that reads it, or keep it busy forever. A child process
/// therefore performs `reading` first, with limited time. StorageError if the child dies; its
/// exceptions are ignored. Not for processes with several threads.
void require_survival(const std::filesystem::path& path, const std::function<void()>& reading);

/// An HDF5 file opened for reading. Objects are named by their absolute paths. Every failure is a
/// StorageError with the file's path and the object's name. An object is refused if culm does not
/// write its type or shape, or if its shape exceeds the size of the file. External links are not
/// followed.
class Hdf5Input {
  public:
    explicit Hdf5Input(std::filesystem::path path);

    [[nodiscard]] const std::filesystem::path& path() const { return path_; }
    [[nodiscard]] hid_t root() const { return file_.get(); }
    /// Whether an object of that name exists; false if one of its groups is missing.
    [[nodiscard]] bool has(const std::string& object) const;
    [[nodiscard]] bool has_attribute(const std::string& object, const std::string& name) const;

    [[nodiscard]] std::string text_attribute(const std::string& object,
                                             const std::string& name) const;
    /// All texts of a list attribute.
    [[nodiscard]] std::vector<std::string> text_list_attribute(const std::string& object,
                                                               const std::string& name) const;
    [[nodiscard]] std::int64_t integer_attribute(const std::string& object,
                                                 const std::string& name) const;

    /// Refuses datasets whose numbers are stored in other files.
    [[nodiscard]] DatasetHandle open_dataset(const std::string& name) const;
    [[nodiscard]] std::vector<hsize_t> shape(const std::string& dataset) const;
    /// A scalar text whose attribute crc32 is verified.
    [[nodiscard]] std::string text(const std::string& dataset) const;
    /// One element of a list of fixed-length texts.
    [[nodiscard]] std::string text_at(const std::string& dataset, hsize_t row) const;
    /// All of a dataset of doubles.
    [[nodiscard]] std::vector<double> doubles(const std::string& dataset) const;
    /// The slices [row], … [row + rows − 1] along the first axis of a dataset of doubles.
    [[nodiscard]] std::vector<double> doubles_at(const std::string& dataset, hsize_t row,
                                                 hsize_t rows = 1) const;
    /// All of a dataset of PointStatus.
    [[nodiscard]] std::vector<std::uint8_t> statuses(const std::string& dataset) const;

  private:
    [[noreturn]] void refuse(const std::string& object, const std::string& why) const;
    /// Product of the shape, checked against the stored size.
    [[nodiscard]] hsize_t element_count(const std::string& dataset, std::size_t element_size) const;
    [[nodiscard]] AttributeHandle open_attribute(const std::string& object,
                                                 const std::string& name) const;

    std::filesystem::path path_;
    FileHandle file_;
};

} // namespace culm::archive
