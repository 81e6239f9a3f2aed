// SPDX-License-Identifier: BSD-3-Clause
#include "archive/archive_example.hpp"
#include "archive/file_descriptor.hpp"
#include "archive/hdf5/handle.hpp"
#include "archive/hdf5/read.hpp"
#include "archive/hdf5/write.hpp"
#include "archive/study/file.hpp"
#include "archive/study/writer.hpp"
#include "core/error.hpp"

#include <algorithm>
#include <cstdlib>
#include <map>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <hdf5.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

namespace culm::archive {
namespace {

using example::read_bytes;
using example::write_bytes;

struct StoredChunk {
    std::size_t offset = 0;
    std::size_t size = 0;
};

herr_t add_name(hid_t, const char* name, const H5O_info_t* info, void* data) {
    if (info->type == H5O_TYPE_DATASET)
        static_cast<std::vector<std::string>*>(data)->push_back(std::string("/") + name);
    return 0;
}

/// Positions of the data of every dataset in the file.
std::map<std::string, std::vector<StoredChunk>> locate_chunks(const std::filesystem::path& path) {
    const Hdf5Input input(path);
    std::vector<std::string> names;
    H5Ovisit2(input.root(), H5_INDEX_NAME, H5_ITER_INC, &add_name, &names, H5O_INFO_BASIC);
    std::map<std::string, std::vector<StoredChunk>> chunks;
    for (const std::string& name : names) {
        const DatasetHandle dataset = input.open_dataset(name);
        if (input.shape(name).empty()) {
            chunks[name].push_back(
                {H5Dget_offset(dataset.get()), H5Dget_storage_size(dataset.get())});
            continue;
        }
        const DataspaceHandle space(H5Dget_space(dataset.get()));
        hsize_t count = 0;
        EXPECT_GE(H5Dget_num_chunks(dataset.get(), space.get(), &count), 0);
        for (hsize_t i = 0; i < count; ++i) {
            hsize_t start[3] = {0, 0, 0};
            unsigned mask = 0;
            haddr_t address = 0;
            hsize_t size = 0;
            EXPECT_GE(
                H5Dget_chunk_info(dataset.get(), space.get(), i, start, &mask, &address, &size), 0);
            chunks[name].push_back({address, size});
        }
    }
    return chunks;
}

class StudyDamage : public testing::TestWithParam<int> {
  protected:
    void SetUp() override { write(example::description()); }
    void write(StudyDescription description) {
        description.trajectory_compression = GetParam();
        write_study_file(path_, description, example::design(),
                         [](std::int64_t point) -> std::optional<PointRecord> {
                             if (point == example::missing_point)
                                 return std::nullopt;
                             return example::record_of(point);
                         });
        whole_ = read_bytes(path_);
    }
    void flip(std::size_t byte) {
        std::string bytes = whole_;
        bytes.at(byte) ^= 0x04;
        write_bytes(path_, bytes);
    }

