// SPDX-License-Identifier: BSD-3-Clause
// The tracker on rendered videos, which resemble those of laboratories and include their usual
// defects.
#include "measure/folder/measurement_folder.hpp"
#include "measure/refused_text.hpp"
#include "measure/track/track_report.hpp"
#include "measure/tracked_video.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <random>

#include <fmt/core.h>
#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

namespace culm::measure {
namespace {

using tests::refusal;

// With noise of 3 grey values on a contrast of 120 the matched filter of both edges can locate the
// stem in a row to 0.03 pixels. With a straight line through five rows and the error of the rest
// position, 0.1 is three times the observed error and far below the required 0.25.
constexpr double good = 0.1;

TEST(TrackedVideo, FollowsABrightStem) {
    const RenderedVideo video;
    const Track track = track_rendered(video);
    const TrackError error = error_of(track, video);
    EXPECT_LT(error.rms, good);
    EXPECT_LT(error.largest, 0.5);
    EXPECT_GT(error.seen, 0.99);
    EXPECT_EQ(track.survey.view, (StemView{Up::DecreasingRow, Band::Red, 1}));
    // Half of the stem's foot lies below this row.
    EXPECT_NEAR(track.survey.clamp_row, video.clamp_row, 1.0);
    EXPECT_TRUE(track.remarks.empty()) << track.remarks.front();
}

TEST(TrackedVideo, GivesAFolderThatReadsBack) {
    const tests::TemporaryFolder folder;
    const Track track =
        track_video(read_track_settings(RenderedVideo{}.write(folder, "", Up::DecreasingRow)), {2});
    write_track(folder / "out", track);
    const Measurement read = read_measurement(folder / "out");
    EXPECT_EQ(read.times, track.measurement.times);
    EXPECT_EQ(read.deflections, track.measurement.deflections);
    EXPECT_EQ(read.noise_by_height, track.measurement.noise_by_height);
    EXPECT_GT(std::filesystem::file_size(folder / "out" / "contact_sheet.png"), 100000U);
    EXPECT_TRUE(std::filesystem::exists(folder / "out" / "track.json"));
}

// Errors must not depend on an edge's position between pixels and must match the stated ones.
TEST(TrackedVideo, StatesTheErrorOfEveryReading) {
    for (const double blur : {0.5, 0.9, 1.8})
        for (const double noise : {0.5, 3.0, 5.0}) {
            RenderedVideo video;
            video.stem_width = 7.3;
            video.blur = blur;
            video.noise = noise;
            const TrackError error = error_of(
                track_rendered(video, "up = \"decreasing_row\"\nclamp_row = 190.0"), video);
            EXPECT_LT(error.rms, noise < 1.0 ? 0.02 : 0.1) << blur << " " << noise;
            EXPECT_GT(error.over_uncertainty, 0.6) << blur << " " << noise;
            EXPECT_LT(error.over_uncertainty, 1.5) << blur << " " << noise;
        }
}

// The fast stem is blurred over more than its width, and one of its edges is twice as bright.
TEST(TrackedVideo, ToleratesAnExposure) {
    RenderedVideo video;
    video.stem_width = 7.3;
    video.pull = 40.0;
    video.exposure = 0.6;
    video.lit_side = 0.33;
    const Track track = track_rendered(video, "up = \"decreasing_row\"\nclamp_row = 190.0");
    const TrackError error = error_of(track, video);
    EXPECT_LT(error.rms, 0.03);
    EXPECT_LT(error.over_uncertainty, 1.5);
    ASSERT_TRUE(track.measurement.exposure);
    EXPECT_NEAR(*track.measurement.exposure * rendered_fps, video.exposure, 0.06);
    const RenderedVideo still_shutter;
    EXPECT_FALSE(track_rendered(still_shutter).measurement.exposure);
}

/// Least-squares factor between readings and true deflections, for tip amplitudes of 0.05 to 0.5
/// pixels.
double gain_of_small_swings(const Track& track, const RenderedVideo& video) {
    const Measurement& measurement = track.measurement;
    const double px = rendered_mm_per_px * 1e-3;
    const double lift = video.clamp_row - track.survey.clamp_row;
    double product = 0.0;
    double square = 0.0;
    for (std::size_t k = 0; k < measurement.times.size(); ++k) {
        const int frame = track.rows.numbers[track.first_kept + k];
        const double cycles = (frame - video.release_frame) / video.frames_per_cycle;
        const double amplitude = video.pull * std::exp(-video.decay_per_cycle * cycles);
        for (std::size_t h = 0; h < measurement.heights.size(); ++h) {
            const double read = measurement.deflection(k, h) / px;
            const double truth = video.mean_deflection(measurement.heights[h] / px + lift, frame);
            if (cycles > 0.0 && amplitude < 0.5 && amplitude > 0.05 && !std::isnan(read)) {
                product += read * truth;
                square += truth * truth;
            }
        }
    }
    return product / square;
}

// Most of the slowest frames are at rest, where the stem's edges are on the same pixels.
TEST(TrackedVideo, MeasuresASwingOfLessThanAPixelWithoutBias) {
    RenderedVideo video;
    video.stem_width = 7.3;
    video.decay_per_cycle = 0.35;
    video.frames = 360;
    video.axis_column = 60.25;
    video.blur = 1.4;
    const Track track = track_rendered(video, "up = \"decreasing_row\"\nclamp_row = 190.0");
    EXPECT_NEAR(gain_of_small_swings(track, video), 1.0, 0.015);
}

/// Mean error, away from rest, of readings three to ten pixels from rest.
double error_away_from_rest(const Track& track, const RenderedVideo& video) {
    const Measurement& measurement = track.measurement;
    const double px = rendered_mm_per_px * 1e-3;
    const double lift = video.clamp_row - track.survey.clamp_row;
    double sum = 0.0;
    double count = 0.0;
    for (std::size_t k = 0; k < measurement.times.size(); ++k)
        for (std::size_t h = 0; h < measurement.heights.size(); ++h) {
            const double read = measurement.deflection(k, h) / px;
            const double truth = video.mean_deflection(measurement.heights[h] / px + lift,
                                                       track.rows.numbers[track.first_kept + k]);
            if (std::isnan(read) || std::abs(truth) < 3.0 || std::abs(truth) > 10.0)
                continue;
            sum += truth > 0.0 ? read - truth : truth - read;
            count += 1.0;
        }
    return sum / count;
}

// The background behind the stem's edges is known only from other frames, unlike that around it.
TEST(TrackedVideo, ToleratesAFlickeringLamp) {
    RenderedVideo video;
    video.background = 180.0;
    video.contrast = -80.0;
    video.stem_width = 9.0;
    video.axis_column = 60.25;
    video.decay_per_cycle = 0.15;
    video.frames = 300;
    video.noise = 1.5;
    video.decorate = [](cv::Mat& picture, int frame) {
        std::mt19937_64 random(static_cast<unsigned>(frame));
        picture *= 1.0 + 0.01 * std::normal_distribution<double>()(random);
    };
    const Track track = track_rendered(video, "up = \"decreasing_row\"\nclamp_row = 190.0");
    EXPECT_NEAR(error_away_from_rest(track, video), 0.0, 0.0015);
}

TEST(TrackedVideo, FindsReleaseFrequencyAndNoise) {
    const RenderedVideo video;
    const Track track = track_rendered(video);
    EXPECT_EQ(track.window.last_held, 10U);
    // This stem moves in one mode, without a beam's waves: the error is up to 0.35 frames.
    EXPECT_NEAR(track.window.release.time, video.release_frame, 0.35);
    EXPECT_NEAR(track.window.cycles_per_frame(), 1.0 / video.frames_per_cycle, 1e-3);
    EXPECT_EQ(track.measurement.noise_source.find("11 frames before"), 0U);
    ASSERT_TRUE(track.measurement.noise);
    const double noise_px = *track.measurement.noise * 1e3 / rendered_mm_per_px;
    EXPECT_GT(noise_px, 0.005);
    EXPECT_LT(noise_px, 0.06);
    // Time 0 is the release; the first frame kept is before it.
    EXPECT_LT(track.measurement.times.front(), 0.0);
}

TEST(TrackedVideo, FollowsADarkStem) {
    RenderedVideo video;
    video.background = 190.0;
    video.contrast = -120.0;
    const Track track = track_rendered(video);
    EXPECT_LT(error_of(track, video).rms, good);
    EXPECT_EQ(track.survey.view.sign, -1);
}

TEST(TrackedVideo, FindsTheBandInWhichAColouredStemIsSeen) {
    RenderedVideo video;
    video.is_coloured = true;
    video.colour = {1.0, 0.1, -0.1};
    const Track red = track_rendered(video);
    EXPECT_LT(error_of(red, video).rms, good);
    EXPECT_EQ(red.survey.view.band, Band::Red);
    video.colour = {0.1, 0.2, 1.0};
    EXPECT_EQ(track_rendered(video).survey.view.band, Band::Blue);
}

TEST(TrackedVideo, FollowsAStemInAnyDirection) {
    const RenderedVideo video;
    for (const Up up : {Up::IncreasingRow, Up::DecreasingColumn, Up::IncreasingColumn}) {
        const Track track = track_rendered(video, "", up);
        EXPECT_EQ(track.survey.view.up, up);
        EXPECT_LT(error_of(track, video).rms, good);
    }
}

TEST(TrackedVideo, TakesAGivenClampAndSideInEveryDirection) {
    const RenderedVideo video;
    const double far = video.height - 1 - video.clamp_row;
    const std::vector<std::pair<Up, std::string>> places{
        {Up::DecreasingRow,
         "up = \"decreasing_row\"\nclamp_row = 190.0\naxis_column = 60\npull_side = \"right\"\n"},
        {Up::IncreasingRow, fmt::format("up = \"increasing_row\"\nclamp_row = {}\n", far)},
        {Up::DecreasingColumn, "up = \"decreasing_column\"\nclamp_column = 190.0\naxis_row = 60\n"
                               "pull_side = \"bottom\"\n"},
        {Up::IncreasingColumn,
         fmt::format("up = \"increasing_column\"\nclamp_column = {}\n", far)}};
    for (const auto& [up, extra] : places) {
        const Track track = track_rendered(video, extra, up);
        EXPECT_NEAR(track.survey.clamp_row, video.clamp_row, 1e-9);
        EXPECT_LT(error_of(track, video).rms, good);
    }
    const Track other = track_rendered(video, "pull_side = \"left\"\n");
    EXPECT_TRUE(has_remark(other, "pulled to the other side"));
    EXPECT_LT(other.measurement.deflection(0, other.measurement.heights.size() - 1), 0.0);
}

TEST(TrackedVideo, ToleratesUnevenLight) {
    RenderedVideo video;
    video.decorate = [](cv::Mat& picture, int frame) {
        // Three times as bright at the top right as at the bottom left, and a flickering lamp.
        const double lamp = 1.0 + 0.05 * std::sin(1.7 * frame);
        for (int r = 0; r < picture.rows; ++r)
            for (int c = 0; c < picture.cols; ++c)
                picture.at<double>(r, c) *= lamp * (0.45 + 0.5 * (1.0 - double(r) / picture.rows) +
                                                    0.4 * double(c) / picture.cols);
    };
    const TrackError error = error_of(track_rendered(video), video);
    EXPECT_LT(error.rms, good);
    EXPECT_GT(error.seen, 0.98);
}

TEST(TrackedVideo, ToleratesABrightReflection) {
    RenderedVideo video;
    // A line in the stem's path, as wide as the stem but brighter, and a large blot next to it.
    video.decorate = [](cv::Mat& picture, int) {
        cv::line(picture, {72, 20}, {76, 120}, cv::Scalar(250.0), 5);
        cv::circle(picture, {25, 90}, 14, cv::Scalar(240.0), cv::FILLED);
    };
    const Track track = track_rendered(video);
    const TrackError error = error_of(track, video);
    EXPECT_LT(error.rms, 2.0 * good);
    // The reflection, some five to thirty pixels away, must never be taken for the stem.
    EXPECT_LT(error.largest, 1.5);
    // The stem is hidden while it passes the reflection.
    EXPECT_GT(error.seen, 0.75);
}

TEST(TrackedVideo, FollowsTheStemAboveAReflectionThatCoversIt) {
    RenderedVideo video;
    video.decorate = [](cv::Mat& picture, int) {
        cv::ellipse(picture, cv::Point{60, 110}, cv::Size{11, 9}, 0, 0, 360, cv::Scalar(250.0),
                    cv::FILLED);
    };
    const Track track = track_rendered(video, "heights_mm = [10, 20, 30, 40, 50, 60, 70]\n");
    const TrackError error = error_of(track, video);
    EXPECT_LT(error.rms, good);
    EXPECT_LT(error.largest, 0.6);
    // At 40 mm, row 110, the swing ends behind the reflection.
    EXPECT_TRUE(has_remark(track, "heights at which the stem is not seen are left out: 40 mm"));
    EXPECT_NEAR(track.survey.clamp_row, video.clamp_row, 1.0);
}

TEST(TrackedVideo, FindsTheReleaseBelowAFingerThatHidesTheTip) {
    RenderedVideo video;
    video.decorate = [](cv::Mat& picture, int frame) {
        // The finger holds the tip from the right and returns to the right.
        const int edge = 92 + 5 * std::max(0, frame - 10);
        if (edge < picture.cols)
            cv::rectangle(picture, {edge - 12, 26}, {picture.cols, 60}, cv::Scalar(160.0),
                          cv::FILLED);
    };
    const Track track = track_rendered(video);
    EXPECT_LT(error_of(track, video).rms, good);
    EXPECT_EQ(track.window.last_held, 10U);
    EXPECT_NEAR(track.window.release.time, video.release_frame, 0.5);
}

TEST(TrackedVideo, LeavesOutHeightsBeyondThePicture) {
    RenderedVideo video;
    video.height = 150; // the camera looks at the lower two thirds
    video.clamp_row = 140.0;
    const Track track = track_rendered(video, "heights_mm = [20, 40, 60, 74]\n");
    EXPECT_EQ(track.measurement.heights.size(), 3U);
    EXPECT_TRUE(has_remark(track, "are left out: 74 mm"));
    EXPECT_LT(error_of(track, video).rms, good);
    EXPECT_NE(refusal([&] {
                  (void)track_rendered(video, "heights_mm = [74, 75]\n");
              }).find("is seen at none of these heights"),
              std::string::npos);
}

TEST(TrackedVideo, ToleratesDust) {
    RenderedVideo video;
    video.decorate = [](cv::Mat& picture, int frame) {
        std::mt19937 still(7);
        std::mt19937 flying(1000U + static_cast<unsigned>(frame));
        for (std::mt19937* generator : {&still, &flying})
            for (int i = 0; i < 25; ++i) {
                const cv::Point place(int((*generator)() % 120U), int((*generator)() % 185U));
                cv::circle(picture, place, int((*generator)() % 3U),
                           cv::Scalar((*generator)() % 2U == 0U ? 220.0 : 20.0), cv::FILLED);
            }
    };
    const TrackError error = error_of(track_rendered(video), video);
    EXPECT_LT(error.rms, 2.0 * good);
    EXPECT_LT(error.largest, 1.5);
    EXPECT_GT(error.seen, 0.85);
}

TEST(TrackedVideo, LeavesGapsWhereTheStemIsOutsideThePicture) {
    RenderedVideo video;
    video.axis_column = 92.0; // the tip's edge is outside for a deflection above 25 pixels
    video.pull = 40.0;
    const Track track = track_rendered(video, "heights_mm = [20, 30, 40, 50, 60, 70, 75]\n");
    const TrackError error = error_of(track, video);
    EXPECT_LT(error.rms, good);
    EXPECT_LT(error.largest, 0.6);
    const Measurement& measurement = track.measurement;
    EXPECT_TRUE(std::isnan(measurement.deflection(0, 6)));
    EXPECT_FALSE(std::isnan(measurement.deflection(measurement.times.size() - 1, 6)));
    EXPECT_FALSE(std::isnan(measurement.deflection(0, 2)));
}

TEST(TrackedVideo, IsTheSameForAnyNumberOfThreads) {
    const RenderedVideo video;
    const Track one = track_rendered(video, "", Up::DecreasingRow, 1);
    const Track three = track_rendered(video, "", Up::DecreasingRow, 3);
    EXPECT_EQ(one.measurement.times, three.measurement.times);
    EXPECT_EQ(one.measurement.deflections, three.measurement.deflections);
    EXPECT_EQ(one.remarks, three.remarks);
}

TEST(TrackedVideo, IsTrimmedAtRestUnlessAskedNotTo) {
    RenderedVideo video;
    video.decay_per_cycle = 1.2;
    const Track trimmed = track_rendered(video);
    ASSERT_TRUE(trimmed.window.rest_begin);
    EXPECT_LT(trimmed.last_kept + 10, std::size_t(video.frames));
    EXPECT_TRUE(trimmed.window.is_rest_seen);
    EXPECT_LT(error_of(trimmed, video).rms, good);
    const Track whole = track_rendered(video, "until = \"end\"\nframes_before_release = 3\n");
    EXPECT_EQ(whole.last_kept + 1, std::size_t(video.frames));
    EXPECT_EQ(whole.first_kept, 8U);
    EXPECT_EQ(whole.measurement.noise_source.find("11 frames before"), std::string::npos)
        << "there are far more frames at rest";
}

TEST(TrackedVideo, FindsTheRestPositionOfARecordingThatEndsEarly) {
    RenderedVideo video;
    video.decay_per_cycle = 0.15;
    video.frames = 110;
    const Track track = track_rendered(video);
    EXPECT_FALSE(track.window.is_rest_seen);
    EXPECT_LT(error_of(track, video).rms, good);
    EXPECT_TRUE(has_remark(track, "ends before the stem is at rest"));
}

TEST(TrackedVideo, ObeysAGivenThreshold) {
    const RenderedVideo video;
    EXPECT_LT(error_of(track_rendered(video, "threshold = 30\n"), video).rms, good);
    EXPECT_NE(refusal([&] {
                  (void)track_rendered(video, "threshold = 200\n");
              }).find("no stem exceeds the threshold 200"),
              std::string::npos);
}

} // namespace
} // namespace culm::measure
