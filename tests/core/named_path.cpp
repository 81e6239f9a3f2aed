// SPDX-License-Identifier: BSD-3-Clause
// Names of files inside other files, and the paths that they may lead to.
#include "core/error.hpp"
#include "core/user_files.hpp"

#include <gtest/gtest.h>

namespace culm::core {
namespace {

TEST(NamedPath, LeadsToTheFolderOfTheNamingFileAndBelow) {
    EXPECT_EQ(path_named_in("a/b/study.toml", "my.toml"), "a/b/my.toml");
    EXPECT_EQ(path_named_in("study.toml", "./effects/my.toml"), "./effects/my.toml");
    EXPECT_EQ(path_named_in("/s/study.toml", "x/../my.toml"), "/s/x/../my.toml");
}

TEST(NamedPath, IsRefusedWhenItLeadsElsewhere) {
    for (const char* name : {"/etc/passwd", "../other.toml", "a/../../b", "..", "a/./../..//c", ""})
        EXPECT_THROW((void)path_named_in("s/study.toml", name), InputError) << name;
    EXPECT_NE(named_path_fault(std::string_view("a\0b", 3)), "");
}

} // namespace
} // namespace culm::core
