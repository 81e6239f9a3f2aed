// SPDX-License-Identifier: BSD-3-Clause
#include "archive/archive_example.hpp"
#include "archive/journal/read.hpp"
#include "archive/journal/writer.hpp"
#include "core/error.hpp"

#include <csignal>

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

namespace culm::archive {
namespace {

FileDescriptor open_for_reading(const std::filesystem::path& path) {
    return {path, FileDescriptor::Access::Read};
}

using example::identity;
using example::journalled_record_of;

/// No file of this process may grow beyond the limit while the object lives: a small full disk.
class FileSizeLimit {
  public:
    explicit FileSizeLimit(rlim_t bytes) {
        ::getrlimit(RLIMIT_FSIZE, &before_);
        const rlimit limit{bytes, before_.rlim_max};
        ::setrlimit(RLIMIT_FSIZE, &limit);
        handler_ = std::signal(SIGXFSZ, SIG_IGN);
    }
    ~FileSizeLimit() {
        ::setrlimit(RLIMIT_FSIZE, &before_);
        std::signal(SIGXFSZ, handler_);
    }
    FileSizeLimit(const FileSizeLimit&) = delete;
    FileSizeLimit& operator=(const FileSizeLimit&) = delete;

  private:
    rlimit before_{};
    void (*handler_)(int) = SIG_DFL;
};

TEST(JournalOnAFullDisk, RemovesAPartialRecordAndContinuesWhenThereIsRoomAgain) {
    const example::TemporaryFolder folder;
    const std::filesystem::path path = folder / "rank-00000.culmj";
    JournalWriter writer(path, identity);
    writer.append(journalled_record_of(0));
    const auto size = std::filesystem::file_size(path);
    {
        const FileSizeLimit limit(size + 1000); // the next record is longer than that
        try {
            writer.append(journalled_record_of(1));
            FAIL() << "a record was reported as committed on a full disk";
        } catch (const core::StorageError& error) {
            EXPECT_THAT(error.what(), testing::HasSubstr(path.string()));
            EXPECT_THAT(error.what(), testing::HasSubstr("File too large"));
        }
        EXPECT_EQ(std::filesystem::file_size(path), size);
    }
    writer.append(journalled_record_of(3));
    writer.close();
    const JournalScan found = scan_journal(path, identity);
    ASSERT_EQ(found.entries.size(), 2U);
    EXPECT_EQ(read_record(open_for_reading(path), found.entries[1]), journalled_record_of(3));
    EXPECT_EQ(found.damaged_regions, 0);
}

TEST(JournalOnAFullDisk, NamesTheCause) {
    if (!std::filesystem::exists("/dev/full"))
        GTEST_SKIP() << "this system has no /dev/full";
    const example::TemporaryFolder folder;
    const std::filesystem::path path = folder / "full.culmj";
    std::filesystem::create_symlink("/dev/full", path);
    try {
        JournalWriter writer(path, identity);
        FAIL() << "a full device accepted a header";
    } catch (const core::StorageError& error) {
        EXPECT_THAT(error.what(), testing::HasSubstr(path.string()));
        EXPECT_THAT(error.what(), testing::HasSubstr("No space left on device"));
    }
}

TEST(JournalThatCannotBeOpened, NamesFileAndCause) {
    const example::TemporaryFolder folder;
    example::write_bytes(folder / "file", "in the way");
    try {
        JournalWriter writer(folder / "file" / "rank-00000.culmj", identity);
        FAIL() << "a file was taken for a folder";
    } catch (const core::StorageError& error) {
        EXPECT_THAT(error.what(), testing::HasSubstr((folder / "file").string()));
        EXPECT_THAT(error.what(), testing::HasSubstr("Not a directory"));
    }
    EXPECT_THROW((void)scan_journal(folder / "none.culmj", identity), core::StorageError);
}

TEST(JournalInUse, IsRefusedToASecondWriter) {
    const example::TemporaryFolder folder;
    const JournalWriter first(folder / "a.culmj", identity);
    try {
        const JournalWriter second(folder / "a.culmj", identity);
        FAIL() << "two writers have one journal";
    } catch (const core::StorageError& error) {
        EXPECT_THAT(error.what(), testing::HasSubstr("is the study running already?"));
    }
}

TEST(JournalOfAKilledProcess, ContainsEveryPointThatWasReportedCommitted) {
    const example::TemporaryFolder folder;
    const std::filesystem::path path = folder / "rank-00000.culmj";
    int pipe_ends[2] = {-1, -1};
    ASSERT_EQ(::pipe(pipe_ends), 0);
    const pid_t child = ::fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
        JournalWriter writer(path, identity);
        for (std::int64_t point = 0;; ++point) {
            PointRecord record = journalled_record_of(0);
            record.point = point;
            writer.append(record);
            if (::write(pipe_ends[1], &point, sizeof(point)) != sizeof(point))
                ::_exit(1);
        }
    }
    ::close(pipe_ends[1]);
    std::int64_t committed = -1;
    for (int i = 0; i < 200; ++i)
        ASSERT_EQ(::read(pipe_ends[0], &committed, sizeof(committed)),
                  static_cast<ssize_t>(sizeof(committed)));
    ::kill(child, SIGKILL);
    ASSERT_EQ(::waitpid(child, nullptr, 0), child);
    while (::read(pipe_ends[0], &committed, sizeof(committed)) > 0) {
    }
    ::close(pipe_ends[0]);

    const JournalScan found = scan_journal(path, identity);
    EXPECT_EQ(found.damaged_regions, 0);
    ASSERT_GT(static_cast<std::int64_t>(found.entries.size()), committed);
    for (std::int64_t point = 0; point <= committed; ++point)
        EXPECT_EQ(found.entries[static_cast<std::size_t>(point)].point, point);
    EXPECT_EQ(read_record(open_for_reading(path), found.entries.back()).values,
              journalled_record_of(0).values);
}

} // namespace
} // namespace culm::archive
