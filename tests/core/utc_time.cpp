// SPDX-License-Identifier: BSD-3-Clause
// The present in universal time, whatever the time zone of the process.
#include "core/utc_time.hpp"

#include <cstdlib>
#include <ctime>

#include <gtest/gtest.h>

namespace culm::core {
namespace {

TEST(UtcTime, IsThePresentWhateverTheTimeZone) {
    ::setenv("TZ", "Pacific/Kiritimati", 1); // 14 hours ahead
    ::tzset();
    const std::time_t before = std::time(nullptr);
    const std::string text = utc_now_text();
    const std::time_t after = std::time(nullptr);
    ::unsetenv("TZ");
    ::tzset();
    std::tm parts{};
    const char* end = ::strptime(text.c_str(), "%Y-%m-%dT%H:%M:%SZ", &parts);
    ASSERT_NE(end, nullptr) << text;
    EXPECT_EQ(*end, '\0') << text;
    const std::time_t told = ::timegm(&parts);
    EXPECT_GE(told, before);
    EXPECT_LE(told, after);
}

} // namespace
} // namespace culm::core
