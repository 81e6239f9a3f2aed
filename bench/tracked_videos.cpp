// SPDX-License-Identifier: BSD-3-Clause
// Results of culm for videos without hidden effects: the beam generator's stem, drawn with
// different light, thickness, noise, contrast, blur, exposure and pull in each, is tracked,
// diagnosed and compared with the truth.
//
//   bench_tracked_videos FIRST COUNT FILE     adds the cases to FILE, prints a line for each
//
// Video n follows from n alone. The picture is the mean over
// each pixel and over the exposure, on its own grid, of a round stem lit from one side in front
// of an uneven ground; it shares no code with the tracker. Y and β are compared with those of a fit
// to the true deflections at the same heights and times.
#include "bench/diagnosis_summary.hpp"
#include "bench/result_file.hpp"
#include "measure/track/track.hpp"
#include "tests/beam_generator/random_case.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include <fmt/core.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <unistd.h>

namespace {

using namespace culm;
using nlohmann::json;

constexpr double frames_per_second = 960.0;
constexpr int part_times = 16; ///< of an exposure

/// How a video looks; lengths in pixels, brightness in grey values.
struct Look {
    double metres_per_pixel;
    double background;
    double contrast; ///< negative: a dark stem
    double noise;
    double blur;
    double exposure;      ///< s
    double light_across;  ///< share by which the light changes over the picture's width
    double light_along;   ///< and over its height
    double flicker;       ///< share, from frame to frame
    double lit_side;      ///< share by which the stem is brighter on its right edge
    double grain;         ///< share, of rows of the stem
    double texture;       ///< of the ground
    bool states_exposure; ///< video.toml

    [[nodiscard]] json numbers() const {
        return {{"mm_per_px", 1e3 * metres_per_pixel},
                {"background", background},
                {"contrast", contrast},
                {"noise", noise},
                {"blur_px", blur},
                {"exposure_ms", 1e3 * exposure},
                {"light_across", light_across},
                {"light_along", light_along},
                {"flicker", flicker},
                {"lit_side", lit_side},
                {"grain", grain},
                {"texture", texture},
                {"states_exposure", states_exposure}};
    }
};

struct Scene {
    beam::RecordingSpec spec;
    Look look;
};

Scene scene_of(std::uint64_t number) {
    constexpr std::uint64_t seed = 0x20f11f;
    Scene scene{beam::random_case(seed, beam::CaseKind::Null, number).spec, {}};
    std::mt19937_64 dice(0x71de0000 + number);
    std::uniform_real_distribution<double> share(0.0, 1.0);
    const auto between = [&](double low, double high) { return low + (high - low) * share(dice); };
    Look& look = scene.look;
    look.metres_per_pixel = between(0.3e-3, 0.5e-3);
    const bool is_dark = share(dice) < 0.5;
    look.background = is_dark ? between(150.0, 200.0) : between(30.0, 80.0);
    look.contrast = (is_dark ? -1.0 : 1.0) * between(60.0, 120.0);
    look.noise = between(1.5, 5.0);
    look.blur = between(0.0, 2.0);
    look.exposure = between(0.0, 1e-3);
    look.light_across = between(-0.15, 0.15);
    look.light_along = between(-0.15, 0.15);
    look.flicker = between(0.0, 0.01);
    look.lit_side = between(-0.3, 0.3);
    look.grain = between(0.0, 0.05);
    look.texture = between(0.0, 1.5);
    look.states_exposure = share(dice) < 0.5;
    scene.spec.frames_per_second = frames_per_second;
    scene.spec.frames_before = 12;
    scene.spec.errors = {};
    return scene;
}

class Video {
  public:
    explicit Video(const Scene& scene)
        : scene_(scene), dice_(scene.spec.seed ^ 0x5151),
          width_(static_cast<int>(2.0 * reach() + 60.0)),
          height_(static_cast<int>(scene.spec.stem.length / scene.look.metres_per_pixel) + 45),
          clamp_row_(height_ - 25.0), axis_column_(0.5 * width_ + 0.37) {
        std::normal_distribution<double> normal;
        for (int r = 0; r < height_; ++r) {
            grain_.push_back(1.0 + scene.look.grain * normal(dice_));
            heights_.push_back(std::max(0.0, clamp_row_ - r) * scene.look.metres_per_pixel);
        }
        for (int k = 0; k < width_ * height_; ++k)
            texture_.push_back(scene.look.texture * normal(dice_));
        scene_.spec.heights = heights_;
    }

    [[nodiscard]] int frames() const {
        return scene_.spec.frames_before +
               static_cast<int>(scene_.spec.duration * frames_per_second);
    }
    /// Time of the middle of a frame, from the release, s.
    [[nodiscard]] double time_of(double frame) const {
        return (frame - scene_.spec.frames_before + release_share) / frames_per_second;
    }

    /// Times over the exposure, from its middle, s.
    [[nodiscard]] std::vector<double> exposure_parts() const {
        std::vector<double> parts;
        for (int part = 0; part < part_times; ++part)
            parts.push_back(scene_.look.exposure * ((part + 0.5) / part_times - 0.5));
        return parts;
    }

