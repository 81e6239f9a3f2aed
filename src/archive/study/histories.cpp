// SPDX-License-Identifier: BSD-3-Clause
#include "archive/study/histories.hpp"

#include <algorithm>
#include <array>
#include <limits>

#include <fmt/format.h>

namespace culm::archive {

namespace {

/// Deflate would reduce the size of histories only by a factor of 1.18, because the low bytes of a
/// double are almost random, and would take 4 to 20 times as long (docs/performance.md, section 9).
constexpr int table_compression = 0;
constexpr hsize_t largest_chunk_bytes =
    hsize_t{512} * 1024; ///< two fit HDF5's default chunk cache, 1 MiB

/// Samples in a chunk when one sample has `doubles_per_sample` doubles. The chunks are as equal as
/// possible, because HDF5 also stores the unused part of the last one.
hsize_t chunk_samples(hsize_t samples, hsize_t doubles_per_sample) {
    const hsize_t fitting = largest_chunk_bytes / (sizeof(double) * doubles_per_sample);
    const hsize_t largest = std::clamp<hsize_t>(fitting, 1, samples);
    const hsize_t chunks = (samples + largest - 1) / largest;
    return (samples + chunks - 1) / chunks;
}

} // namespace

std::string particle_group_name(std::int64_t point) {
    return fmt::format("point_{:06}", point);
}

HistoriesWriter::HistoriesWriter(const Hdf5Output& output, const StudyDescription& description)
    : output_(output), description_(description) {
    const StoredHistories& stored = description.stored;
    if (!stored.tip && !stored.heights && !stored.positions)
        return;
    histories_ = output.create_group(output.root(), "histories");
    output.write_series(histories_.get(), "time", "s", description.times);
    create_tables();
    if (!stored.positions)
        return;
    particles_ = output.create_group(output.root(), "particles");
    // H5MD requires step numbers and times for every trajectory; all share this one dataset.
    output.write_numbering(histories_.get(), "step", description.times.size(),
                           "number of the sample, for the H5MD trajectories");
}

void HistoriesWriter::create_tables() {
    const auto points = static_cast<hsize_t>(description_.points);
    const hsize_t samples = description_.times.size();
    if (description_.stored.tip)
        tip_ = output_.create_dataset(histories_.get(), "tip_deflection",
                                      {H5T_IEEE_F64LE,
                                       {points, samples},
                                       {1, chunk_samples(samples, 1)},
                                       table_compression,
                                       "m",
                                       "lateral deflection of the tip; NaN where there is none"});
    if (!description_.stored.heights)
        return;
    const hsize_t heights = description_.heights.size();
    output_.write_series(histories_.get(), "heights", "m", description_.heights);
    heights_ = output_.create_dataset(histories_.get(), "height_deflection",
                                      {H5T_IEEE_F64LE,
                                       {points, samples, heights},
                                       {1, chunk_samples(samples, heights), heights},
                                       table_compression,
                                       "m",
                                       "lateral deflection at /histories/heights; NaN where there "
                                       "is none"});
}

void HistoriesWriter::append(const PointRecord* record) {
    if (tip_.is_open())
        append_row(tip_, 1, record == nullptr ? nullptr : &record->tip_deflection);
    if (heights_.is_open())
        append_row(heights_, description_.heights.size(),
                   record == nullptr ? nullptr : &record->height_deflection);
    if (particles_.is_open() && record != nullptr)
        write_trajectory(*record);
    ++next_point_;
}

void HistoriesWriter::append_row(const DatasetHandle& dataset, hsize_t doubles_per_sample,
                                 const std::vector<double>* row) {
    // NaN is written explicitly, so that an absent chunk always means damage.
    if (row == nullptr)
        nothing_.assign(description_.times.size() * doubles_per_sample,
                        std::numeric_limits<double>::quiet_NaN());
    const std::array<hsize_t, 3> start{next_point_, 0, 0};
    const std::array<hsize_t, 3> count{1, description_.times.size(), doubles_per_sample};
    const std::size_t rank = &dataset == &tip_ ? 2 : 3;
    output_.write_block(dataset, std::span(start).first(rank), std::span(count).first(rank),
                        H5T_NATIVE_DOUBLE, row == nullptr ? nothing_.data() : row->data());
}

/// One H5MD 1.1 particle group. All groups share the sample times and numbers through hard links,
/// as H5MD proposes for elements that are sampled together.
void HistoriesWriter::write_trajectory(const PointRecord& record) {
    const GroupHandle group =
        output_.create_group(particles_.get(), particle_group_name(record.point));
    const GroupHandle box = output_.create_group(group.get(), "box");
    output_.write_attribute(box.get(), "dimension", std::array<std::int32_t, 1>{3});
    output_.write_attribute(box.get(), "boundary",
                            std::array<std::string, 3>{"none", "none", "none"});
    const GroupHandle position = output_.create_group(group.get(), "position");
    output_.link("/histories/step", position.get(), "step");
    output_.link("/histories/time", position.get(), "time");
    const hsize_t samples = description_.times.size();
    const auto spheres = static_cast<hsize_t>(description_.spheres);
    output_.write_dataset(position.get(), "value",
                          {H5T_IEEE_F64LE,
                           {samples, spheres, 3},
                           {chunk_samples(samples, 3 * spheres), spheres, 3},
                           description_.trajectory_compression,
                           "m",
                           "centres of the spheres: axial, lateral, out of plane"},
                          H5T_NATIVE_DOUBLE, record.positions.data());
}

} // namespace culm::archive
