// SPDX-License-Identifier: BSD-3-Clause
// The text of a file.
#pragma once

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include <gtest/gtest.h>

namespace culm::tests {

/// The whole file; a failed expectation if it cannot be opened.
inline std::string content_of(const std::filesystem::path& file) {
    std::ifstream stream(file);
    EXPECT_TRUE(stream.good()) << file;
    std::ostringstream text;
    text << stream.rdbuf();
    return text.str();
}

} // namespace culm::tests