    /// Writes frames and video.toml.
    std::filesystem::path write(const std::filesystem::path& folder) {
        std::filesystem::create_directories(folder);
        std::vector<double> times;
        for (int frame = 0; frame < frames(); ++frame)
            for (const double shift : exposure_parts())
                times.push_back(time_of(frame) + shift);
        const std::vector<double> deflections = beam::true_readings(scene_.spec, times);
        for (int frame = 0; frame < frames(); ++frame)
            cv::imwrite((folder / fmt::format("{:05d}.png", frame)).string(),
                        picture(deflections.data() +
                                static_cast<std::ptrdiff_t>(frame) * part_times * height_));
        const std::filesystem::path file = folder / "video.toml";
        const beam::BeamStem& stem = scene_.spec.stem;
        std::ofstream(file) << fmt::format(
            "[video]\nframes = \"%05d.png\"\nfps = {}\nmm_per_px = {}\nup = \"decreasing_row\"\n"
            "clamp_row = {}\naxis_column = {}\n[stem]\nid = \"video\"\nlength_mm = {}\n"
            "diameter_mm = {}\ndensity_kg_m3 = {}\n{}",
            frames_per_second, 1e3 * scene_.look.metres_per_pixel, clamp_row_, axis_column_,
            1e3 * stem.length, 1e3 * stem.diameter, stem.density,
            scene_.look.states_exposure
                ? fmt::format("[camera]\nexposure_ms = {}\n", 1e3 * scene_.look.exposure)
                : std::string());
        return file;
    }

  private:
    static constexpr double release_share = 0.37; ///< frame intervals from release to next frame

    /// Largest deflection of the tip, pixels.
    [[nodiscard]] double reach() const {
        return scene_.spec.tip_deflection / scene_.look.metres_per_pixel;
    }

    /// `deflections`: (part times, rows), m; NaN above the stem.
    [[nodiscard]] cv::Mat picture(const double* deflections) {
        const Look& look = scene_.look;
        const double half = 0.5 * scene_.spec.stem.diameter / look.metres_per_pixel;
        std::normal_distribution<double> normal;
        const double lamp = 1.0 + look.flicker * normal(dice_);
        cv::Mat digital(height_, width_, CV_8UC1);
        std::vector<double> stem(static_cast<std::size_t>(width_));
        for (int r = 0; r < height_; ++r) {
            std::ranges::fill(stem, 0.0);
            for (int part = 0; part < part_times; ++part)
                if (const double deflection = deflections[part * height_ + r];
                    !std::isnan(deflection))
                    add_stem(axis_column_ + deflection / look.metres_per_pixel, half, stem);
            for (int c = 0; c < width_; ++c) {
                const double light = lamp * (1.0 + look.light_across * (c - 0.5 * width_) / width_ +
                                             look.light_along * (r - 0.5 * height_) / height_);
                const double block = r > clamp_row_ ? 0.35 * look.background : 0.0;
                const double inside = look.contrast * stem[static_cast<std::size_t>(c)] *
                                      grain_[static_cast<std::size_t>(r)];
                const double value =
                    light * (look.background - block + (r > clamp_row_ ? 0.0 : inside) +
                             texture_[static_cast<std::size_t>(r * width_ + c)]);
                digital.at<uchar>(r, c) =
                    cv::saturate_cast<uchar>(value + look.noise * normal(dice_));
            }
        }
        return digital;
    }

    /// The stem's brightness over its contrast, where its axis lies at `axis` in one part of the
    /// exposure: blurred by summing over a Gaussian, then the mean of each pixel's parts.
    void add_stem(double axis, double half, std::vector<double>& pixels) const {
        const double blur = std::max(scene_.look.blur, 0.05);
        const double edge = half + 4.0 * blur + 1.0;
        const int finer = blur < 0.5 ? 40 : 8; // parts of a pixel
        const int begin = std::max(0, static_cast<int>(std::floor(axis - edge)));
        const int end = std::min(width_ - 1, static_cast<int>(std::ceil(axis + edge)));
        for (int c = begin; c <= end; ++c) {
            double sum = 0.0;
            for (int k = 0; k < finer; ++k) {
                const double x = c + (k + 0.5) / finer - 0.5 - axis;
                const double left = std::erf((x + half) / (std::numbers::sqrt2 * blur));
                const double right = std::erf((x - half) / (std::numbers::sqrt2 * blur));
                // The light falls off linearly across the stem.
                const double shade = 1.0 + scene_.look.lit_side * std::clamp(x / half, -1.0, 1.0);
                sum += 0.5 * (left - right) * shade / finer;
            }
            pixels[static_cast<std::size_t>(c)] += sum / part_times;
        }
    }

