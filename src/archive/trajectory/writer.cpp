// SPDX-License-Identifier: BSD-3-Clause
#include "archive/trajectory/writer.hpp"

#include "archive/bytes.hpp"
#include "archive/hdf5/handle.hpp"
#include "archive/hdf5/write.hpp"
#include "archive/trajectory/h5md.hpp"

#include <algorithm>
#include <cstddef>
#include <system_error>
#include <utility>

#include <fmt/format.h>

namespace culm::archive {

namespace {

/// Trajectories that a file has room for. The hole at its end is at most a quarter of what the rank
/// is expected to write (or 15 trajectories), and 1 GiB.
std::size_t room_in_file(const StudyDescription& description, std::int64_t expected) {
    constexpr std::size_t largest_file = std::size_t{1} << 30U; // bytes
    constexpr std::size_t most_groups = 4096;
    const std::size_t bytes = description.times.size() *
                              static_cast<std::size_t>(description.spheres) * 3 *
                              (description.single_precision ? sizeof(float) : sizeof(double));
    const auto wanted = static_cast<std::size_t>(std::max<std::int64_t>(16, expected / 4));
    return std::clamp<std::size_t>(largest_file / bytes, 1, std::min(wanted, most_groups));
}

} // namespace

TrajectoryWriter::TrajectoryWriter(std::filesystem::path folder, std::uint32_t rank,
                                   const StudyDescription& description, std::int64_t expected)
    : folder_(std::move(folder)), description_(description),
      expected_(expected), next_{.rank = rank} {}

TrajectoryPlace TrajectoryWriter::write(std::span<const double> positions) {
    if (!file_ || next_.slot == slots_.size())
        start_file();
    std::span<const std::byte> stored = std::as_bytes(positions);
    if (description_.single_precision) {
        narrowed_.assign(positions.begin(), positions.end());
        widened_.assign(narrowed_.begin(), narrowed_.end());
        stored = std::as_bytes(std::span<const float>(narrowed_));
        positions = widened_;
    }
    file_->write_behind(stored, slots_[next_.slot]);
    TrajectoryPlace place = next_;
    place.crc32 = crc32(std::as_bytes(positions));
    ++next_.slot;
    return place;
}

void TrajectoryWriter::sync() {
    if (file_)
        file_->sync_data();
}

void TrajectoryWriter::start_file() {
    sync();
    file_.reset();
    std::error_code error;
    std::filesystem::create_directories(folder_, error);
    if (error)
        throw_storage_error("create the folder", folder_, error.value());
    while (std::filesystem::exists(folder_ / next_.file_name()))
        ++next_.file;
    const std::filesystem::path path = folder_ / next_.file_name();

    const Hdf5Silence silence;
    Hdf5Output output(path);
    output.write_attribute(output.root(), "format", std::string(trajectory_format_name));
    output.write_attribute(output.root(), "format_version",
                           fmt::format("{}.{}", study_format_major, study_format_minor));
    write_h5md(output, description_);
    (void)create_histories(output, description_);
    const GroupHandle particles = output.create_group(output.root(), "particles");
    slots_.clear();
    next_.slot = 0;
    const std::size_t room = room_in_file(description_, expected_);
    for (; next_.slot < room; ++next_.slot)
        slots_.push_back(output.reserve_dataset(create_particle_group(output, next_.group()).get(),
                                                "value", position_layout(description_)));
    next_.slot = 0;
    output.close();
    sync_path(folder_);
    file_.emplace(path, FileDescriptor::Access::ReadWriteCreate);
}

} // namespace culm::archive