    example::TemporaryFolder folder_;
    std::filesystem::path path_ = folder_ / "study.h5";
    std::string whole_;
};

TEST_P(StudyDamage, IsAbsentAtFirst) {
    const Verification verification = verify(path_);
    EXPECT_TRUE(verification.is_whole());
    // point, 2 factors; status, 2 texts, 2 results; time, step, heights, tip, heights' deflection;
    // config, hosts, identity; 4 trajectories (one point failed, one is missing).
    EXPECT_EQ(verification.datasets, 3 + 5 + 5 + 3 + 4);
}

TEST_P(StudyDamage, IsFoundInTheDatasetWithAFlippedBitAndOnlyThere) {
    for (const auto& [name, chunks] : locate_chunks(path_)) {
        ASSERT_FALSE(chunks.empty()) << name;
        for (const StoredChunk& chunk : chunks) {
            for (const std::size_t place : {std::size_t{0}, chunk.size / 2, chunk.size - 1}) {
                flip(chunk.offset + place);
                const Verification verification = verify(path_);
                ASSERT_EQ(verification.damaged.size(), 1U) << name << " byte " << place;
                ASSERT_EQ(verification.damaged[0].name, name);
                ASSERT_EQ(verification.damaged[0].damaged_chunks, 1);
                ASSERT_EQ(verification.damaged[0].chunks, static_cast<std::int64_t>(chunks.size()));
                ASSERT_THAT(verification.damaged[0].reason, testing::HasSubstr("checksum"));
            }
        }
    }
}

TEST_P(StudyDamage, NeverReachesAReaderAsNumbers) {
    const auto chunks = locate_chunks(path_);
    flip(chunks.at("/histories/tip_deflection").at(3).offset + 5);
    const StudyFile study(path_);
    EXPECT_EQ(study.tip_deflection(1), example::record_of(1).tip_deflection);
    try {
        (void)study.tip_deflection(3);
        FAIL() << "damaged numbers were returned";
    } catch (const core::StorageError& error) {
        EXPECT_THAT(error.what(), testing::AllOf(testing::HasSubstr(path_.string()),
                                                 testing::HasSubstr("/histories/tip_deflection"),
                                                 testing::HasSubstr("checksum")));
    }
}

/// Reads everything that can be read; every error must be one of culm's own.
void read_whatever_is_left(const std::filesystem::path& path) {
    try {
        (void)verify(path);
        const StudyFile study(path);
        for (std::int64_t point = 0; point < study.point_count(); ++point)
            (void)study.record(point);
    } catch (const core::StorageError&) {
        return;
    } catch (const core::InputError&) {
        return;
    }
}

/// In a child process, because HDF5 leaks memory on damaged metadata. Some damage lets HDF5 read
/// without end; a limit of the processor time shortens the patience of the reader.
void expect_an_error_or_the_content(const std::filesystem::path& path) {
    const pid_t child = ::fork();
    if (child == 0) {
        const char* const slowness = std::getenv("CULM_TEST_SLOWNESS");
        const auto seconds = static_cast<rlim_t>(slowness == nullptr ? 1 : std::atoi(slowness));
        const rlimit patience{2 * seconds, RLIM_INFINITY};
        if (::setrlimit(RLIMIT_CPU, &patience) != 0)
            ::_exit(2);
        read_whatever_is_left(path);
        ::_exit(0);
    }
    int status = -1;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    ASSERT_TRUE(WIFEXITED(status)) << "signal " << WTERMSIG(status);
    ASSERT_EQ(WEXITSTATUS(status), 0);
}

TEST_P(StudyDamage, NeverCrashesTheReaderAtAnyPosition) {
    // Two thirds of the example are one text, whose positions are all alike.
    StudyDescription description = example::description();
    const auto config = std::ranges::find(description.provenance, "config",
                                          [](const auto& entry) { return entry.first; });
    ASSERT_NE(config, description.provenance.end());
    config->second.resize(1000);
    write(description);
    ASSERT_LT(whole_.size(), 64'000U);
    read_whatever_is_left(path_); // what the libraries prepare here, no child needs to repeat
    constexpr std::size_t stretch = 97;
    for (std::size_t place = 0; place < whole_.size(); place += stretch) {
        std::string bytes = whole_;
        std::fill_n(bytes.begin() + static_cast<std::ptrdiff_t>(place),
                    std::min(stretch, bytes.size() - place), '\xA5');
        write_bytes(path_, bytes);
        ASSERT_NO_FATAL_FAILURE(expect_an_error_or_the_content(path_)) << "byte " << place;
    }
}

TEST_P(StudyDamage, HoldsNoTimesThatWouldMakeTwoWritingsDiffer) {
    const Hdf5Input input(path_);
    const auto check = [](hid_t, const char* name, const H5O_info_t* info, void*) -> herr_t {
        EXPECT_EQ(info->btime, 0) << name;
        EXPECT_EQ(info->mtime, 0) << name;
        return 0;
    };
    EXPECT_GE(H5Ovisit2(input.root(), H5_INDEX_NAME, H5_ITER_INC, check, nullptr, H5O_INFO_TIME),
              0);
}

INSTANTIATE_TEST_SUITE_P(TrajectoryCompression, StudyDamage, testing::Values(0, 1),
                         [](const auto& parameter) {
                             return parameter.param == 0 ? std::string("none")
                                                         : std::string("deflate");
                         });

TEST(ForeignStudy, IsRefusedWithAnotherFormatOrVersion) {
    const example::TemporaryFolder folder;
    const std::filesystem::path path = folder / "foreign.h5";
    const auto message = [&path](const char* format, const char* version) -> std::string {
        {
            const Hdf5Output output(path);
            if (format != nullptr)
                output.write_attribute(output.root(), "format", std::string(format));
            output.write_attribute(output.root(), "format_version", std::string(version));
        }
        try {
            const StudyFile study(path);
        } catch (const core::InputError& error) {
            return error.what();
        }
        return "accepted";
    };
    EXPECT_THAT(message(nullptr, "1.0"), testing::HasSubstr("is an HDF5 file, but not a culm"));
    EXPECT_THAT(message("other", "1.0"), testing::HasSubstr("\"format\" is not \"culm-study\""));
    EXPECT_THAT(message("culm-study", "2.0"),
                testing::HasSubstr("has format version 2.0; this culm reads version 1.x"));
}

TEST(LockedStudy, ReportsThatAnotherProcessMayHaveItOpen) {
    const example::TemporaryFolder folder;
    const std::filesystem::path path = folder / "study.h5";
    write_bytes(path, "");
    FileDescriptor other(path, FileDescriptor::Access::ReadWriteCreate);
    other.lock_exclusively();
    try {
        const StudyFile study(path);
        FAIL() << "a locked file was opened";
    } catch (const core::StorageError& error) {
        EXPECT_THAT(error.what(), testing::HasSubstr("another process may have the file open"));
    }
}

} // namespace
} // namespace culm::archive
