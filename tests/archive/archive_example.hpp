// SPDX-License-Identifier: BSD-3-Clause
// A small study and files to put it in, shared by the tests of the archive.
#pragma once

#include "archive/point_record.hpp"
#include "archive/study/description.hpp"
#include "support/temporary_folder.hpp"

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <string>
#include <vector>

namespace culm::archive::example {

using tests::TemporaryFolder;

inline std::string read_bytes(const std::filesystem::path& path) {
    std::ifstream stream(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
}

inline void write_bytes(const std::filesystem::path& path, const std::string& bytes) {
    std::ofstream(path, std::ios::binary | std::ios::trunc)
        .write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

inline constexpr std::int64_t point_count = 6;
inline constexpr std::int64_t failed_point = 2;
inline constexpr std::int64_t missing_point = 4;
inline constexpr std::size_t sample_count = 40;
inline constexpr std::size_t height_count = 3;
inline constexpr int sphere_count = 5;

inline const std::string identity = "[study]\npoints = 6\nfactor = \"modulus\"\n";

/// Point 2 failed; every other one completed. No two points share a value.
inline PointRecord record_of(std::int64_t point) {
    PointRecord record;
    record.point = point;
    record.completed = point != failed_point;
    if (!record.completed) {
        record.failure_kind = "instability";
        record.failure_reason = "the tip was at 1e9 m after 0.013 s (β = 200)";
        return record;
    }
    const auto wave = [point](std::size_t i) {
        return 1e-3 * std::sin(0.1 * static_cast<double>(i) + static_cast<double>(point));
    };
    record.values = {55.6 + static_cast<double>(point), 0.64 / static_cast<double>(point + 1)};
    for (std::size_t i = 0; i < sample_count; ++i)
        record.tip_deflection.push_back(wave(i));
    for (std::size_t i = 0; i < sample_count * height_count; ++i)
        record.height_deflection.push_back(wave(i + 1000));
    for (std::size_t i = 0; i < sample_count * sphere_count * 3; ++i)
        record.positions.push_back(wave(i + 5000));
    return record;
}

/// The same as a journal holds it: with the place of the positions instead of these.
inline PointRecord journalled_record_of(std::int64_t point) {
    PointRecord record = record_of(point);
    record.positions.clear();
    if (record.completed)
        record.trajectory = TrajectoryPlace{1, 2, static_cast<std::uint32_t>(point), 0xC0FFEE};
    return record;
}

inline StudyDescription description() {
    StudyDescription study;
    study.points = point_count;
    study.factors = {{"bond_youngs_modulus", "Pa", "Young's modulus of the bonds"},
                     {"bond_damping", "1", "damping β"}};
    study.results = {{"frequency", "Hz", "b2 of Eq. 1"}, {"b1", "1", ""}};
    study.stored = {true, true, true};
    for (std::size_t i = 0; i < sample_count; ++i)
        study.times.push_back(5e-5 * static_cast<double>(i));
    study.heights = {0.02, 0.05, 0.1};
    study.spheres = sphere_count;
    study.identity = identity;
    study.version = "0.1.0";
    study.provenance = {{"compiler", "GNU 12.2"},
                        {"config", std::string(100'000, '#') + "\nβ = [1, 2]\n"},
                        {"seed", "42"},
                        {"hosts", std::string(9000, 'h')}};
    return study;
}

/// (points, factors) row-major.
inline std::vector<double> design() {
    std::vector<double> values;
    for (std::int64_t point = 0; point < point_count; ++point) {
        values.push_back(1e9 * static_cast<double>(point + 1));
        values.push_back(10.0 * static_cast<double>(point) + 0.5);
    }
    return values;
}

} // namespace culm::archive::example
