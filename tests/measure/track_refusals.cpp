// SPDX-License-Identifier: BSD-3-Clause
// Unusable recordings are refused with the reason; doubtful ones are reported in a remark.
#include "measure/refused_text.hpp"
#include "measure/tracked_video.hpp"

#include <fstream>

#include <fmt/core.h>
#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>

namespace culm::measure {
namespace {

using tests::refusal;

/// The message with which the video is refused, or "accepted".
std::string refused(const RenderedVideo& video, const std::string& extra = "") {
    return refusal([&] { (void)track_rendered(video, extra); });
}

TEST(Recording, IsRefusedWithoutAStem) {
    RenderedVideo video;
    video.contrast = 0.0;
    video.frames = 30;
    EXPECT_NE(refused(video).find("no stem is visible"), std::string::npos) << refused(video);
    video.noise = 0.0;
    EXPECT_NE(refused(video).find("no stem is visible"), std::string::npos);
}

TEST(Recording, IsRefusedIfTheStemNeverMoves) {
    RenderedVideo video;
    video.release_frame = 1e9;
    video.frames = 40;
    EXPECT_NE(refused(video).find("the stem does not move"), std::string::npos) << refused(video);
}

TEST(Recording, IsRefusedIfTheStemIsPulledButNeverReleased) {
    // The stem is at rest for 15 frames, pulled slowly aside, and held to the end. The pull is a
    // quarter of an undamped swing, reversed in time.
    RenderedVideo video;
    video.frames_per_cycle = 160.0;
    video.decay_per_cycle = 0.0;
    video.release_frame = 0.0;
    const tests::TemporaryFolder folder;
    const std::filesystem::path file = video.write(folder);
    for (int k = 0; k < video.frames; ++k) {
        video.seed = 2 + static_cast<unsigned>(k);
        cv::imwrite((folder / fmt::format("frames/{:05d}.png", k)).string(),
                    video.picture(std::clamp(55 - k, 0, 40)));
    }
    const std::string text = refusal([&] { (void)track_video(read_track_settings(file), {2}); });
    EXPECT_NE(text.find("does not swing through it twice"), std::string::npos) << text;
}

TEST(Recording, IsRefusedIfItBeginsAfterTheRelease) {
    RenderedVideo video;
    video.release_frame = -6.0;
    EXPECT_NE(refused(video).find("begins in the middle of a swing"), std::string::npos)
        << refused(video);
}

TEST(Recording, IsRefusedIfItBeginsBeforeATurningPoint) {
    // With a fast camera the stem hardly moves in three frames at its turning point.
    RenderedVideo video;
    video.frames_per_cycle = 100.0;
    video.decay_per_cycle = 0.3;
    video.release_frame = -70.0;
    video.frames = 260;
    EXPECT_NE(refused(video).find("begins in the middle of a swing"), std::string::npos)
        << refused(video);
}

TEST(Recording, IsRefusedIfItIsTooShort) {
    RenderedVideo video;
    video.frames = 11;
    EXPECT_NE(refused(video).find("11 frames are too few"), std::string::npos);
    video.frames = 22; // three quarters of a swing
    EXPECT_NE(refused(video).find("swing through it twice afterwards"), std::string::npos)
        << refused(video);
    video.frames = 27; // two passages
    EXPECT_NE(refused(video).find("shows too little of the swing"), std::string::npos)
        << refused(video);
}

TEST(Recording, KeepsTheTimesOfTheOtherFramesIfFilesAreMissing) {
    const RenderedVideo video;
    const tests::TemporaryFolder folder;
    const std::filesystem::path file = video.write(folder);
    for (const int lost : {40, 41, 77})
        std::filesystem::remove(folder / fmt::format("frames/{:05d}.png", lost));
    const Track track = track_video(read_track_settings(file), {2});
    EXPECT_EQ(track.rows.numbers.size(), std::size_t(video.frames - 3));
    EXPECT_LT(error_of(track, video).rms, 0.1);
    EXPECT_TRUE(has_remark(track, "3 frames are missing, after 39, 76"));
    const std::vector<double>& times = track.measurement.times;
    const double step = times[40 - track.first_kept] - times[39 - track.first_kept];
    EXPECT_NEAR(step * rendered_fps, 3.0, 1e-5); // times are rounded to the nanosecond
}

TEST(Recording, ReportsAJumpAtSilentlyLostFrames) {
    const RenderedVideo video;
    const tests::TemporaryFolder folder;
    const std::filesystem::path file = video.write(folder);
    // Two frames are lost and the later ones are renumbered, as some cameras do.
    for (int k = 60; k + 2 < video.frames; ++k)
        std::filesystem::rename(folder / fmt::format("frames/{:05d}.png", k + 2),
                                folder / fmt::format("frames/{:05d}.png", k));
    const Track track = track_video(read_track_settings(file), {2});
    EXPECT_TRUE(has_remark(track, "between the frames 55 and 62 the swing jumps"));
    // With the missing frames stated the times are correct.
    std::ofstream(file) << video.settings("missing_frames = [60, 61]\n");
    const Track corrected = track_video(read_track_settings(file), {2});
    EXPECT_FALSE(has_remark(corrected, "jumps"));
    EXPECT_LT(error_of(corrected, video).rms, 0.1);
}

TEST(Recording, ReportsAJumpAtFramesLostInTheFirstSwing) {
    RenderedVideo video;
    EXPECT_TRUE(track_rendered(video).remarks.empty());
    const tests::TemporaryFolder folder;
    const std::filesystem::path file = video.write(folder);
    for (int k = 19; k + 1 < video.frames; ++k)
        std::filesystem::rename(folder / fmt::format("frames/{:05d}.png", k + 1),
                                folder / fmt::format("frames/{:05d}.png", k));
    const Track track = track_video(read_track_settings(file), {2});
    // The zero crossings are at a quarter and three quarters of the cycle of 16 frames.
    EXPECT_TRUE(has_remark(track, "between the frames 14 and 22 the swing jumps"))
        << (track.remarks.empty() ? "" : track.remarks.front());
}

TEST(Recording, ReportsASlowRelease) {
    // The finger follows the stem for four frames; then the stem swings.
    RenderedVideo video;
    const tests::TemporaryFolder folder;
    const std::filesystem::path file = video.write(folder);
    for (int k = 0; k < video.frames; ++k) {
        RenderedVideo slowed = video;
        if (k > 8 && k < 14)
            slowed.pull *= 1.0 - 0.05 * (k - 8);
        if (k < 14)
            cv::imwrite((folder / fmt::format("frames/{:05d}.png", k)).string(),
                        slowed.picture(std::min(k, 10)));
        else
            cv::imwrite((folder / fmt::format("frames/{:05d}.png", k)).string(),
                        video.picture(k - 1));
    }
    EXPECT_TRUE(has_remark(track_video(read_track_settings(file), {2}),
                           "the moment of release is uncertain"));
}

TEST(Recording, OmitsRepeatedFrames) {
    const RenderedVideo video;
    const tests::TemporaryFolder folder;
    const std::filesystem::path file = video.write(folder);
    std::filesystem::copy_file(folder / "frames/00050.png", folder / "frames/00051.png",
                               std::filesystem::copy_options::overwrite_existing);
    const Track track = track_video(read_track_settings(file), {2});
    EXPECT_TRUE(has_remark(track, "are left out: 51"));
    EXPECT_TRUE(std::isnan(track.measurement.deflection(51 - track.first_kept, 0)));
    EXPECT_LT(error_of(track, video).rms, 0.1);
}

TEST(Recording, ReportsAnImplausibleRateOrScale) {
    const RenderedVideo video;
    EXPECT_TRUE(has_remark(track_rendered(video, "fps = 30.0\n"),
                           "GPa for a plain beam, outside the range of plant stems"));
    RenderedVideo fast;
    fast.frames_per_cycle = 5.0;
    EXPECT_TRUE(has_remark(track_rendered(fast),
                           "frames per swing: decay and higher modes are poorly resolved"));
    RenderedVideo small;
    small.length = 120.0; // the settings below claim 136 and 180
    small.stem_width = 5.0;
    const tests::TemporaryFolder folder;
    const std::filesystem::path file = small.write(folder);
    RenderedVideo claimed = small;
    claimed.length = 136.0;
    std::ofstream(file) << claimed.settings();
    EXPECT_TRUE(has_remark(track_video(read_track_settings(file), {2}),
                           "mm of the stem are seen above the clamp"));
    // A third of the stem would be missing, and the clamp position is not given.
    claimed.length = 180.0;
    std::ofstream(file) << claimed.settings();
    EXPECT_NE(refusal([&] {
                  (void)track_video(read_track_settings(file), {2});
              }).find("Say where the clamp is"),
              std::string::npos);
}

TEST(Recording, IsTrackedFromAVideoFileAndReportsItsPlaybackRate) {
    const RenderedVideo video;
    const tests::TemporaryFolder folder;
    const std::filesystem::path avi = folder / "stem.avi";
    cv::VideoWriter writer(avi.string(), cv::CAP_OPENCV_MJPEG,
                           cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), 25.0,
                           {video.width, video.height});
    ASSERT_TRUE(writer.isOpened());
    for (int k = 0; k < video.frames; ++k) {
        std::vector<cv::Mat> planes(3, video.picture(k));
        cv::Mat coloured;
        cv::merge(planes, coloured);
        writer.write(coloured);
    }
    writer.release();
    const std::filesystem::path file = folder / "video.toml";
    std::ofstream(file) << video.settings("frames = \"stem.avi\"\n");
    const Track track = track_video(read_track_settings(file), {2});
    // JPEG compression reduces the precision.
    EXPECT_LT(error_of(track, video).rms, 0.2);
    EXPECT_TRUE(has_remark(track, "the video file states 25 frames/s, video.toml 960"));

