// SPDX-License-Identifier: BSD-3-Clause
// Fuzz target: study.h5. The first byte chooses: the bytes of the file, or changes to a whole one
// that HDF5 itself makes, so that no checksum is in their way: objects that are absent, of another
// type or another shape, and attributes with other values.
#include "archive/archive_example.hpp"
#include "archive/hdf5/handle.hpp"
#include "archive/study/file.hpp"
#include "archive/study/writer.hpp"
#include "fuzz/fuzz_input.hpp"

#include <array>
#include <iterator>

namespace {

using namespace culm;
using archive::AttributeHandle;
using archive::DatasetHandle;
using archive::DataspaceHandle;
using archive::DatatypeHandle;
using archive::FileHandle;
using archive::PropertyListHandle;

/// Takes bytes from the front of the input, and zeros after its end.
class Choices {
  public:
    Choices(const std::uint8_t* data, std::size_t size) : data_(data), size_(size) {}
    [[nodiscard]] bool is_empty() const { return place_ >= size_; }
    std::uint8_t next() { return is_empty() ? std::uint8_t{0} : data_[place_++]; }
    template <std::size_t N>
    const char* one_of(const std::array<const char*, N>& list) {
        return list.at(next() % N);
    }

  private:
    const std::uint8_t* data_;
    std::size_t size_;
    std::size_t place_ = 0;
};

constexpr std::array objects{"/results/status",
                             "/results/failure_kind",
                             "/results/failure_reason",
                             "/results/frequency",
                             "/results/b1",
                             "/results",
                             "/design/point",
                             "/design/bond_damping",
                             "/design",
                             "/histories/time",
                             "/histories/heights",
                             "/histories/tip_deflection",
                             "/histories/height_deflection",
                             "/histories/step",
                             "/histories",
                             "/provenance/identity",
                             "/provenance/config",
                             "/provenance",
                             "/h5md",
                             "/h5md/creator",
                             "/particles/point_000000/position/value",
                             "/particles/point_000000",
                             "/particles"};
constexpr std::array attributes{"format",
                                "format_version",
                                "points",
                                "spheres",
                                "columns",
                                "entries",
                                "unit",
                                "crc32",
                                "version",
                                "name",
                                "seed",
                                "compiler",
                                "trajectory_compression"};

hid_t type_of(std::uint8_t choice) {
    switch (choice % 8) {
    case 0:
        return H5Tcopy(H5T_IEEE_F64LE);
    case 1:
        return H5Tcopy(H5T_STD_I64LE);
    case 2:
        return H5Tcopy(H5T_STD_U8LE);
    case 3: {
        const hid_t text = H5Tcopy(H5T_C_S1);
        H5Tset_size(text, H5T_VARIABLE);
        return text;
    }
    case 4: {
        const hid_t text = H5Tcopy(H5T_C_S1);
        H5Tset_size(text, 40);
        return text;
    }
    case 5:
        return H5Tvlen_create(H5T_NATIVE_DOUBLE);
    case 6: {
        const hsize_t length = 3;
        return H5Tarray_create2(H5T_NATIVE_DOUBLE, 1, &length);
    }
    default:
        return H5Tcopy(H5T_STD_REF_OBJ);
    }
}

hid_t space_of(Choices& choices) {
    constexpr std::array<hsize_t, 8> lengths{0, 1, 2, 4, 12, 3, 1000, hsize_t{1} << 40U};
    std::array<hsize_t, 3> shape{};
    const int rank = choices.next() % 4;
    for (int axis = 0; axis < rank; ++axis)
        shape.at(static_cast<std::size_t>(axis)) = lengths.at(choices.next() % lengths.size());
    return rank == 0 ? H5Screate(H5S_SCALAR) : H5Screate_simple(rank, shape.data(), nullptr);
}

void replace_dataset(hid_t file, const char* name, Choices& choices) {
    const DatatypeHandle type(type_of(choices.next()));
    const DataspaceHandle space(space_of(choices));
    const PropertyListHandle list(H5Pcreate(H5P_DATASET_CREATE));
    const int rank = H5Sget_simple_extent_ndims(space.get());
    if (rank > 0 && choices.next() % 4 != 0) {
        std::array<hsize_t, 3> chunk{4, 4, 4};
        H5Pset_chunk(list.get(), rank, chunk.data());
    }
    H5Ldelete(file, name, H5P_DEFAULT);
    const DatasetHandle dataset(
        H5Dcreate2(file, name, type.get(), space.get(), H5P_DEFAULT, list.get(), H5P_DEFAULT));
}

void replace_attribute(hid_t file, const char* object, const char* name, Choices& choices) {
    constexpr std::array<std::int64_t, 6> numbers{0, -1, 1, 6, 1'000'000'000'000, 255};
    const DatatypeHandle type(type_of(choices.next()));
    const DataspaceHandle space(space_of(choices));
    constexpr hssize_t largest_attribute = 10'000; // HDF5 allocates its memory before it refuses
    if (H5Sget_simple_extent_npoints(space.get()) > largest_attribute)
        return;
    H5Adelete_by_name(file, object, name, H5P_DEFAULT);
    const AttributeHandle attribute(H5Acreate_by_name(file, object, name, type.get(), space.get(),
                                                      H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
    if (!attribute.is_open() || H5Sget_simple_extent_npoints(space.get()) != 1)
        return;
    const std::int64_t number = numbers.at(choices.next() % numbers.size());
    if (H5Tget_class(type.get()) == H5T_INTEGER)
        H5Awrite(attribute.get(), H5T_NATIVE_INT64, &number);
    const char* text = "1.0";
    if (H5Tis_variable_str(type.get()) > 0)
        H5Awrite(attribute.get(), type.get(), static_cast<const void*>(&text));
}

void change(const std::filesystem::path& path, Choices choices) {
    const archive::Hdf5Silence silence;
    const FileHandle file(H5Fopen(path.c_str(), H5F_ACC_RDWR, H5P_DEFAULT));
    for (int changes = 0; !choices.is_empty() && changes < 8; ++changes) {
        switch (choices.next() % 5) {
        case 0:
            H5Ldelete(file.get(), choices.one_of(objects), H5P_DEFAULT);
            break;
        case 1:
            replace_dataset(file.get(), choices.one_of(objects), choices);
            break;
        case 2: {
            const char* object = choices.next() % 2 == 0 ? "/" : choices.one_of(objects);
            replace_attribute(file.get(), object, choices.one_of(attributes), choices);
            break;
        }
        case 3: {
            const char* from = choices.one_of(objects);
            const char* to = choices.one_of(objects);
            H5Ldelete(file.get(), to, H5P_DEFAULT);
            H5Lcreate_soft(from, file.get(), to, H5P_DEFAULT, H5P_DEFAULT);
            break;
        }
        default: {
            const char* from = choices.one_of(objects);
            const char* to = choices.one_of(objects);
            H5Ldelete(file.get(), to, H5P_DEFAULT);
            H5Lcreate_hard(file.get(), from, file.get(), to, H5P_DEFAULT, H5P_DEFAULT);
        }
        }
    }
}

/// A whole study, small enough to be changed some thousand times a second.
const std::string& whole_study() {
    static const std::string bytes = [] {
        archive::StudyDescription description = archive::example::description();
        description.points = 3; // completed, missing, failed
        description.times.resize(2);
        description.heights.resize(1);
        description.spheres = 2;
        description.provenance = {{"config", "[study]\n"}, {"seed", "42"}};
        const std::filesystem::path path = fuzz::folder() / "whole.h5";
        archive::write_study_file(path, description, std::vector{1.0, 2.0, 3.0, 4.0, 5.0, 6.0},
                                  [](std::int64_t point) -> std::optional<archive::PointRecord> {
                                      if (point == 1)
                                          return std::nullopt;
                                      archive::PointRecord record =
                                          archive::example::record_of(point);
                                      record.tip_deflection.resize(record.completed ? 2 : 0);
                                      record.height_deflection.resize(record.completed ? 2 : 0);
                                      record.positions.resize(record.completed ? 12 : 0);
                                      return record;
                                  });
        return archive::example::read_bytes(path);
    }();
    return bytes;
}

/// Reads an archive in every way in which culm does.
void read(const std::filesystem::path& path) {
    fuzz::may_refuse([&] { static_cast<void>(archive::verify(path)); });
    fuzz::may_refuse([&] {
        const archive::StudyFile file(path);
        for (const archive::Column& column : file.description().results)
            fuzz::may_refuse([&] { static_cast<void>(file.result(column.name)); });
        for (std::int64_t point = -1; point < 4; ++point)
            fuzz::may_refuse([&] { static_cast<void>(file.record(point)); });
    });
}

} // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    if (size == 0)
        return 0;
    if (data[0] % 8 == 0) {
        read(fuzz::write("study.h5", fuzz::text_of(data + 1, size - 1)));
        return 0;
    }
    const auto path = fuzz::write("study.h5", whole_study());
    change(path, Choices(data + 1, size - 1));
    read(path);
    return 0;
}
