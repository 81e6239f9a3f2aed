// SPDX-License-Identifier: BSD-3-Clause
#include "measure/c3d_example.hpp"
#include "measure/import/recorded_series.hpp"
#include "measure/measurement_files.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace {

using namespace culm;
using namespace culm::tests;

C3dExample example() {
    C3dExample file;
    // Multiples of the scale, so that integers represent them exactly.
    for (int i = 0; i < 18; ++i)
        file.positions.push_back(0.25F * static_cast<float>(i) - 2.0F);
    file.scale = 0.25F;
    return file;
}

measure::C3dTracks read(const std::string& bytes) {
    const TemporaryFolder folder;
    write_file(folder / "a.c3d", bytes);
    return measure::read_c3d(folder / "a.c3d");
}

std::string complaint(const std::string& bytes) {
    return refusal([&] { static_cast<void>(read(bytes)); });
}

TEST(C3dFile, IsReadForEveryNumberFormat) {
    for (const bool is_real : {true, false})
        for (const int analog : {0, 5}) {
            C3dExample file = example();
            file.is_real = is_real;
            file.analog_words = analog;
            const measure::C3dTracks tracks = read(file.bytes());
            EXPECT_EQ(tracks.frames, 3U);
            EXPECT_EQ(tracks.frames_per_second, 200.0);
            EXPECT_EQ(tracks.unit, "mm");
            EXPECT_EQ(tracks.labels, (std::vector<std::string>{"base", "tip"}));
            ASSERT_EQ(tracks.positions.size(), 18U);
            for (std::size_t i = 0; i < 18; ++i)
                EXPECT_EQ(tracks.positions[i], double(file.positions[i])) << is_real << analog;
        }
}

TEST(C3dFile, HasGapsWhereAMarkerIsNotSeen) {
    C3dExample file = example();
    file.seen = {true, true, true, false, true, true};
    const measure::C3dTracks tracks = read(file.bytes());
    for (std::size_t i = 0; i < 18; ++i)
        EXPECT_EQ(std::isnan(tracks.positions[i]), i >= 9 && i < 12) << i;
}

TEST(C3dFile, RefusesOtherFormatsAndTruncatedFiles) {
    const std::string whole = example().bytes();
    EXPECT_NE(complaint("time,x\n").find("its first two bytes"), std::string::npos);
    EXPECT_NE(complaint(whole.substr(0, 600)).find("it ends after 600 bytes"), std::string::npos);
    EXPECT_NE(complaint(whole.substr(0, 1100)).find("3 frames of 2 markers need 1120 bytes"),
              std::string::npos);
    std::string other = whole;
    other[512 + 3] = 80;
    EXPECT_NE(complaint(other).find("processor type 80"), std::string::npos);
    // A damaged byte must lead to a result or a refusal, never to a crash.
    for (std::size_t at = 0; at < 900; at += 3) {
        std::string damaged = whole;
        damaged[at] = static_cast<char>(~damaged[at]);
        static_cast<void>(complaint(damaged));
    }
}

TEST(C3dFile, NumberOfMarkersIsBoundedByTheFormatAndTheFile) {
    C3dExample file = example();
    // An overflow once turned 2^63 markers into frames of 0 bytes and 2^63 iterations.
    for (const float used : {0x1p63F, 0x1p61F, -1.0F, 2.5F, 65536.0F, NAN, INFINITY}) {
        file.used = used;
        const std::string text = complaint(file.bytes());
        EXPECT_NE(text.find("a.c3d"), std::string::npos) << used;
        EXPECT_NE(text.find("POINT:USED = "), std::string::npos) << used << text;
        EXPECT_NE(text.find("must be a whole number from 1 to 65535"), std::string::npos) << used;
    }
    file.used = 65535.0F;
    EXPECT_NE(complaint(file.bytes()).find("3 frames of 65535 markers need"), std::string::npos);
    file.used = 2.0F;
    EXPECT_EQ(complaint(file.bytes()), "accepted");
}

TEST(C3dFile, ParameterMustEndBeforeTheNextOne) {
    // Every byte of this section begins a parameter of 255 x 255 bytes, each inside the one before.
    std::string bytes = example().bytes().substr(0, 512) + std::string("\x01\x50\x01\x54", 4);
    for (int i = 0; i < 200; ++i)
        bytes += std::string("\x01\x01"
                             "A"
                             "\x06\x00\x01\x02\xFF\xFF",
                             9);
    bytes += std::string(1 << 17, '\0');
    const std::string text = complaint(bytes);
    EXPECT_NE(text.find("parameter A at byte 516 = 255 x 255 elements of 1 bytes: its entry ends "
                        "after 0 bytes"),
              std::string::npos)
        << text;
}

TEST(C3dFile, RateMustBeFinite) {
    C3dExample file = example();
    file.rate = INFINITY;
    EXPECT_NE(complaint(file.bytes()).find("POINT:RATE = inf"), std::string::npos);
}

} // namespace
