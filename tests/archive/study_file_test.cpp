// SPDX-License-Identifier: BSD-3-Clause
#include "archive/archive_example.hpp"
#include "archive/journal/read.hpp"
#include "archive/journal/writer.hpp"
#include "archive/study/file.hpp"
#include "archive/study/writer.hpp"
#include "core/error.hpp"

#include <algorithm>
#include <csignal>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

namespace culm::archive {
namespace {

using example::read_bytes;
using example::record_of;

std::optional<PointRecord> source(std::int64_t point) {
    if (point == example::missing_point)
        return std::nullopt;
    return record_of(point);
}

/// (points, factors), row-major.
std::vector<double> design_of(const StudyFile& file) {
    const std::size_t columns = file.description().factors.size();
    std::vector<double> table(file.statuses().size() * columns);
    for (std::size_t column = 0; column < columns; ++column) {
        const auto values = file.factor(file.description().factors[column].name);
        for (std::size_t row = 0; row < values.size(); ++row)
            table[row * columns + column] = values[row];
    }
    return table;
}

class Study : public testing::Test {
  protected:
    void write(const StudyDescription& description = example::description()) {
        write_study_file(path_, description, example::design(), source);
    }
    /// The text of the error E that the action throws.
    template <class E, class Action>
    static std::string message(Action action) {
        try {
            action();
        } catch (const E& error) {
            return error.what();
        }
        ADD_FAILURE() << "nothing was thrown";
        return {};
    }

