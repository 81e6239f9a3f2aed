// SPDX-License-Identifier: BSD-3-Clause
#include "measure/refused_text.hpp"
#include "measure/track/frames/frame_source.hpp"
#include "measure/tracked_video.hpp"

#include <fstream>

#include <fmt/core.h>
#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

namespace culm::measure {
namespace {

using tests::refusal;

/// A header as the camera's viewer writes it; `change` replaces one line with another.
std::string header_text(int width, int height, int frames, int bits) {
    return fmt::format("#Camera Information Header\n"
                       "Camera Type : FASTCAM\n"
                       "Record Rate(fps) : 960\n"
                       "Total Frame : {}\n"
                       "Save Step : 1\n"
                       "Image Width : {}\n"
                       "Image Height : {}\n"
                       "Color Type : Mono\n"
                       "Color Bit : {}\n"
                       "File Format : MRaw\n"
                       "EffectiveBit Depth : 12\n"
                       "EffectiveBit Side : Higher\n"
                       "Comment Text : \n\nEND\n",
                       frames, width, height, bits);
}

std::string replaced(std::string text, const std::string& what, const std::string& by) {
    return text.replace(text.find(what), what.size(), by);
}

/// Appends values of `bits` bits each, the highest bit first and without gaps.
void pack(std::vector<std::uint8_t>& bytes, const std::vector<unsigned>& values, int bits) {
    std::vector<bool> stream;
    for (const unsigned value : values)
        for (int bit = bits; bit-- > 0;)
            stream.push_back((value >> static_cast<unsigned>(bit) & 1U) != 0U);
    for (std::size_t i = 0; i < stream.size(); i += 8) {
        unsigned byte = 0;
        for (std::size_t b = 0; b < 8; ++b)
            byte = byte << 1U | (i + b < stream.size() && stream[i + b] ? 1U : 0U);
        bytes.push_back(static_cast<std::uint8_t>(byte));
    }
}

PhotronHeader small_header(int bits) {
    PhotronHeader header;
    header.width = 5; // an odd number: pixels of 10 and 12 bits begin inside bytes
    header.height = 3;
    header.frames = 1;
    header.bits_per_pixel = bits;
    header.effective_bits = bits;
    header.record_rate = 1000.0;
    return header;
}

TEST(PhotronPixels, AreUnpackedHighestBitFirstAtTenAndTwelveBits) {
    for (const int bits : {10, 12}) {
        std::vector<unsigned> values;
        for (unsigned i = 0; i < 15; ++i)
            values.push_back((i * 2654435761U >> 7U) & ((1U << unsigned(bits)) - 1U));
        values.front() = (1U << unsigned(bits)) - 1U;
        std::vector<std::uint8_t> bytes;
        pack(bytes, values, bits);
        const PhotronHeader header = small_header(bits);
        ASSERT_EQ(bytes.size(), header.bytes_per_frame());
        const FrameImage frame = unpack_photron(header, bytes);
        EXPECT_FLOAT_EQ(frame.values.front(), 255.0F);
        for (std::size_t p = 0; p < values.size(); ++p)
            EXPECT_NEAR(frame.values[p], 255.0 * values[p] / ((1U << unsigned(bits)) - 1U), 1e-4);
    }
    // A hand-worked example: 0xABC and 0xDEF are the bytes AB CD EF.
    PhotronHeader pair = small_header(12);
    pair.width = 2;
    pair.height = 1;
    const std::vector<std::uint8_t> bytes{0xAB, 0xCD, 0xEF};
    const FrameImage frame = unpack_photron(pair, bytes);
    EXPECT_NEAR(frame.values[0], 255.0 * 0xABC / 4095.0, 1e-4);
    EXPECT_NEAR(frame.values[1], 255.0 * 0xDEF / 4095.0, 1e-4);
}

TEST(PhotronPixels, HaveTheLowByteFirstAndMayLeaveHighBitsUnusedAtSixteenBits) {
    PhotronHeader header = small_header(16);
    header.width = 2;
    header.height = 1;
    const std::vector<std::uint8_t> bytes{0x34, 0x12, 0xFF, 0x0F};
    EXPECT_NEAR(unpack_photron(header, bytes).values[0], 255.0 * 0x1234 / 65535.0, 1e-4);
    header.effective_bits = 12;
    header.is_high_aligned = false;
    EXPECT_FLOAT_EQ(unpack_photron(header, bytes).values[1], 255.0F);
}

TEST(PhotronHeader, GivesRateAndFormat) {
    const tests::TemporaryFolder folder;
    std::ofstream(folder / "a.cih")
        << replaced(header_text(640, 40, 75, 12), "Save Step : 1", "Save Step : 4");
    const PhotronHeader header = read_photron_header(folder / "a.cih");
    EXPECT_EQ(header.width, 640);
    EXPECT_EQ(header.frames, 75);
    EXPECT_EQ(header.bits_per_pixel, 12);
    EXPECT_DOUBLE_EQ(header.frames_per_second(), 240.0);
    EXPECT_EQ(header.bytes_per_frame(), 640U * 40U * 3U / 2U);
}

/// The XML header of 9 frames; `frames` is what its element frameInfo contains.
std::string xml_header(const std::string& frames) {
    return "binary\x01<cih><fileInfo><date>x</date></fileInfo>"
           "<frameInfo><totalFrame>9</totalFrame>" +
           frames +
           "</frameInfo><imageDataInfo><resolution><width>16</width><height>8</height></resolution>"
           "<colorInfo><type>Mono</type><bit>16</bit></colorInfo>"
           "<effectiveBit><depth>12</depth><side>Lower</side></effectiveBit></imageDataInfo>"
           "<imageFileInfo><fileFormat>MRaw</fileFormat></imageFileInfo>"
           "<recordInfo><recordRate>5000</recordRate></recordInfo></cih>";
}

TEST(PhotronHeader, IsAlsoReadFromXml) {
    const tests::TemporaryFolder folder;
    std::ofstream(folder / "a.cihx") << xml_header("<recordedFrame>9</recordedFrame>");
    const PhotronHeader header = read_photron_header(folder / "a.cihx");
    EXPECT_EQ(header.width, 16);
    EXPECT_EQ(header.height, 8);
    EXPECT_EQ(header.frames, 9);
    EXPECT_EQ(header.effective_bits, 12);
    EXPECT_FALSE(header.is_high_aligned);
    EXPECT_DOUBLE_EQ(header.frames_per_second(), 5000.0);
}

TEST(PhotronHeader, DoesNotTakeTheCamerasRateForThatOfTheFile) {
    const tests::TemporaryFolder folder;
    const auto rate = [&](const std::string& frames) {
        std::ofstream(folder / "a.cihx") << xml_header(frames);
        return read_photron_header(folder / "a.cihx").frames_per_second();
    };
    EXPECT_EQ(rate("<recordedFrame>18</recordedFrame><skipFrame>2</skipFrame>"), 2500.0);
    EXPECT_EQ(rate("<recordedFrame>18</recordedFrame><saveStep>2</saveStep>"), 2500.0);
    EXPECT_EQ(rate("<recordedFrame>18</recordedFrame><skipFrame>1</skipFrame>"), 5000.0);
    EXPECT_NE(refusal([&] {
                  (void)rate("<recordedFrame>18</recordedFrame>");
              }).find("no entry states the step between saved frames"),
              std::string::npos);
}

TEST(PhotronHeader, NamesTheEntryThatIsRefused) {
    const tests::TemporaryFolder folder;
    const auto refused = [&](const std::string& what, const std::string& by) {
        std::ofstream(folder / "a.cih") << replaced(header_text(8, 8, 2, 8), what, by);
        const std::string text = refusal([&] { (void)read_photron_header(folder / "a.cih"); });
        const std::string file = (folder / "a.cih").string() + ": ";
        return text.find(file) == 0 ? text.substr(file.size()) : text;
    };
    EXPECT_EQ(refused("Image Width : 8\n", ""), "has no entry \"Image Width\"");
    EXPECT_EQ(refused("Total Frame : 2", "Total Frame : two"),
              "Total Frame : two: must be a number from 1 to 1073741824");
    EXPECT_EQ(refused("Total Frame : 2", "Total Frame : 1.5"),
              "Total Frame : 1.5: must be a whole number from 1 to 1073741824");
    EXPECT_EQ(refused("Color Type : Mono", "Color Type : Color"),
              "Color Type : Color: must be Mono; export colour recordings as PNG or TIFF");
    EXPECT_EQ(refused("Color Bit : 8", "Color Bit : 14"),
              "Color Bit : 14: must be 8, 10, 12 or 16");
    EXPECT_EQ(refused("File Format : MRaw", "File Format : Avi"),
              "File Format : Avi: must be MRaw (of an image sequence, give the pictures)");
}

TEST(PhotronRecording, IsRefusedIfMissingOrShorterThanItsHeaderStates) {
    const tests::TemporaryFolder folder;
    std::ofstream(folder / "a.cih") << header_text(8, 8, 3, 8);
    EXPECT_NE(refusal([&] {
                  (void)open_photron(folder / "a.cih");
              }).find("no .mraw file with this name is in the same folder"),
              std::string::npos);
    std::ofstream(folder / "a.mraw") << std::string(130, 'x');
    EXPECT_NE(refusal([&] {
                  (void)open_photron(folder / "a.cih");
              }).find("holds 2 whole frames of 8 x 8 pixels with 8 bits; a.cih promises 3"),
              std::string::npos);
}

TEST(PageStack, IsTrackedLikePictures) {
    const RenderedVideo video;
    const tests::TemporaryFolder folder;
    std::vector<cv::Mat> pages;
    for (int k = 0; k < video.frames; ++k)
        pages.push_back(video.picture(k));
    ASSERT_TRUE(cv::imwritemulti((folder / "stack.tif").string(), pages));
    const std::filesystem::path file = folder / "video.toml";
    std::ofstream(file) << video.settings("frames = \"stack.tif\"\n");
    const Track track = track_video(read_track_settings(file), {2});
    EXPECT_EQ(track.rows.numbers.size(), static_cast<std::size_t>(video.frames));
    EXPECT_NEAR(track.window.release.time, video.release_frame, 0.1);

    ASSERT_TRUE(cv::imwrite((folder / "one.tif").string(), pages.front()));
    EXPECT_NE(refusal([&] { (void)open_frames(folder.path(), "one.tif"); }).find("has one page"),
              std::string::npos);
}

TEST(PhotronRecording, IsTrackedLikePictures) {
    const RenderedVideo video;
    const tests::TemporaryFolder folder;
    std::ofstream(folder / "stem.cih") << header_text(video.width, video.height, video.frames, 12);
    std::vector<std::uint8_t> bytes;
    for (int k = 0; k < video.frames; ++k) {
        const cv::Mat picture = video.picture(k);
        std::vector<unsigned> values;
        for (int r = 0; r < picture.rows; ++r)
            for (int c = 0; c < picture.cols; ++c)
                values.push_back(16U * picture.at<uchar>(r, c));
        pack(bytes, values, 12);
    }
    std::ofstream(folder / "stem.mraw", std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()),
               static_cast<std::streamsize>(bytes.size()));
    const std::filesystem::path file = folder / "video.toml";
    std::string text = video.settings("frames = \"stem.cih\"\n");
    std::ofstream(file) << replaced(text, "fps = 960\n", "");
    const Track track = track_video(read_track_settings(file), {2});
    EXPECT_DOUBLE_EQ(track.frames_per_second, 960.0);
    EXPECT_LT(error_of(track, video).rms, 0.1);

    // The header states the camera's rate; a different one in video.toml is a mistake.
    std::ofstream(file) << replaced(text, "fps = 960\n", "fps = 1000\n");
    EXPECT_NE(refusal([&] {
                  (void)track_video(read_track_settings(file), {1});
              }).find("video.fps = 1000: the camera's own header says 960 frames/s"),
              std::string::npos);
}

} // namespace
} // namespace culm::measure
