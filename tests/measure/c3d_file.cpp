// SPDX-License-Identifier: BSD-3-Clause
#include "measure/c3d_file.hpp"

#include "measure/c3d_example.hpp"
#include "measure/measurement_files.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace {

using namespace culm;
using namespace culm::tests;

C3dExample example() {
    C3dExample file;
    // Multiples of the scale, so that integers hold them too.
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

TEST(C3dFile, IsReadWhicheverProcessorAndNumbersItHas) {
    for (const int processor : {84, 85, 86})
        for (const bool is_real : {true, false})
            for (const int analog : {0, 5}) {
                C3dExample file = example();
                file.processor = processor;
                file.is_real = is_real;
                file.analog_words = analog;
                const measure::C3dTracks tracks = read(file.bytes());
                EXPECT_EQ(tracks.frames, 3U);
                EXPECT_EQ(tracks.frames_per_second, 200.0);
                EXPECT_EQ(tracks.unit, "mm");
                EXPECT_EQ(tracks.labels, (std::vector<std::string>{"base", "tip"}));
                ASSERT_EQ(tracks.positions.size(), 18U);
                for (std::size_t i = 0; i < 18; ++i)
                    EXPECT_EQ(tracks.positions[i], double(file.positions[i]))
                        << processor << is_real << analog;
            }
}

TEST(C3dFile, MarkerThatWasNotSeenIsAGap) {
    C3dExample file = example();
    file.seen = {true, true, true, false, true, true};
    const measure::C3dTracks tracks = read(file.bytes());
    for (std::size_t i = 0; i < 18; ++i)
        EXPECT_EQ(std::isnan(tracks.positions[i]), i >= 9 && i < 12) << i;
}

TEST(C3dFile, RefusesWhatIsNoneAndWhatIsCutShort) {
    const auto complaint = [](const std::string& bytes) {
        return refusal([&] { static_cast<void>(read(bytes)); });
    };
    const std::string whole = example().bytes();
    EXPECT_NE(complaint("time,x\n").find("its first two bytes"), std::string::npos);
    EXPECT_NE(complaint(whole.substr(0, 600)).find("it ends after 600 bytes"), std::string::npos);
    EXPECT_NE(complaint(whole.substr(0, 1100)).find("3 frames of 2 markers need 1120 bytes"),
              std::string::npos);
    std::string other = whole;
    other[512 + 3] = 80;
    EXPECT_NE(complaint(other).find("processor type 80"), std::string::npos);
    // Whatever byte is damaged: an answer or a refusal, never a crash.
    for (std::size_t at = 0; at < 900; at += 3) {
        std::string damaged = whole;
        damaged[at] = static_cast<char>(~damaged[at]);
        static_cast<void>(complaint(damaged));
    }
}

} // namespace