    std::string text = video.settings("frames = \"stem.avi\"\n");
    text.erase(text.find("fps"), text.find('\n', text.find("fps")) - text.find("fps"));
    std::ofstream(file) << text;
    EXPECT_NE(refusal([&] {
                  (void)track_video(read_track_settings(file), {1});
              }).find("video.fps is missing: the camera's frames per second (the 25"),
              std::string::npos);
}

TEST(Recording, IsRefusedWithInvalidPicturesOrSettings) {
    RenderedVideo video;
    video.frames = 20;
    const tests::TemporaryFolder folder;
    const std::filesystem::path file = video.write(folder);
    std::ofstream(folder / "frames/00007.png") << "not a picture";
    EXPECT_NE(refusal([&] {
                  (void)track_video(read_track_settings(file), {2});
              }).find("frames/00007.png: is not a readable picture"),
              std::string::npos);
    std::ofstream(file) << video.settings("frames = \"frames/%04d.tif\"\n");
    EXPECT_NE(refusal([&] {
                  (void)track_video(read_track_settings(file), {2});
              }).find("no file has a name of this form"),
              std::string::npos);
    // A step below the distance of two rows would give too many heights.
    std::ofstream(file) << video.settings("height_step_mm = 1e-9\n");
    EXPECT_NE(refusal([&] {
                  (void)read_track_settings(file);
              }).find("height_step_mm = 1e-09: must be at least mm_per_px = "),
              std::string::npos);
    std::ofstream(file) << video.settings("heights_mm = [10, 10]\n");
    EXPECT_NE(refusal([&] { (void)read_track_settings(file); }).find("heights_mm"),
              std::string::npos);
    // A video has no column for a sensor.
    std::ofstream(file) << video.settings()
                        << "[[sensor]]\ncolumn = \"acc\"\nquantity = \"acceleration\"\n"
                           "unit = \"g\"\nheight_mm = 10\n";
    EXPECT_NE(refusal([&] {
                  (void)read_track_settings(file);
              }).find("sensor.column = \"acc\": a video has only rows of the picture"),
              std::string::npos);
    std::ofstream(file) << video.settings("frame_count = 30\n");
    EXPECT_NE(refusal([&] {
                  (void)track_video(read_track_settings(file), {2});
              }).find("ask for the frames 0 to 29"),
              std::string::npos);
    cv::imwrite((folder / "frames/00007.png").string(), video.picture(7));
    std::ofstream(file) << video.settings("width_px = 121\n");
    EXPECT_NE(refusal([&] {
                  (void)track_video(read_track_settings(file), {2});
              }).find("say 121 x 200; the frames have 120 x 200 pixels"),
              std::string::npos);
}

} // namespace
} // namespace culm::measure
