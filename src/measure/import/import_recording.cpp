// SPDX-License-Identifier: BSD-3-Clause
#include "measure/import/import_recording.hpp"

#include "core/error.hpp"
#include "core/order_statistics.hpp"
#include "measure/import/recorded_series.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

namespace culm::measure {

namespace {

constexpr std::size_t fewest_frames_for_noise = 8;
/// Frames that scatter by less than this share of the scatter after the release are held, even if
/// the errors of a tracker are correlated.
constexpr double swing_share = 0.05;
/// Standard deviations of von Neumann's ratio: by chance one record in a million.
constexpr double surely_correlated = 4.9;
constexpr double gap = std::numeric_limits<double>::quiet_NaN();

[[noreturn]] void refuse(const ImportMapping& mapping, const std::string& text) {
    throw core::InputError(fmt::format("{}: {}", mapping.source.string(), text));
}

/// Mean over the named series at each time. NaN if one of them has a gap, because the mean of the
/// others would jump.
std::vector<double> mean_of(const RecordedSeries& series, const std::vector<std::string>& names) {
    std::vector<double> mean(series.times.size(), 0.0);
    for (const std::string& name : names) {
        const std::vector<double>& values = series.of(name);
        for (std::size_t i = 0; i < mean.size(); ++i)
            mean[i] += values[i] / static_cast<double>(names.size());
    }
    return mean;
}

struct Level {
    double mean = 0.0;
    double deviation = 0.0; ///< standard deviation of one value
    std::size_t count = 0;
};

Level level_of(const std::vector<double>& values, std::size_t begin, std::size_t end) {
    Level level;
    for (std::size_t i = begin; i < end; ++i)
        if (!std::isnan(values[i])) {
            level.mean += values[i];
            ++level.count;
        }
    if (level.count == 0)
        return level;
    level.mean /= static_cast<double>(level.count);
    for (std::size_t i = begin; i < end; ++i)
        if (!std::isnan(values[i]))
            level.deviation += (values[i] - level.mean) * (values[i] - level.mean);
    level.deviation =
        level.count > 1 ? std::sqrt(level.deviation / static_cast<double>(level.count - 1)) : 0.0;
    return level;
}

/// Time between the last frame at rest, `held`, and the next one at which the travel begins, from
/// the travel in the next two frames.
double release_between(const std::vector<double>& times, const std::vector<double>& travel,
                       std::size_t held) {
    if (held + 2 >= times.size())
        return times[held];
    // Under a sudden force the travel grows as t², so its root is linear in time and is zero at the
    // release.
    const double first = std::sqrt(std::abs(travel[held + 1]));
    const double second = std::sqrt(std::abs(travel[held + 2]));
    if (!(second > first))
        return times[held];
    const double rate = (second - first) / (times[held + 2] - times[held + 1]);
    return std::clamp(times[held + 1] - first / rate, times[held], times[held + 1]);
}

/// See import_recording.
double detected_release(const ImportMapping& mapping, const std::vector<double>& times,
                        const std::vector<std::vector<double>>& histories) {
    std::vector<double> mean(times.size(), 0.0);
    for (const std::vector<double>& history : histories)
        for (std::size_t i = 0; i < mean.size(); ++i)
            mean[i] += history[i] / static_cast<double>(histories.size());
    const std::size_t quiet = std::min<std::size_t>(
        mean.size(), std::max<std::size_t>(5, std::min<std::size_t>(20, mean.size() / 50)));
    const Level held = level_of(mean, 0, quiet);
    double largest = 0.0;
    for (double& value : mean) {
        value -= held.mean;
        if (!std::isnan(value))
            largest = std::max(largest, std::abs(value));
    }
    if (held.count < 5 || !(largest > 20.0 * held.deviation))
        refuse(mapping, fmt::format("no release was found: the first {} frames scatter by {:.2g} "
                                    "mm, the motion is at most {:.2g} mm; set release_s",
                                    quiet, 1e3 * held.deviation, 1e3 * largest));
    const auto moves =
        std::ranges::find_if(mean, [&](double value) { return std::abs(value) > 0.2 * largest; });
    auto index = static_cast<std::size_t>(moves - mean.begin());
    // Steps back to the last frame that cannot be distinguished from those at rest.
    while (index > 0 && !(std::abs(mean[index]) <= 4.0 * held.deviation))
        --index;
    if (index == 0)
        refuse(mapping, "the stem moves from the first frame on: no release was found; set "
                        "release_s");
    return release_between(times, mean, index);
}

/// The index of the first time at or after `time`.
std::size_t index_at(const std::vector<double>& times, double time) {
    return static_cast<std::size_t>(std::ranges::lower_bound(times, time) - times.begin());
}

double zero_of(const ImportMapping& mapping, const std::vector<double>& history,
               std::size_t release) {
    if (mapping.zero == ZeroDeflection::AsGiven)
        return 0.0;
    const bool is_before = mapping.zero == ZeroDeflection::BeforeRelease;
    const std::size_t begin = is_before ? 0 : history.size() - history.size() / 10;
    const Level level = level_of(history, begin, is_before ? release : history.size());
    if (level.count == 0)
        refuse(mapping, is_before ? "no frame lies before the release, so there is no zero"
                                  : "the last tenth of the record is empty, so there is no zero");
    return level.mean;
}

/// Does the stem move in the frames [0, release)? White noise has steps between frames with twice
/// its variance; a resolved motion has smaller steps (von Neumann 1941: the ratio of mean square
/// step to variance is 2 ± 2/√n).
bool moves_before(const std::vector<double>& history, std::size_t release) {
    const Level before = level_of(history, 0, release);
    const Level after = level_of(history, release, history.size());
    if (before.count < fewest_frames_for_noise ||
        !(before.deviation > swing_share * after.deviation))
        return false;
    double steps = 0.0;
    double count = 0.0;
    for (std::size_t i = 1; i < release; ++i)
        if (const double step = history[i] - history[i - 1]; !std::isnan(step)) {
            steps += step * step;
            count += 1.0;
        }
    const double ratio = steps / std::max(count, 1.0) / (before.deviation * before.deviation);
    return count > 0.0 && 2.0 - ratio > surely_correlated * 2.0 / std::sqrt(count);
}

/// Returns whether the frames before the release are unusable; if so, adds a remark.
bool is_moving_before(const ImportMapping& mapping,
                      const std::vector<std::vector<double>>& histories, std::size_t release,
                      Measurement& measurement) {
    if (std::ranges::none_of(
            histories, [release](const auto& history) { return moves_before(history, release); }))
        return false;
    measurement.remarks.push_back(fmt::format(
        "the stem moves in the {} frames before the release: the recording begins in the middle of "
        "a swing (then write [release] kind = \"moving\"), or release_s is wrong. No noise is "
        "estimated from these frames{}",
        release,
        mapping.zero == ZeroDeflection::BeforeRelease
            ? ", and their mean is not a valid zero: set zero = \"at_rest\" or \"as_given\""
            : ""));
    return true;
}

void estimate_noise(const std::vector<std::vector<double>>& histories, std::size_t release,
                    Measurement& measurement) {
    if (measurement.noise || !measurement.noise_by_height.empty())
        return;
    std::vector<double> noise;
    std::size_t fewest = release;
    for (const std::vector<double>& history : histories) {
        const Level level = level_of(history, 0, release);
        fewest = std::min(fewest, level.count);
        noise.push_back(level.deviation);
    }
    if (fewest < fewest_frames_for_noise || std::ranges::min(noise) <= 0.0) {
        measurement.remarks.push_back(
            fmt::format("the noise cannot be estimated from {} frames before the release; set "
                        "[measurement] noise_mm",
                        release));
        return;
    }
    measurement.noise_by_height = noise;
    measurement.noise_source = fmt::format("scatter of {} frames before the release", fewest);
}

/// Rounds to a whole nanosecond or nanometre; further digits are rounding errors.
double rounded(double value) {
    return std::round(value * 1e9) / 1e9;
}

void keep_frames(const ImportMapping& mapping, const RecordedSeries& series, double release,
                 const std::vector<std::vector<double>>& histories, Measurement& measurement) {
    for (std::size_t i = 0; i < series.times.size(); ++i) {
        const double time = rounded(series.times[i] - release);
        if ((mapping.before && time < -*mapping.before) || (mapping.after && time > *mapping.after))
            continue;
        measurement.times.push_back(time);
        for (const std::vector<double>& history : histories)
            measurement.deflections.push_back(rounded(history[i]));
    }
    if (measurement.times.empty() || measurement.times.back() <= 0.0)
        refuse(mapping, fmt::format("nothing was recorded after the release at {:g} s", release));
}

} // namespace

Measurement import_recording(const ImportMapping& mapping) {
    const RecordedSeries series =
        mapping.is_c3d() ? read_recorded_markers(mapping) : read_recorded_table(mapping);
    std::vector<MappedHeight> heights = mapping.heights;
    std::ranges::sort(heights, {}, &MappedHeight::height);
    std::vector<std::vector<double>> histories;
    histories.reserve(heights.size());
    for (const MappedHeight& height : heights)
        histories.push_back(mean_of(series, height.names));
    if (!mapping.clamp.empty()) {
        std::vector<double> clamp = mean_of(series, mapping.clamp);
        const auto seen = std::ranges::find_if(clamp, [](double x) { return !std::isnan(x); });
        const double first = seen != clamp.end() ? *seen : gap;
        for (std::vector<double>& history : histories)
            for (std::size_t i = 0; i < history.size(); ++i)
                history[i] -= clamp[i] - first;
    }
    const double release =
        mapping.release ? *mapping.release : detected_release(mapping, series.times, histories);
    const std::size_t first_after = index_at(series.times, release);
    Measurement measurement = mapping.measurement;
    for (std::vector<double>& history : histories) {
        const double zero = zero_of(mapping, history, first_after);
        for (double& value : history)
            value -= zero;
    }
    if (!is_moving_before(mapping, histories, first_after, measurement))
        estimate_noise(histories, first_after, measurement);
    for (const MappedHeight& height : heights)
        measurement.heights.push_back(height.height);
    if (!measurement.frames_per_second)
        measurement.frames_per_second = series.frames_per_second;
    keep_frames(mapping, series, release, histories, measurement);
    return measurement;
}

TimeGaps time_gaps(std::span<const double> times) {
    TimeGaps gaps;
    if (times.size() < 3)
        return gaps;
    std::vector<double> steps;
    steps.reserve(times.size());
    for (std::size_t i = 1; i < times.size(); ++i)
        steps.push_back(times[i] - times[i - 1]);
    const double usual = core::median(steps); // a few gaps do not change it
    for (std::size_t i = 0; i < steps.size(); ++i) {
        if (!(steps[i] > 1.5 * usual))
            continue;
        ++gaps.count;
        if (steps[i] > gaps.longest) {
            gaps.longest = steps[i];
            gaps.begin_of_longest = times[i];
        }
    }
    return gaps;
}

} // namespace culm::measure
