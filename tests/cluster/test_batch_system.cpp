// SPDX-License-Identifier: BSD-3-Clause
// The remaining time according to the batch system, and the output of other programs.
#include "cluster/batch_system.hpp"

#include <map>
#include <string>

#include <gtest/gtest.h>

namespace culm::cluster {
namespace {

/// A simulated batch system: variables, squeue's answer, and the commands that were run.
struct PaperSystem {
    std::map<std::string, std::string> variables;
    std::string answer;
    std::vector<std::string> asked;

    std::optional<TimeLeft> time_left() {
        return time_left_of_job({[this](const std::string& name) { return variables[name]; },
                                 [this](const std::string& command) {
                                     asked.push_back(command);
                                     return answer;
                                 },
                                 [] { return 1000.0; }, [] { return 40.0; }});
    }
};

TEST(BatchSystem, GivesNoTimeOutsideOfAJob) {
    PaperSystem system;
    EXPECT_FALSE(system.time_left().has_value());
    EXPECT_TRUE(system.asked.empty());
}

TEST(BatchSystem, AsksSlurmOnceBySqueue) {
    PaperSystem system{{{"SLURM_JOB_ID", "17"}}, "1:30:00 \n", {}};
    const auto left = system.time_left();
    ASSERT_TRUE(left.has_value());
    EXPECT_EQ(left->seconds, 5400.0);
    EXPECT_EQ(left->source, "squeue, job 17");
    EXPECT_EQ(system.asked,
              std::vector<std::string>{"squeue --noheader --jobs=17 --Format=TimeLeft"});
}

TEST(BatchSystem, UsesTheEndTimeOfNewerSlurmsWithoutSqueue) {
    PaperSystem system{{{"SLURM_JOB_ID", "17"}, {"SLURM_JOB_END_TIME", "1600"}}, "9:00", {}};
    EXPECT_EQ(system.time_left()->seconds, 600.0);
    EXPECT_TRUE(system.asked.empty());
}

TEST(BatchSystem, GivesNoTimeForAJobWithoutLimitOrAnswer) {
    for (const char* answer : {"UNLIMITED\n", "", "error"}) {
        PaperSystem system{{{"SLURM_JOB_ID", "17"}}, answer, {}};
        EXPECT_FALSE(system.time_left().has_value()) << answer;
    }
}

TEST(BatchSystem, DoesNotAskForAnInvalidJobNumber) {
    PaperSystem system{{{"SLURM_JOB_ID", "17;id"}}, "1:00", {}};
    EXPECT_FALSE(system.time_left().has_value());
    EXPECT_TRUE(system.asked.empty());
}

TEST(BatchSystem, CountsFromTheStartOfTheShellUnderPbs) {
    PaperSystem system{{{"PBS_JOBID", "12.server"}, {"PBS_WALLTIME", "3600"}}, "", {}};
    EXPECT_EQ(system.time_left()->seconds, 3560.0);
    system.variables.erase("PBS_JOBID");
    EXPECT_FALSE(system.time_left().has_value());
}

TEST(BatchSystem, HasASaneClockAndSession) {
    const BatchSystemAccess access = real_batch_system();
    EXPECT_GT(access.now(), 1.7e9); // 2023
    EXPECT_GE(access.session_age(), 0.0);
    EXPECT_EQ(access.variable("CULM_NO_SUCH_VARIABLE"), "");
}

TEST(ProgramOutput, IsWhatTheProgramPrints) {
    using std::chrono::seconds;
    EXPECT_EQ(program_output("printf 'a b'", seconds(20)), "a b");
    EXPECT_EQ(program_output("false", seconds(20)), "");
    EXPECT_EQ(program_output("sh -c 'echo text; exit 1'", seconds(20)), "") << "it failed";
    EXPECT_EQ(program_output("culm-no-such-program", seconds(20)), "");
}

TEST(ProgramOutput, IsEmptyForAProgramThatHangsOrFloods) {
    EXPECT_EQ(program_output("sleep 1000", std::chrono::milliseconds(50)), "");
    EXPECT_EQ(program_output("yes", std::chrono::seconds(20)), "");
}

} // namespace
} // namespace culm::cluster
