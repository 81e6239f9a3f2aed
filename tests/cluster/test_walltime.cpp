// SPDX-License-Identifier: BSD-3-Clause
// Durations in the forms of Slurm, PBS and people.
#include "cluster/batch_system.hpp"
#include "core/error.hpp"

#include <string>

#include <gtest/gtest.h>

namespace culm::cluster {
namespace {

TEST(Walltime, IsReadInEveryFormThatBatchSystemsWrite) {
    EXPECT_EQ(parse_walltime("w", "01:02:03"), 3723.0);
    EXPECT_EQ(parse_walltime("w", "100:00:00"), 360000.0);
    EXPECT_EQ(parse_walltime("w", "5:30"), 330.0);
    EXPECT_EQ(parse_walltime("w", "1-12"), 129600.0);
    EXPECT_EQ(parse_walltime("w", "1-00:30"), 88200.0);
    EXPECT_EQ(parse_walltime("w", "2-01:00:01"), 176401.0);
}

TEST(Walltime, IsReadAsANumberWithItsUnit) {
    EXPECT_EQ(parse_walltime("w", "90s"), 90.0);
    EXPECT_EQ(parse_walltime("w", "45min"), 2700.0);
    EXPECT_EQ(parse_walltime("w", "45m"), 2700.0);
    EXPECT_EQ(parse_walltime("w", "1.5h"), 5400.0);
    EXPECT_EQ(parse_walltime("w", "2d"), 172800.0);
}

TEST(Walltime, IsRefusedInOtherForms) {
    // A number alone is minutes for Slurm and seconds for PBS.
    for (const char* text : {"", "90", "-5s", "0s", "00:00:00", "nans", "infs", "1e99s", "1:2:3:4",
                             "1-", "-1", "1--2", "1-2:3:4:5", "s", "12x", "1:2s", "+3:00", "400d"})
        EXPECT_THROW((void)parse_walltime("--walltime", text), core::InputError) << text;
    try {
        (void)parse_walltime("--walltime", "90");
        FAIL();
    } catch (const core::InputError& error) {
        EXPECT_EQ(std::string(error.what()),
                  "--walltime: \"90\" is not a duration above zero and of at most a year; allowed "
                  "are HH:MM:SS, MM:SS, D-HH, D-HH:MM, D-HH:MM:SS, or a number with its unit: 90s, "
                  "45min, 12h, 2d");
    }
}

TEST(Walltime, IsReadAsSqueuePrintsIt) {
    EXPECT_EQ(parse_time_left("1:58                \n"), 118.0);
    EXPECT_EQ(parse_time_left("0:00\n"), 0.0);
    EXPECT_EQ(parse_time_left("1-02:03:04\n"), 93784.0);
    for (const char* text :
         {"", "\n", "UNLIMITED\n", "INVALID", "NOT_SET", "slurm_load_jobs error"})
        EXPECT_EQ(parse_time_left(text), std::nullopt) << text;
}

TEST(Walltime, IsWrittenAsItIsRead) {
    EXPECT_EQ(walltime_text(59.2), "00:01:00");
    EXPECT_EQ(walltime_text(3723.0), "01:02:03");
    EXPECT_EQ(walltime_text(93784.0), "1-02:03:04");
    for (const double seconds : {1.0, 86399.0, 86400.0, 1e6})
        EXPECT_EQ(parse_walltime("w", walltime_text(seconds)), seconds);
}

} // namespace
} // namespace culm::cluster
