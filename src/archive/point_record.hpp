// SPDX-License-Identifier: BSD-3-Clause
// The archived data of one computed point of a study.
#pragma once

#include "archive/trajectory/place.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace culm::archive {

/// State of a point, with the numbers used in the journal and in the study file.
enum class PointStatus : std::uint8_t { Completed = 0, Failed = 1, Missing = 2 };

[[nodiscard]] constexpr const char* to_string(PointStatus status) {
    return status == PointStatus::Completed ? "completed"
           : status == PointStatus::Failed  ? "failed"
                                            : "missing";
}

/// Kind of failure of a point whose process died in every attempt to compute it.
inline constexpr std::string_view rank_died = "rank_died";

/// One computed point; SI units. A history that the study does not store is empty.
struct PointRecord {
    std::int64_t point = 0; ///< index in the study's design
    bool completed = false; ///< false: the computation failed
    /// core::to_string(FailureKind) or rank_died; empty when completed
    std::string failure_kind;
    std::string failure_reason;            ///< one sentence; empty when completed
    std::vector<double> values;            ///< one per result column of the study
    std::vector<double> tip_deflection;    ///< (samples), m
    std::vector<double> height_deflection; ///< (samples, heights) row-major, m
    /// (samples, spheres, 3) row-major, m; empty in a journal
    std::vector<double> positions;
    std::optional<TrajectoryPlace> trajectory; ///< where the positions are stored instead

    [[nodiscard]] PointStatus status() const {
        return completed ? PointStatus::Completed : PointStatus::Failed;
    }
    bool operator==(const PointRecord&) const = default;
};

/// The payload of a journal's record; its header has the rest.
template <class Wire>
void fields(Wire& wire, PointRecord& record) {
    wire(record.failure_kind, record.failure_reason, record.values, record.tip_deflection,
         record.height_deflection, record.trajectory);
}

} // namespace culm::archive
