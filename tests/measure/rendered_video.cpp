// SPDX-License-Identifier: BSD-3-Clause
#include "measure/rendered_video.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numbers>

#include <fmt/core.h>
#include <opencv2/imgcodecs.hpp>

namespace culm::measure {

double RenderedVideo::deflection(double height_px, double frame) const {
    const double s = height_px / length;
    const double shape = 0.5 * s * s * (3.0 - s);
    const double cycles = (frame - release_frame) / frames_per_cycle;
    const double angle = 2.0 * std::numbers::pi * cycles;
    const double from_rest =
        std::cos(angle) + decay_per_cycle / (2.0 * std::numbers::pi) * std::sin(angle);
    const double swing = cycles <= 0.0 ? 1.0 : std::exp(-decay_per_cycle * cycles) * from_rest;
    return pull * shape * swing;
}

std::vector<double> RenderedVideo::moments(int frame) const {
    const int parts = exposure > 0.0 ? 12 : 1;
    std::vector<double> moments;
    for (int part = 0; part < parts; ++part)
        moments.push_back(frame + exposure * ((part + 0.5) / parts - 0.5));
    return moments;
}

double RenderedVideo::mean_deflection(double height_px, int frame) const {
    double sum = 0.0;
    for (const double moment : moments(frame))
        sum += deflection(height_px, moment);
    return sum / double(moments(frame).size());
}

cv::Mat RenderedVideo::picture(int frame) const {
    const int channels = is_coloured ? 3 : 1;
    cv::Mat exact(height, width, CV_64FC(channels), cv::Scalar::all(background));
    const double scale = std::numbers::sqrt2 * blur;
    for (int r = 0; r < height; ++r) {
        const double h = clamp_row - r;
        std::vector<double> axes;
        for (const double moment : moments(frame))
            axes.push_back(axis_column + deflection(std::max(0.0, h), moment));
        const double tip = 0.5 * (1.0 + std::erf((length - h) / scale));
        const double foot = 0.5 * (1.0 + std::erf(h / scale));
        for (int c = 0; c < width; ++c) {
            double inside = 0.0;
            for (const double x : axes)
                inside += 0.5 / double(axes.size()) *
                          (1.0 + lit_side * std::clamp(2.0 * (c - x) / stem_width, -1.0, 1.0)) *
                          (std::erf((c - x + 0.5 * stem_width) / scale) -
                           std::erf((c - x - 0.5 * stem_width) / scale));
            for (int channel = 0; channel < channels; ++channel)
                exact.ptr<double>(r)[c * channels + channel] +=
                    contrast * tip * foot * inside *
                    (is_coloured ? colour.at(std::size_t(2 - channel)) : 1.0);
        }
    }
    if (decorate)
        decorate(exact, frame);
    std::mt19937 generator(seed * 100003U + static_cast<unsigned>(frame));
    std::normal_distribution<double> normal(0.0, noise > 0.0 ? noise : 1.0);
    cv::Mat digital(height, width, CV_8UC(channels));
    for (int r = 0; r < height; ++r)
        for (int c = 0; c < width * channels; ++c)
            digital.ptr<uchar>(r)[c] = cv::saturate_cast<uchar>(
                exact.ptr<double>(r)[c] + (noise > 0.0 ? normal(generator) : 0.0));
    return digital;
}

std::string RenderedVideo::settings(const std::string& extra) const {
    return fmt::format(
        "[video]\n"
        "{}{}"
        "mm_per_px = {}\n"
        "{}\n"
        "[stem]\n"
        "id = \"R1\"\n"
        "length_mm = {}\n"
        "diameter_mm = {}\n"
        "density_kg_m3 = 125.0\n",
        extra.find("frames = \"") == std::string::npos ? "frames = \"frames/%05d.png\"\n" : "",
        extra.find("fps =") == std::string::npos ? fmt::format("fps = {}\n", rendered_fps) : "",
        rendered_mm_per_px, extra, length * rendered_mm_per_px, stem_width * rendered_mm_per_px);
}

std::filesystem::path RenderedVideo::write(const tests::TemporaryFolder& folder,
                                           const std::string& extra, Up up) const {
    std::filesystem::create_directories(folder / "frames");
    for (int k = 0; k < frames; ++k) {
        cv::Mat turned = picture(k);
        if (up == Up::IncreasingRow)
            cv::flip(turned, turned, 0);
        if (up == Up::DecreasingColumn || up == Up::IncreasingColumn)
            cv::transpose(turned, turned);
        if (up == Up::IncreasingColumn)
            cv::flip(turned, turned, 1);
        cv::imwrite((folder / fmt::format("frames/{:05d}.png", k)).string(), turned);
    }
    std::filesystem::path file = folder / "video.toml";
    std::ofstream(file) << settings(extra);
    return file;
}

} // namespace culm::measure
