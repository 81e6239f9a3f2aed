// SPDX-License-Identifier: BSD-3-Clause
// Studies that take some milliseconds, and the contents of their archives, bit for bit.
#pragma once

#include "archive/study/file.hpp"
#include "study/execute/plan.hpp"

#include <bit>
#include <cstdint>
#include <string>
#include <vector>

namespace culm::study::small {

/// 12 points of a short chain (8 spheres, 20 mm, 3.4 kHz at 1 GPa), 5 ms: about 17 periods.
inline const std::string implicit_study = R"(
[study]
name = "implicit"
store = "full"
[stem]
spheres = 8
[release]
tip_deflection_mm = 1
[vibration]
duration_s = 5e-3
sample_interval_s = 2e-5
[factors]
bond_damping = [4, 8, 16]
bond_youngs_modulus_gpa = [1, 2, 4, 9]
)";

/// The same chain with explicit steps below the limit of every point. With 11 points the last batch
/// is partly empty on 2, 4 and 8 lanes.
inline const std::string explicit_study = R"(
[study]
name = "explicit"
store = "tip"
[stem]
spheres = 8
[release]
tip_deflection_mm = 1
[integrator]
method = "explicit"
timestep_s = 2e-9
[vibration]
duration_s = 1e-3
sample_interval_s = 1e-5
[factors]
bond_damping = [1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11]
)";

/// Limits of the explicit step, and two periods at three steps below each, of 2 × 2 short stems.
inline const std::string timestep_study = R"(
[study]
name = "timestep"
kind = "timestep"
[stem]
spheres = 8
[release]
tip_deflection_mm = 1
[factors]
bond_damping = [1, 4]
bond_youngs_modulus_gpa = [1, 9]
[timestep]
fractions = [0.2, 0.5, 0.9]
)";

/// A study whose stability is not checked, as if load_study had missed it.
inline Study unchecked(const std::string& text) {
    Study study{parse_config(text, "s.toml"), {}};
    study.design = make_design(study.config);
    return study;
}

inline std::vector<std::int64_t> all_points(const Study& study) {
    std::vector<std::int64_t> points;
    for (std::int64_t point = 0; point < study.design.point_count(); ++point)
        points.push_back(point);
    return points;
}

/// Appends the bits, so that NaNs compare equal and zeros of opposite sign do not.
inline void append_bits(std::vector<std::uint64_t>& bits, const std::vector<double>& values) {
    bits.push_back(values.size());
    for (const double value : values)
        bits.push_back(std::bit_cast<std::uint64_t>(value));
}

/// Everything in a study file except its provenance.
struct StudyData {
    std::vector<archive::PointStatus> statuses;
    std::vector<std::uint64_t> design;
    std::vector<std::uint64_t> results;
    std::vector<std::uint64_t> histories;
    std::vector<std::string> failures;

    bool operator==(const StudyData&) const = default;
};

inline StudyData data_of(const archive::StudyFile& file) {
    StudyData data{file.statuses(), {}, {}, {}, {}};
    for (const archive::Column& column : file.description().factors)
        append_bits(data.design, file.factor(column.name));
    for (const archive::Column& column : file.description().results)
        append_bits(data.results, file.result(column.name));
    for (std::int64_t point = 0; point < file.point_count(); ++point) {
        if (const auto record = file.record(point)) {
            append_bits(data.histories, record->tip_deflection);
            append_bits(data.histories, record->height_deflection);
            append_bits(data.histories, record->positions);
            data.failures.push_back(record->failure_kind + ": " + record->failure_reason);
        }
    }
    return data;
}

} // namespace culm::study::small
