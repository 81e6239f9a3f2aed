// SPDX-License-Identifier: BSD-3-Clause
// Jobs are sized from the cost model, and their scripts contain user text only as quoted words.
#include "cluster/job_script.hpp"
#include "core/error.hpp"

#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace culm::cluster {
namespace {

std::vector<farm::Batch> batches(int count, double cost) {
    return std::vector<farm::Batch>(static_cast<std::size_t>(count), farm::Batch{{0}, cost});
}

TEST(JobSize, FollowsTheReferenceMachineUntilSomethingWasTimed) {
    const JobSize size = size_job(batches(1000, 60.0), {}, {2, 16, std::nullopt});
    EXPECT_EQ(size.ranks, 32);
    EXPECT_EQ(size.nodes, 2);
    EXPECT_DOUBLE_EQ(size.core_seconds, 60000.0);
    // 31.25 batches for each rank: some compute 32.
    EXPECT_DOUBLE_EQ(size.compute_s, 1920.0);
    // Twice that and two minutes, in whole minutes.
    EXPECT_DOUBLE_EQ(size.walltime_s, 3960.0);
    EXPECT_EQ(size.jobs, 1);
    EXPECT_FALSE(size.pace_is_learned);
}

TEST(JobSize, FollowsTheLearnedPace) {
    farm::Pace pace;
    pace.learn(100.0, 300.0); // this machine takes three times as long
    const JobSize size = size_job(batches(1000, 60.0), pace, {2, 16, std::nullopt});
    EXPECT_DOUBLE_EQ(size.core_seconds, 180000.0);
    EXPECT_DOUBLE_EQ(size.longest_batch_s, 198.0); // a tenth more, to be sure
    EXPECT_TRUE(size.pace_is_learned);
}

TEST(JobSize, TakesNoMoreRanksThanThereAreBatches) {
    const JobSize size = size_job(batches(20, 60.0), {}, {4, 16, std::nullopt});
    EXPECT_EQ(size.ranks, 20);
    EXPECT_EQ(size.nodes, 2);
}

TEST(JobSize, GivesEveryRankWork) {
    const JobSize size = size_job(batches(100, 0.22), {}, {2, 16, std::nullopt});
    EXPECT_EQ(size.ranks, 3); // 22 s
    EXPECT_EQ(size.nodes, 1);
    EXPECT_DOUBLE_EQ(size.walltime_s, 300.0);
}

TEST(JobSize, GivesTheNumberOfShortJobs) {
    const JobSize size = size_job(batches(1000, 60.0), {}, {1, 10, 1000.0});
    EXPECT_DOUBLE_EQ(size.walltime_s, 1000.0);
    // 6000 s on 10 ranks. A job of 1000 s needs a tenth for its start and end, and leaves at most
    // 60 s unused when no batch fits any more: 6000 / 840.
    EXPECT_EQ(size.jobs, 8);
}

TEST(JobSize, RefusesAWalltimeTooShortForTheLongestPoint) {
    try {
        (void)size_job(batches(3, 7200.0), {}, {1, 1, 3600.0});
        FAIL();
    } catch (const core::InputError& error) {
        EXPECT_EQ(std::string(error.what()),
                  "--walltime: 01:00:00 is too short: the longest points or stems take about "
                  "02:00:00 (on the reference machine)");
    }
}

JobText text_of(const std::string& name) {
    return {JobWork::Study,
            name,
            {"/data/" + name + ".toml"},
            "/data/" + name,
            "/opt/culm",
            "",
            "",
            2,
            5};
}

TEST(JobScript, RequestsTheNeedsOfTheStudyFromSlurm) {
    JobText text = text_of("doe");
    text.partition = "short,long";
    text.account = "lab-7@x";
    const std::string script =
        job_script(BatchSystem::Slurm, text, size_job(batches(4, 60.0), {}, {2, 2, 7200.0}));
    for (const char* line :
         {"#!/bin/bash\n", "#SBATCH --nodes=2\n", "#SBATCH --ntasks=4\n",
          "#SBATCH --time=02:00:00\n", "#SBATCH --mem-per-cpu=200M\n",
          "#SBATCH --partition=short,long\n", "#SBATCH --account=lab-7@x\n", "#SBATCH --requeue\n",
          "#SBATCH --signal=B:USR1@120\n", "STUDY=(/data/doe.toml)\n", "OUTPUT=/data/doe\n",
          "run_until_complete() {\n", "scontrol requeue"})
        EXPECT_NE(script.find(line), std::string::npos) << line;
    EXPECT_EQ(script.find("#PBS"), std::string::npos);
}

TEST(JobScript, AddsATimerForPbs) {
    JobText text = text_of("doe");
    text.partition = "workq";
    const std::string script =
        job_script(BatchSystem::Pbs, text, size_job(batches(4, 60.0), {}, {2, 2, 93600.0}));
    for (const char* line :
         {"#PBS -l select=2:ncpus=2:mpiprocs=2:mem=400mb\n", "#PBS -l walltime=26:00:00\n",
          "#PBS -q workq\n", "WALLTIME_S=93600 ", "cd \"$PBS_O_WORKDIR\""})
        EXPECT_NE(script.find(line), std::string::npos) << line;
    EXPECT_EQ(script.find("\n#SBATCH"), std::string::npos);
}

TEST(JobScript, HasNoUserTextInLinesThatTheBatchSystemReads) {
    const std::string nasty = "a\n#SBATCH --uid=0\n$(id)'";
    const std::string script = job_script(BatchSystem::Slurm, text_of(nasty),
                                          size_job(batches(4, 60.0), {}, {2, 2, 7200.0}));
    EXPECT_EQ(script.find("\n#SBATCH --uid"), std::string::npos);
    EXPECT_NE(script.find("#SBATCH --job-name=culm-a__SBATCH_--uid_0___id__\n"), std::string::npos);
    EXPECT_NE(script.find("STUDY=($'/data/a\\012#SBATCH --uid=0\\012$(id)\\'.toml')\n"),
              std::string::npos);
}

TEST(JobScript, DiagnosesAndResumesALaboratory) {
    JobText text = text_of("lab");
    text.work = JobWork::Laboratory;
    text.inputs = {"/data/lab 1", "/data/lab2"};
    const JobSize size = size_job(batches(4, 60.0), {}, {2, 2, 7200.0});
    const std::string script = job_script(BatchSystem::Slurm, text, size);
    for (const char* line :
         {"MEASUREMENTS=('/data/lab 1' /data/lab2)\n", "OPTIONS=()", "# 5 stems to compute",
          "diagnose \"${MEASUREMENTS[@]}\" -o \"$OUTPUT\" --resume"})
        EXPECT_NE(script.find(line), std::string::npos) << line;
}

TEST(JobScript, RefusesNamesThatNoBatchSystemHas) {
    for (const char* name : {"a b", "a\nb", "-x", "$(id)", "a'b", "a\"b", "é"}) {
        JobText text = text_of("doe");
        text.partition = name;
        EXPECT_THROW((void)job_script(BatchSystem::Slurm, text, {}), core::InputError) << name;
        text.partition = "";
        text.account = name;
        EXPECT_THROW((void)job_script(BatchSystem::Pbs, text, {}), core::InputError) << name;
    }
}

} // namespace
} // namespace culm::cluster
