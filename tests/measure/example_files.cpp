// SPDX-License-Identifier: BSD-3-Clause
// The examples in config/measurements are valid.
#include "measure/track/track.hpp"
#include "support/temporary_folder.hpp"

#include <filesystem>
#include <fstream>
#include <sstream>

#include <gtest/gtest.h>

namespace culm::measure {
namespace {

const std::filesystem::path examples =
    std::filesystem::path(CULM_SOURCE_DIR) / "config" / "measurements";

TEST(ExampleVideo, IsReadWithAndWithoutWhatIsDetected) {
    const TrackSettings bare = read_track_settings(examples / "video.toml");
    EXPECT_EQ(bare.description.stem.id, "V1");
    EXPECT_FALSE(bare.clamp);
    std::ifstream in(examples / "video.toml");
    std::ostringstream text;
    for (std::string line; std::getline(in, line);)
        text << (line.starts_with("# ") && line.find(" = ") != std::string::npos ? line.substr(2)
                                                                                 : line)
             << '\n';
    const tests::TemporaryFolder folder;
    std::ofstream(folder / "video.toml") << text.str();
    const TrackSettings full = read_track_settings(folder / "video.toml");
    EXPECT_EQ(full.clamp, 415.0);
    EXPECT_EQ(full.heights.size(), 7U);
}

} // namespace
} // namespace culm::measure
