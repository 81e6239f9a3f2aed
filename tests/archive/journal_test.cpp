// SPDX-License-Identifier: BSD-3-Clause
#include "archive/archive_example.hpp"
#include "archive/bytes.hpp"
#include "archive/journal/format.hpp"
#include "archive/journal/read.hpp"
#include "archive/journal/writer.hpp"
#include "core/error.hpp"

#include <algorithm>
#include <stdexcept>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace culm::archive {
namespace {

using example::identity;
using example::journalled_record_of;
using example::read_bytes;
using example::write_bytes;

class Journal : public testing::Test {
  protected:
    /// A journal of points 0 … count − 1.
    void write_points(std::int64_t count) {
        JournalWriter writer(path_, identity);
        for (std::int64_t point = 0; point < count; ++point)
            writer.append(journalled_record_of(point));
        writer.close();
    }
    [[nodiscard]] JournalScan scan() const { return scan_journal(path_, identity); }
    [[nodiscard]] PointRecord read(const JournalEntry& entry) const {
        return read_record(FileDescriptor(path_, FileDescriptor::Access::Read), entry);
    }
    [[nodiscard]] std::vector<std::int64_t> points() const {
        std::vector<std::int64_t> found;
        for (const JournalEntry& entry : scan().entries)
            found.push_back(entry.point);
        return found;
    }