    Scene scene_;
    std::mt19937_64 dice_;
    int width_;
    int height_;
    double clamp_row_;
    double axis_column_;
    std::vector<double> grain_;
    std::vector<double> heights_; ///< of the rows, m
    std::vector<double> texture_;
};

/// The measurement with the deflections that it should have: means over the exposure.
measure::Measurement true_measurement(const measure::Track& track, const Scene& scene,
                                      const Video& video) {
    measure::Measurement exact = track.measurement;
    beam::RecordingSpec spec = scene.spec;
    spec.heights = exact.heights;
    exact.times.clear();
    std::vector<double> times;
    for (const double time : track.measurement.times) {
        exact.times.push_back(
            video.time_of(time * track.frames_per_second + track.window.release.time));
        for (const double shift : video.exposure_parts())
            times.push_back(exact.times.back() + shift);
    }
    const std::vector<double> parts = beam::true_readings(spec, times);
    const std::size_t rows = exact.heights.size();
    for (std::size_t at = 0; at < exact.deflections.size(); ++at) {
        exact.deflections[at] = 0.0;
        for (int part = 0; part < part_times; ++part)
            exact.deflections[at] +=
                parts[(at / rows * part_times + std::size_t(part)) * rows + at % rows] / part_times;
    }
    exact.exposure = scene.look.exposure;
    return exact;
}

void add_reading_errors(const measure::Measurement& tracked, const measure::Measurement& exact,
                        double metres_per_pixel, json& out) {
    double squares = 0.0;
    double stated = 0.0;
    double count = 0.0;
    for (std::size_t at = 0; at < tracked.deflections.size(); ++at) {
        const double error = (tracked.deflections[at] - exact.deflections[at]) / metres_per_pixel;
        if (std::isnan(error))
            continue;
        squares += error * error;
        stated += std::pow(tracked.reading_uncertainties[at] / metres_per_pixel, 2);
        count += 1.0;
    }
    out["reading_error_px"] = std::sqrt(squares / count);
    out["stated_uncertainty_px"] = std::sqrt(stated / count);
    out["missing_share"] = 1.0 - count / static_cast<double>(tracked.deflections.size());
}

json case_of(std::uint64_t number, const std::filesystem::path& folder) {
    const Scene scene = scene_of(number);
    json out{{"number", number}, {"look", scene.look.numbers()}};
    try {
        Video video(scene);
        const std::filesystem::path file = video.write(folder);
        const measure::Track track = measure::track_video(measure::read_track_settings(file));
        const measure::Measurement exact = true_measurement(track, scene, video);
        add_reading_errors(track.measurement, exact, scene.look.metres_per_pixel, out);
        diagnose::DiagnosisOptions options;
        const diagnose::Diagnosis found =
            diagnose::diagnose(diagnose::specimens_of({&track.measurement, 1}), options);
        out.update(bench::diagnosis_summary(found));
        const fit::RecordingFit& fit = found.baseline.parts.front();
        // Both with exact inputs, so the difference is due to the tracker.
        const fit::Fit of_video = fit::fit_model({}, {}, fit::observed({&track.measurement, 1}));
        const fit::Fit of_truth = fit::fit_model({}, {}, fit::observed({&exact, 1}));
        for (const auto& [name, id] : {std::pair("youngs_modulus", physics::bond_youngs_modulus),
                                       std::pair("damping", physics::bond_damping)}) {
            const fit::FittedParameter& beside_errors = *fit.find(id);
            const double truth = of_truth.parts.front().find(id)->value;
            out[name] = {{"trackers_error", of_video.parts.front().find(id)->value / truth - 1.0},
                         {"error", beside_errors.value / truth - 1.0},
                         {"standard_uncertainty", beside_errors.standard_error / truth}};
        }
    } catch (const std::exception& error) {
        out["answer"] = "failed";
        out["reason"] = error.what();
    }
    return out;
}

void print(const json& each) {
    fmt::print("{}: {}", each["number"].get<int>(), each["answer"].get<std::string>());
    if (each.contains("damping")) {
        fmt::print(" | readings {:.3f} px, stated {:.3f}", each["reading_error_px"].get<double>(),
                   each["stated_uncertainty_px"].get<double>());
        for (const char* const name : {"youngs_modulus", "damping"})
            fmt::print(" | {} {:+.3f} %, with errors {:+.3f} ± {:.3f} %", name,
                       1e2 * each[name]["trackers_error"].get<double>(),
                       1e2 * each[name]["error"].get<double>(),
                       1e2 * each[name]["standard_uncertainty"].get<double>());
        fmt::print(" | {} | {}", each["tests"].get<std::string>(),
                   each["noise"].get<std::string>());
    } else {
        fmt::print(" | {}", each.value("reason", ""));
    }
    fmt::print("\n");
    std::fflush(stdout);
}

} // namespace

int main(int argc, char** argv) {
    if (argc != 4) {
        fmt::print(stderr, "usage: bench_tracked_videos FIRST COUNT FILE\n");
        return 2;
    }
    const std::uint64_t first = std::strtoull(argv[1], nullptr, 10);
    const std::uint64_t count = std::strtoull(argv[2], nullptr, 10);
    bench::ResultFile results(argv[3]);
    results.add(
        bench::numbered(first, count),
        [](const json& key) {
            const std::uint64_t number = key["number"];
            const std::filesystem::path folder = std::filesystem::temp_directory_path() /
                                                 fmt::format("culm-video-{}-{}", getpid(), number);
            json one = case_of(number, folder);
            std::filesystem::remove_all(folder);
            return one;
        },
        print);
    return 0;
}
