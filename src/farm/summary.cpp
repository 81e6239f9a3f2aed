// SPDX-License-Identifier: BSD-3-Clause
#include "farm/summary.hpp"

namespace culm::farm {

void put(WireWriter& out, const Summary& summary) {
    out.put(summary.points_total)
        .put(summary.points_completed)
        .put(summary.points_failed)
        .put(summary.points_lost)
        .put(summary.elapsed_s)
        .put(summary.work_s)
        .put(summary.ranks)
        .put(summary.stopped_early)
        .put(summary.out_of_time)
        .put(summary.pace)
        .put_text(summary.failure)
        .put(summary.lost.size());
    for (const LostBatch& lost : summary.lost)
        out.put(lost.batch).put(lost.rank).put_text(lost.reason);
    out.put(summary.dead_ranks.size());
    for (const int rank : summary.dead_ranks)
        out.put(rank);
}

Summary get_summary(WireReader& in) {
    Summary summary;
    in.get(summary.points_total);
    in.get(summary.points_completed);
    in.get(summary.points_failed);
    in.get(summary.points_lost);
    in.get(summary.elapsed_s);
    in.get(summary.work_s);
    in.get(summary.ranks);
    in.get(summary.stopped_early);
    in.get(summary.out_of_time);
    in.get(summary.pace);
    in.get_text(summary.failure);
    const auto lost_count = in.get<std::size_t>();
    for (std::size_t i = 0; i < lost_count; ++i) {
        LostBatch& lost = summary.lost.emplace_back();
        in.get(lost.batch);
        in.get(lost.rank);
        in.get_text(lost.reason);
    }
    const auto dead_count = in.get<std::size_t>();
    for (std::size_t i = 0; i < dead_count; ++i)
        summary.dead_ranks.push_back(in.get<int>());
    return summary;
}

} // namespace culm::farm