    example::TemporaryFolder folder_;
    std::filesystem::path path_ = folder_ / "journal/rank-00000.culmj";
};

TEST_F(Journal, ReturnsTheAppendedRecords) {
    write_points(4);
    const JournalScan found = scan();
    ASSERT_EQ(found.entries.size(), 4U);
    for (std::int64_t point = 0; point < 4; ++point) {
        const JournalEntry& entry = found.entries[static_cast<std::size_t>(point)];
        EXPECT_EQ(entry.status, journalled_record_of(point).status());
        EXPECT_EQ(read(entry), journalled_record_of(point));
    }
    EXPECT_EQ(found.damaged_regions, 0);
    EXPECT_EQ(found.torn_tail_bytes, 0U);
    EXPECT_EQ(read_journal_identity(path_), identity);
}

TEST_F(Journal, KeepsNotANumberAndSignedZeroBitForBit) {
    PointRecord record = journalled_record_of(0);
    record.values = {std::numeric_limits<double>::quiet_NaN(), -0.0,
                     std::numeric_limits<double>::denorm_min()};
    JournalWriter(path_, identity).append(record);
    const PointRecord found = read(scan().entries.at(0));
    EXPECT_TRUE(std::isnan(found.values.at(0)));
    EXPECT_TRUE(std::signbit(found.values.at(1)));
    EXPECT_EQ(found.values.at(2), std::numeric_limits<double>::denorm_min());
}

TEST_F(Journal, HasTheDocumentedBytes) {
    PointRecord record;
    record.point = 0x0102;
    record.completed = true;
    record.values = {1.0};
    JournalWriter(path_, "id").append(record);
    const std::string bytes = read_bytes(path_);
    using namespace std::string_literals;
    EXPECT_EQ(bytes.substr(0, 22), "CULMJRNL\x04\0\0\0\x02\0\0\0\0\0\0\0id"s);
    EXPECT_EQ(bytes.substr(26, 8), "\xC5REC\r\n\x1A\xF1"s);
    EXPECT_EQ(bytes.substr(34, 24),
              "\x31\0\0\0\0\0\0\0"s + "\x02\x01\0\0\0\0\0\0"s + "\0\0\0\0\0\0\0\0"s);
    // Two empty texts, one value 1.0, two empty arrays, no trajectory.
    EXPECT_EQ(bytes.substr(66), std::string(16, '\0') + "\x01\0\0\0\0\0\0\0"s +
                                    "\0\0\0\0\0\0\xF0\x3F"s + std::string(17, '\0'));
}

TEST_F(Journal, HasTheDocumentedPlaceOfATrajectory) {
    PointRecord record;
    record.point = 7;
    record.completed = true;
    record.trajectory = TrajectoryPlace{2, 1, 0x0102, 0x03040506};
    JournalWriter(path_, "id").append(record);
    using namespace std::string_literals;
    EXPECT_EQ(read_bytes(path_).substr(66 + 5 * 8),
              "\x01\x02\0\0\0\x01\0\0\0"s + "\x02\x01\0\0"s + "\x06\x05\x04\x03"s);
    const JournalScan found = scan_journal(path_, "id");
    EXPECT_EQ(read_record(FileDescriptor(path_, FileDescriptor::Access::Read), found.entries.at(0)),
              record);
}

TEST_F(Journal, KeepsTheOtherRecordsWhenTheLastIsCutAtAnyByte) {
    write_points(3);
    const std::string whole = read_bytes(path_);
    const JournalEntry last = scan().entries.back();
    for (std::size_t size = last.offset; size < whole.size(); ++size) {
        write_bytes(path_, whole.substr(0, size));
        const JournalScan found = scan();
        ASSERT_EQ(found.entries.size(), 2U) << size;
        ASSERT_EQ(found.torn_tail_bytes, size - last.offset);
        ASSERT_EQ(found.damaged_regions, 0);
    }
}

TEST_F(Journal, IsContinuedAfterATornTailHasBeenCutOff) {
    write_points(3);
    const std::string whole = read_bytes(path_);
    const JournalEntry last = scan().entries.back();
    for (const std::size_t lost : {std::size_t{1}, std::size_t{100}, last.length - 1}) {
        write_bytes(path_, whole.substr(0, whole.size() - lost));
        JournalWriter writer(path_, identity);
        writer.append(journalled_record_of(2));
        writer.close();
        EXPECT_EQ(read_bytes(path_), whole) << "the same bytes as without the crash";
    }
}

TEST_F(Journal, CutsOffATailOfZerosLeftByACrashOfTheNode) {
    write_points(2);
    const std::string whole = read_bytes(path_);
    write_bytes(path_, whole + std::string(8192, '\0'));
    JournalWriter(path_, identity).append(journalled_record_of(3));
    EXPECT_THAT(points(), testing::ElementsAre(0, 1, 3));
    EXPECT_EQ(scan().damaged_regions, 0);
}

TEST_F(Journal, FindsTheRecordsBehindABlockOfZeros) {
    write_points(6);
    std::string bytes = read_bytes(path_);
    const std::vector<JournalEntry> entries = scan().entries;
    // From inside record 1 into record 3: all three are lost, none of the others.
    const std::size_t begin = entries[1].offset + 10;
    const std::size_t end = entries[3].offset + 4;
    std::fill(bytes.begin() + static_cast<std::ptrdiff_t>(begin),
              bytes.begin() + static_cast<std::ptrdiff_t>(end), '\0');
    write_bytes(path_, bytes);
    const JournalScan found = scan();
    EXPECT_THAT(points(), testing::ElementsAre(0, 4, 5));
    EXPECT_EQ(found.damaged_regions, 1);
    EXPECT_EQ(found.skipped_bytes, entries[4].offset - entries[1].offset);
    EXPECT_EQ(found.torn_tail_bytes, 0U);
}

TEST_F(Journal, FindsRecordsAgainBehindForeignBytesOfAnyLength) {
    write_points(1);
    const std::string first = read_bytes(path_);
    std::filesystem::remove(path_);
    write_points(2);
    const std::string second = read_bytes(path_).substr(first.size());
    // Lengths around the block size of the search (1 MiB): a magic may straddle two blocks.
    for (const std::size_t gap : {1U, 7U, 8U, 1048568U, 1048570U, 1048575U, 1048576U, 1048577U}) {
        std::string bytes = first;
        bytes.append(gap, 'x').append(second);
        write_bytes(path_, bytes);
        ASSERT_THAT(points(), testing::ElementsAre(0, 1)) << gap;
        ASSERT_EQ(scan().skipped_bytes, gap);
    }
}

TEST_F(Journal, NeverReturnsARecordWithAFlippedBit) {
    write_points(3);
    const std::string whole = read_bytes(path_);
    const JournalEntry middle = scan().entries[1];
    for (std::size_t place = 0; place < middle.length; place += 7) {
        std::string bytes = whole;
        bytes[middle.offset + place] ^= 0x10;
        write_bytes(path_, bytes);
        const JournalScan found = scan();
        ASSERT_THAT(points(), testing::ElementsAre(0, 2)) << "byte " << place;
        ASSERT_EQ(found.damaged_regions, 1);
        ASSERT_EQ(found.corrupt_records, place < 40 ? 0 : 1);
        ASSERT_THROW((void)read(middle), core::StorageError);
    }
}

TEST_F(Journal, IsEmptyAndCanBeRestartedWithAnUnfinishedHeader) {
    write_points(1);
    const std::string whole = read_bytes(path_);
    const std::size_t header = scan().entries.front().offset;
    std::vector<std::string> remains{"", std::string(4096, '\0')};
    for (std::size_t size = 1; size < header; ++size)
        remains.push_back(whole.substr(0, size));
    for (const std::string& bytes : remains) {
        write_bytes(path_, bytes);
        ASSERT_FALSE(scan().header_finished);
        ASSERT_TRUE(scan().entries.empty());
        JournalWriter(path_, identity).append(journalled_record_of(0));
        ASSERT_EQ(read_bytes(path_), whole);
    }
}

TEST_F(Journal, RefusesAnotherStudyAndStaysUnchanged) {
    write_points(2);
    const std::string before = read_bytes(path_);
    const std::string other = "[study]\npoints = 7\nfactor = \"modulus\"\n";
    try {
        (void)scan_journal(path_, other);
        FAIL() << "another study was accepted";
    } catch (const core::InputError& error) {
        EXPECT_THAT(error.what(), testing::HasSubstr(path_.string()));
        EXPECT_THAT(error.what(), testing::HasSubstr("line 2 of the configuration is \"points = "
                                                     "6\" there and \"points = 7\" here"));
    }
    EXPECT_THROW(JournalWriter(path_, other), core::InputError);
    EXPECT_EQ(read_bytes(path_), before);
}

TEST_F(Journal, IsRefusedWithAnotherVersionOrOtherContent) {
    write_points(1);
    const std::string whole = read_bytes(path_);
    const auto message = [this](const std::string& bytes) -> std::string {
        write_bytes(path_, bytes);
        try {
            JournalWriter(path_, identity);
        } catch (const core::StorageError& error) {
            EXPECT_EQ(read_bytes(path_), bytes) << "a file that is not understood was changed";
            return error.what();
        }
        return "accepted";
    };
    std::string newer = whole;
    newer[8] = 5;
    EXPECT_THAT(message(newer), testing::HasSubstr("journal format version 5; this culm reads "
                                                   "version 4"));
    EXPECT_THAT(message("a text of somebody else"), testing::HasSubstr("is not a culm journal"));
    std::string damaged = whole;
    damaged[20] ^= 1;
    EXPECT_THAT(message(damaged), testing::HasSubstr("the header is damaged"));
    std::string longer = whole;
    longer[14] = 1; // the identity now extends beyond the end of the file
    EXPECT_THAT(message(longer), testing::HasSubstr("the header is damaged"));
}

TEST_F(Journal, CountsThePointsInProgressWhenAProcessDied) {
    const std::vector<std::int64_t> begun{0, 1, 2};
    for (int death = 1; death <= 2; ++death) {
        JournalWriter writer(path_, identity); // destroyed without an outcome for 1 and 2
        writer.mark_started(begun);
        if (death == 1)
            writer.append(journalled_record_of(0));
    }
    EXPECT_EQ(scan().unfinished_starts, (std::map<std::int64_t, int>{{0, 1}, {1, 2}, {2, 2}}));
    EXPECT_EQ(points(), (std::vector<std::int64_t>{0}));
    EXPECT_FALSE(scan().is_damaged());
}

TEST_F(Journal, DoesNotCountPointsThatWereGivenBackOrHaveAnOutcome) {
    JournalWriter writer(path_, identity);
    const std::vector<std::int64_t> begun{0, 1, 3};
    writer.mark_started(begun);
    writer.append(journalled_record_of(0));
    const std::vector<std::int64_t> left{1, 3};
    writer.mark_given_back(left);
    EXPECT_TRUE(scan().unfinished_starts.empty());
}

TEST_F(Journal, SkipsPayloadsInAScanOfHeaders) {
    write_points(3);
    const JournalScan whole = scan();
    std::string bytes = read_bytes(path_);
    bytes[whole.entries[1].offset + record_header_size + 9] ^= 1;
    write_bytes(path_, bytes);
    EXPECT_EQ(scan().corrupt_records, 1);
    EXPECT_TRUE(scan().is_damaged());
    const JournalScan quick = scan_journal(path_, identity, ScanDepth::Headers);
    EXPECT_EQ(quick.entries.size(), 3U);
    EXPECT_FALSE(quick.is_damaged());
}

TEST_F(Journal, IndexPrefersCompletedPointsAndThenTheLaterOnes) {
    const auto entry = [](std::int64_t point, PointStatus status, std::uint64_t offset) {
        return JournalEntry{point, status, offset, 1};
    };
    JournalScan first;
    first.entries = {entry(0, PointStatus::Completed, 1), entry(1, PointStatus::Failed, 2),
                     entry(2, PointStatus::Failed, 3)};
    JournalScan second;
    second.entries = {entry(0, PointStatus::Failed, 4), entry(1, PointStatus::Completed, 5),
                      entry(2, PointStatus::Failed, 6)};
    JournalIndex index(std::vector{first, second});
    EXPECT_EQ(index.find(0)->entry.offset, 1U);
    EXPECT_EQ(index.find(1)->entry.offset, 5U);
    EXPECT_EQ(index.find(2)->entry.offset, 6U);
    EXPECT_FALSE(index.contains(3));
    EXPECT_FALSE(index.find_record(3).has_value());
}

TEST_F(Journal, IndexFindsTheRecordsOfMoreJournalsThanItKeepsOpen) {
    constexpr std::int64_t journals = 200;
    for (std::int64_t point = 0; point < journals; ++point) {
        PointRecord record = journalled_record_of(0);
        record.point = point;
        JournalWriter(folder_ / "j" / fmt::format("rank-{:05}.culmj", journals - point), identity)
            .append(record);
    }
    JournalIndex index(scan_journal_folder(folder_ / "j", identity));
    EXPECT_EQ(index.size(), static_cast<std::size_t>(journals));
    for (int round = 0; round < 2; ++round)
        for (std::int64_t point = 0; point < journals; ++point)
            ASSERT_EQ(index.find_record(point).value().point, point);
}

TEST_F(Journal, FolderIsScannedInOrderOfNames) {
    for (const char* name : {"rank-00002.culmj", "rank-00000.culmj", "rank-00001.culmj"})
        JournalWriter(folder_ / "j" / name, identity).append(journalled_record_of(0));
    write_bytes(folder_ / "j" / "notes.txt", "not a journal");
    const std::vector<JournalScan> scans = scan_journal_folder(folder_ / "j", identity);
    ASSERT_EQ(scans.size(), 3U);
    EXPECT_TRUE(std::is_sorted(scans.begin(), scans.end(),
                               [](const auto& a, const auto& b) { return a.file < b.file; }));
    EXPECT_TRUE(scan_journal_folder(folder_ / "nowhere", identity).empty());
}

} // namespace
} // namespace culm::archive
