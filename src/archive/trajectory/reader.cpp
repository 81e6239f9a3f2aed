// SPDX-License-Identifier: BSD-3-Clause
#include "archive/trajectory/reader.hpp"

#include "archive/bytes.hpp"
#include "archive/hdf5/handle.hpp"
#include "core/error.hpp"

#include <span>
#include <utility>

#include <fmt/format.h>

namespace culm::archive {

std::vector<double> TrajectoryFolder::read(const TrajectoryPlace& place) {
    const Hdf5Silence silence;
    const Hdf5Input& input = open(place.file_name());
    const std::string name = place.group() + "/position/value";
    std::vector<double> positions = input.doubles(name);
    if (crc32(std::as_bytes(std::span(positions))) != place.crc32)
        throw core::StorageError(
            fmt::format("{}: {} does not match its checksum", input.path().string(), name));
    return positions;
}

const Hdf5Input& TrajectoryFolder::open(const std::string& file) {
    constexpr std::size_t most_open_files = 32;
    if (const auto found = open_.find(file); found != open_.end())
        return found->second;
    if (open_.size() == most_open_files)
        open_.clear();
    const std::filesystem::path path = folder_ / file;
    if (!std::filesystem::exists(path))
        throw core::StorageError(
            fmt::format("{} is missing; it holds trajectories of the study", path.string()));
    require_survival(path, [&] { (void)Hdf5Input(path).text_attribute("/", "format"); });
    Hdf5Input input(path);
    if (input.text_attribute("/", "format") != trajectory_format_name)
        throw core::StorageError(path.string() + " is not a file of trajectories");
    return open_.try_emplace(file, std::move(input)).first->second;
}

} // namespace culm::archive
