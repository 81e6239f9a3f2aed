// SPDX-License-Identifier: BSD-3-Clause
// Messages survive the way through bytes, and damaged ones are noticed.
#include "farm/summary.hpp"
#include "farm/wire.hpp"

#include <gtest/gtest.h>

namespace culm::farm {
namespace {

Summary full_summary() {
    Summary summary;
    summary.points_total = 10;
    summary.points_completed = 4;
    summary.points_failed = 3;
    summary.points_lost = 2;
    summary.elapsed_s = 1.5;
    summary.work_s = 2.5;
    summary.ranks = 7;
    summary.stopped_early = true;
    summary.failure = "disk full";
    summary.lost = {{3, 1, "first reason"}, {8, 2, ""}};
    summary.dead_ranks = {5, 6};
    return summary;
}

TEST(Wire, a_summary_comes_back_as_it_was) {
    WireWriter out;
    put(out, full_summary());
    WireReader in(out.take());
    EXPECT_EQ(get_summary(in), full_summary());
}

TEST(Wire, an_empty_summary_comes_back_as_it_was) {
    WireWriter out;
    put(out, Summary());
    WireReader in(out.take());
    EXPECT_EQ(get_summary(in), Summary());
}

TEST(Wire, every_truncated_message_is_refused) {
    WireWriter out;
    put(out, full_summary());
    const Bytes whole = out.take();
    for (std::size_t length = 0; length < whole.size(); ++length) {
        WireReader in(Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(length)));
        EXPECT_THROW((void)get_summary(in), FarmError) << length << " bytes";
    }
}

TEST(Wire, a_text_longer_than_its_message_is_refused_before_memory_is_taken) {
    WireReader in(WireWriter().put(~std::size_t{0}).take());
    std::string text;
    EXPECT_THROW(in.get_text(text), FarmError);
}

} // namespace
} // namespace culm::farm