    example::TemporaryFolder folder_;
    std::filesystem::path path_ = folder_ / "study.h5";
};

TEST_F(Study, ReturnsItsDescriptionAndDesign) {
    write();
    const StudyFile study(path_);
    EXPECT_EQ(study.description(), example::description());
    EXPECT_EQ(design_of(study), example::design());
    EXPECT_EQ(study.factor("bond_damping").at(3), 30.5);
}

TEST_F(Study, ReturnsEveryRecord) {
    write();
    const StudyFile study(path_);
    for (std::int64_t point = 0; point < example::point_count; ++point)
        EXPECT_EQ(study.record(point), source(point)) << point;
}

TEST_F(Study, ReportsFailedAndMissingPointsAsSuch) {
    write();
    const StudyFile study(path_);
    using enum PointStatus;
    EXPECT_THAT(study.statuses(),
                testing::ElementsAre(Completed, Completed, Failed, Completed, Missing, Completed));
    EXPECT_EQ(study.failure_kind(2), "instability");
    EXPECT_EQ(study.failure_reason(2), record_of(2).failure_reason);
    EXPECT_EQ(study.failure_reason(4), "");
    const std::vector<double> frequency = study.result("frequency");
    EXPECT_EQ(frequency.at(3), 58.6);
    EXPECT_TRUE(std::isnan(frequency.at(2)));
    EXPECT_TRUE(std::isnan(frequency.at(4)));
    EXPECT_THAT(message<core::InputError>([&] { (void)study.tip_deflection(4); }),
                testing::HasSubstr("point 4 is missing; it has no tip histories"));
    EXPECT_THAT(message<core::InputError>([&] { (void)study.positions(2); }),
                testing::HasSubstr("point 2 is failed; it has no positions"));
    EXPECT_THAT(message<core::InputError>([&] { (void)study.status(6); }),
                testing::HasSubstr("there is no point 6; the points are 0 to 5"));
}

TEST_F(Study, HasTheSameBytesForAnyRanksAndOrderOfPoints) {
    const std::vector<std::vector<std::int64_t>> orders{{0, 1, 2, 3, 5}, {5, 3, 1, 2, 0}};
    std::vector<std::string> contents;
    for (std::size_t run = 0; run < orders.size(); ++run) {
        const std::filesystem::path journals = folder_ / ("journal" + std::to_string(run));
        for (std::size_t i = 0; i < orders[run].size(); ++i) {
            // One rank in the first run, three in the second.
            const std::size_t rank = run == 0 ? 0 : i % 3;
            JournalWriter(journals / ("rank-" + std::to_string(rank) + ".culmj"), example::identity)
                .append(example::journalled_record_of(orders[run][i]));
        }
        JournalIndex index(scan_journal_folder(journals, example::identity));
        write_study_file(path_, example::description(), example::design(),
                         [&index](std::int64_t point) { return index.find_record(point); });
        contents.push_back(read_bytes(path_));
    }
    EXPECT_EQ(contents[0], contents[1]);
}

TEST_F(Study, AsksForEachPointOnceInOrder) {
    std::vector<std::int64_t> asked;
    write_study_file(path_, example::description(), example::design(), [&](std::int64_t point) {
        asked.push_back(point);
        return source(point);
    });
    EXPECT_THAT(asked, testing::ElementsAre(0, 1, 2, 3, 4, 5));
}

TEST_F(Study, StoresOnlyTheHistoriesThatWereAskedFor) {
    StudyDescription description = example::description();
    description.stored = {};
    description.times.clear();
    description.heights.clear();
    description.spheres = 0;
    write(description);
    const StudyFile study(path_);
    EXPECT_EQ(study.description(), description);
    EXPECT_EQ(study.record(1)->values, record_of(1).values);
    EXPECT_TRUE(study.record(1)->tip_deflection.empty());
    EXPECT_THAT(message<core::InputError>([&] { (void)study.tip_deflection(1); }),
                testing::HasSubstr("does not store tip histories"));
}

TEST_F(Study, IsWholeWithMoreRowsThanAChunk) {
    constexpr std::int64_t points = 20'001; // three chunks of 8192, the last one partly filled
    StudyDescription description = example::description();
    description.points = points;
    description.stored = {};
    std::vector<double> design;
    for (std::int64_t i = 0; i < 2 * points; ++i)
        design.push_back(static_cast<double>(i));
    write_study_file(path_, description, design, [](std::int64_t point) {
        PointRecord record;
        record.point = point;
        record.completed = point % 1000 != 7;
        record.failure_reason = record.completed ? "" : std::string(3000, 'x');
        if (record.completed)
            record.values = {static_cast<double>(point), -static_cast<double>(point)};
        return std::optional(record);
    });
    const StudyFile study(path_);
    EXPECT_EQ(design_of(study), design);
    const std::vector<double> result = study.result("b1");
    for (std::int64_t point : {0, 8191, 8192, 16384, 20000})
        EXPECT_EQ(result.at(static_cast<std::size_t>(point)), -static_cast<double>(point));
    EXPECT_EQ(study.failure_reason(19'007), std::string(1021, 'x') + "…"); // 1024 bytes
    EXPECT_TRUE(verify(path_).is_whole());
}

TEST_F(Study, ContainsTheSameNumbersWithCompressedTrajectories) {
    StudyDescription description = example::description();
    description.trajectory_compression = 4;
    write(description);
    EXPECT_EQ(StudyFile(path_).positions(3), record_of(3).positions);
    EXPECT_TRUE(verify(path_).is_whole());
}

TEST_F(Study, TakesHardlyMoreRoomThanItsTrajectories) {
    StudyDescription description = example::description();
    description.points = 8;
    description.factors.clear();
    description.stored = {false, false, true};
    description.spheres = 56;
    description.times.resize(2001); // as in the paper's runs; more than one chunk
    const std::size_t coordinates = description.times.size() * 56 * 3;
    write_study_file(path_, description, {}, [coordinates](std::int64_t point) {
        PointRecord record;
        record.point = point;
        record.completed = true;
        record.values = {1.0, 2.0};
        record.positions.assign(coordinates, 0.25);
        return std::optional(record);
    });
    // The rest is config text (0.1 MB) and metadata; 1 % of 21.5 MB is 0.2 MB.
    const double raw = 8.0 * static_cast<double>(coordinates * sizeof(double));
    EXPECT_LT(static_cast<double>(std::filesystem::file_size(path_)), 1.02 * raw);
    EXPECT_EQ(StudyFile(path_).positions(7).size(), coordinates);
}

TEST_F(Study, NamesTheColumnNearestToAnUnknownOne) {
    write();
    const StudyFile study(path_);
    EXPECT_THAT(message<core::InputError>([&] { (void)study.result("frequenzy"); }),
                testing::HasSubstr("no column \"frequenzy\" (did you mean \"frequency\"?)"));
}

TEST_F(Study, RefusesRecordsThatDoNotFit) {
    const auto write_with = [this](auto change) {
        write_study_file(path_, example::description(), example::design(), [&](std::int64_t point) {
            PointRecord record = record_of(point);
            change(record);
            return std::optional(record);
        });
    };
    const auto attempt = [&](auto change) {
        return message<core::StorageError>([&] { write_with(change); });
    };
    EXPECT_THAT(attempt([](PointRecord& r) { r.values.pop_back(); }),
                testing::HasSubstr("record of point 0: 1 results, but the study has 2"));
    EXPECT_THAT(attempt([](PointRecord& r) { r.tip_deflection.clear(); }),
                testing::HasSubstr("0 samples of the tip, but the study has 40"));
    EXPECT_THAT(attempt([](PointRecord& r) { r.point += 1; }),
                testing::HasSubstr("record of point 1 was found in the place of 0"));
    EXPECT_FALSE(std::filesystem::exists(path_));
    EXPECT_FALSE(std::filesystem::exists(path_.string() + ".tmp"));
}

TEST_F(Study, KeepsTheOldFileUntilTheNewOneIsWhole) {
    write();
    const std::string before = read_bytes(path_);
    EXPECT_THROW(write_study_file(path_, example::description(), example::design(),
                                  [](std::int64_t point) -> std::optional<PointRecord> {
                                      if (point == 3)
                                          throw core::StorageError("a journal went away");
                                      return source(point);
                                  }),
                 core::StorageError);
    EXPECT_EQ(read_bytes(path_), before);
    EXPECT_FALSE(std::filesystem::exists(path_.string() + ".tmp"));
}

/// Writes the example under a file size limit in a child process: HDF5 keeps a file whose close
/// failed, and the exit must still be orderly. Returns 0 for a StorageError with the right text.
int write_with_limit(const std::filesystem::path& path, rlim_t limit) {
    const pid_t child = ::fork();
    if (child == 0) {
        std::signal(SIGXFSZ, SIG_IGN);
        const rlimit size{limit, limit};
        ::setrlimit(RLIMIT_FSIZE, &size);
        int result = 1;
        try {
            write_study_file(path, example::description(), example::design(), source);
        } catch (const core::StorageError& error) {
            const std::string text = error.what();
            const bool names_file = text.find(path.string()) != std::string::npos;
            const bool names_cause = text.find("File too large") != std::string::npos;
            result = names_file && names_cause ? 0 : 2;
            if (result != 0)
                (void)!::write(2, text.data(), text.size());
        }
        std::exit(result);
    }
    int status = -1;
    ::waitpid(child, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : 1000 + WTERMSIG(status);
}

TEST_F(Study, ReportsAFullDiskAndKeepsTheOldFile) {
    write();
    const std::string before = read_bytes(path_);
    for (std::size_t limit = 0; limit < before.size(); limit += 1 + before.size() / 40) {
        EXPECT_EQ(write_with_limit(path_, limit), 0) << limit << " of " << before.size();
        EXPECT_EQ(read_bytes(path_), before);
        EXPECT_FALSE(std::filesystem::exists(path_.string() + ".tmp"));
    }
    EXPECT_EQ(write_with_limit(path_, 2 * before.size()), 1) << "there is room, so no error";
}

TEST_F(Study, OpensOnlyWhatItUnderstands) {
    EXPECT_THAT(message<core::StorageError>([&] { StudyFile study(path_); }),
                testing::AllOf(testing::HasSubstr(path_.string()),
                               testing::HasSubstr("No such file or directory")));
    example::write_bytes(path_, "no HDF5 file at all");
    EXPECT_THROW(StudyFile study(path_), core::StorageError);
    write();
    const std::string whole = read_bytes(path_);
    for (std::size_t part = 0; part < 10; ++part) {
        example::write_bytes(path_, whole.substr(0, whole.size() * part / 10));
        EXPECT_THROW(StudyFile study(path_), core::StorageError) << part;
    }
    example::write_bytes(path_, whole.substr(0, whole.size() - 1));
    EXPECT_THAT(message<core::StorageError>([&] { StudyFile study(path_); }),
                testing::HasSubstr("truncated"));
}

} // namespace
} // namespace culm::archive
