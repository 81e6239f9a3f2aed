// SPDX-License-Identifier: BSD-3-Clause
// Trajectories outside of the study file: written, found again, and never returned if damaged.
#include "archive/archive_example.hpp"
#include "archive/study/file.hpp"
#include "archive/study/writer.hpp"
#include "archive/trajectory/reader.hpp"
#include "archive/trajectory/writer.hpp"
#include "core/error.hpp"

#include <cstddef>
#include <numeric>
#include <set>
#include <string_view>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace culm::archive {
namespace {

namespace fs = std::filesystem;

class Trajectories : public testing::Test {
  protected:
    /// Writes the trajectories of the example's points in this order and returns the places.
    std::map<std::int64_t, TrajectoryPlace> write(const std::vector<std::int64_t>& points) {
        TrajectoryWriter writer(files_, 0, study_, 8);
        std::map<std::int64_t, TrajectoryPlace> places;
        for (const std::int64_t point : points)
            places[point] = writer.write(example::record_of(point).positions);
        return places;
    }
    /// Writes a study file whose records name these places.
    void write_study(const std::map<std::int64_t, TrajectoryPlace>& places) {
        write_study_file(path_, study_, example::design(), [&](std::int64_t point) {
            std::optional<PointRecord> record;
            if (point != example::missing_point)
                record = example::record_of(point);
            if (record && record->completed) {
                record->trajectory = places.at(point);
                record->positions.clear();
            }
            return record;
        });
    }
    static std::string complaint(const auto& action) {
        try {
            action();
        } catch (const core::StorageError& error) {
            return error.what();
        }
        return "accepted";
    }
    void flip_bit(const fs::path& file, std::size_t byte) const {
        std::string bytes = example::read_bytes(file);
        bytes.at(byte) ^= 1;
        example::write_bytes(file, bytes);
    }

    example::TemporaryFolder folder_;
    fs::path path_ = folder_ / "study.h5";
    fs::path files_ = folder_ / std::string(trajectory_folder_name);
    StudyDescription study_ = example::description();
};

TEST_F(Trajectories, AreReadFromTheStudyFileThatNamesThem) {
    const auto places = write({5, 0, 3, 1});
    write_study(places);
    const StudyFile file(path_);
    for (const auto& [point, place] : places) {
        EXPECT_EQ(file.positions(point), example::record_of(point).positions);
        EXPECT_EQ(file.trajectory(point), place);
        EXPECT_EQ(file.record(point)->trajectory, place);
    }
    EXPECT_TRUE(verify(path_).is_whole());
}

TEST_F(Trajectories, FillSeveralFilesAndNeverOneOfAnEarlierRun) {
    std::vector<std::int64_t> points(17); // a file of a short study has room for 16
    std::iota(points.begin(), points.end(), 10);
    std::set<std::string> names;
    for (const auto& [point, place] : write(points))
        names.insert(place.file_name());
    EXPECT_THAT(names, testing::ElementsAre("rank-00000-0000.h5", "rank-00000-0001.h5"));
    EXPECT_EQ(write({5}).at(5).file_name(), "rank-00000-0002.h5");
}

TEST_F(Trajectories, KeepSevenDigitsInSinglePrecision) {
    study_.single_precision = true;
    write_study(write({0, 1, 3, 5}));
    const StudyFile file(path_);
    EXPECT_TRUE(file.description().single_precision);
    const std::vector<double> expected = example::record_of(3).positions;
    const std::vector<double> found = file.positions(3);
    ASSERT_EQ(found.size(), expected.size());
    for (std::size_t k = 0; k < found.size(); ++k)
        EXPECT_EQ(found[k], static_cast<double>(static_cast<float>(expected[k])));
}

TEST_F(Trajectories, AreReportedByFileIfThatIsMissing) {
    auto places = write({0, 1});
    places.merge(write({3, 5}));
    write_study(places);
    fs::remove(files_ / "rank-00000-0001.h5");
    const StudyFile file(path_);
    EXPECT_EQ(file.positions(0), example::record_of(0).positions);
    EXPECT_THAT(complaint([&] { (void)file.positions(5); }),
                testing::HasSubstr("trajectories/rank-00000-0001.h5 is missing"));
    const Verification found = verify(path_);
    ASSERT_EQ(found.damaged.size(), 2U);
    EXPECT_EQ(found.damaged.back().name, "/particles/point_000005");
}

TEST_F(Trajectories, AreNoNumbersAfterAFlippedBit) {
    const auto places = write({0, 1, 3, 5});
    write_study(places);
    const fs::path damaged = files_ / places.at(1).file_name();
    const std::vector<double> positions = example::record_of(1).positions;
    const std::string_view stored(reinterpret_cast<const char*>(positions.data()),
                                  positions.size() * sizeof(double));
    flip_bit(damaged, example::read_bytes(damaged).find(stored) + 100);
    EXPECT_THAT(complaint([&] { (void)StudyFile(path_).positions(1); }),
                testing::HasSubstr("does not match its checksum"));
    ASSERT_EQ(verify(path_).damaged.size(), 1U);
    EXPECT_EQ(verify(path_).damaged.front().name, "/particles/point_000001");
}

TEST_F(Trajectories, AreNoZerosWhereNothingWasWritten) {
    TrajectoryPlace place = write({0}).at(0);
    ++place.slot; // reserved and never written
    EXPECT_THAT(complaint([&] { (void)TrajectoryFolder(files_).read(place); }),
                testing::HasSubstr("does not match its checksum"));
}

TEST_F(Trajectories, AreNotReadFromAnotherKindOfFile) {
    const auto places = write({0, 1, 3, 5});
    write_study(places);
    const fs::path file = files_ / places.at(3).file_name();
    example::write_bytes(file, "a text");
    EXPECT_THAT(complaint([&] { (void)StudyFile(path_).positions(3); }),
                testing::HasSubstr(places.at(3).file_name()));
    fs::copy_file(path_, file, fs::copy_options::overwrite_existing);
    EXPECT_THAT(complaint([&] { (void)StudyFile(path_).positions(3); }),
                testing::HasSubstr("is not a file of trajectories"));
}

TEST_F(Trajectories, OfARunningStudyAreWholeFilesAtAnyTime) {
    TrajectoryWriter writer(files_, 0, study_, 100);
    const TrajectoryPlace place = writer.write(example::record_of(0).positions);
    // The writer still has the file open.
    EXPECT_EQ(TrajectoryFolder(files_).read(place), example::record_of(0).positions);
}

} // namespace
} // namespace culm::archive
