// SPDX-License-Identifier: BSD-3-Clause
// Files that are read as a whole, and the files that are refused.
#include "core/error.hpp"
#include "core/user_files.hpp"
#include "support/temporary_folder.hpp"

#include <fstream>

#include <gtest/gtest.h>

namespace culm::core {
namespace {

std::string refusal_of(const std::filesystem::path& file, std::size_t largest) {
    try {
        static_cast<void>(file_text(file, largest));
    } catch (const InputError& error) {
        return error.what();
    }
    return "";
}

TEST(FileText, HasEveryByteOfTheFile) {
    const tests::TemporaryFolder folder;
    std::string bytes(200'000, '\0'); // more than one block
    for (std::size_t i = 0; i < bytes.size(); ++i)
        bytes[i] = static_cast<char>(i * 7 % 251);
    std::ofstream(folder / "f", std::ios::binary) << bytes;
    EXPECT_EQ(file_text(folder / "f"), bytes);
    EXPECT_EQ(file_text(folder / "f", bytes.size()), bytes);
}

TEST(FileText, RefusesAFileAboveTheLimit) {
    const tests::TemporaryFolder folder;
    const std::size_t limit = std::size_t{1} << 20U;
    std::ofstream(folder / "f", std::ios::binary) << std::string(limit + 1, 'x');
    EXPECT_EQ(refusal_of(folder / "f", limit),
              (folder / "f").string() + ": cannot be read: it is larger than 1 MiB");
}

TEST(FileText, RefusesAnEndlessDeviceAtTheLimit) {
    EXPECT_EQ(refusal_of("/dev/zero", std::size_t{2} << 20U),
              "/dev/zero: cannot be read: it is larger than 2 MiB");
}

TEST(FileText, RefusesAFolderOrAMissingFileWithTheReason) {
    const tests::TemporaryFolder folder;
    EXPECT_EQ(refusal_of(folder.path(), 1),
              folder.path().string() + ": cannot be read: it is a folder");
    EXPECT_EQ(refusal_of(folder / "none", 1),
              (folder / "none").string() + ": cannot be read: No such file or directory");
}

} // namespace
} // namespace culm::core
