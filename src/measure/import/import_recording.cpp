// SPDX-License-Identifier: BSD-3-Clause
#include "measure/import/import_recording.hpp"

#include "core/error.hpp"
#include "core/order_statistics.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>

#include <Eigen/Core>
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

/// The clamp's motion since the first frame in which it was seen; empty if it was not recorded.
std::vector<double> motion_of_clamp(const ImportMapping& mapping, const RecordedSeries& series) {
    if (mapping.clamp.empty())
        return {};
    std::vector<double> clamp = mean_of(series, mapping.clamp);
    const auto seen = std::ranges::find_if(clamp, [](double x) { return !std::isnan(x); });
    const double first = seen != clamp.end() ? *seen : gap;
    for (double& position : clamp)
        position -= first;
    return clamp;
}

/// A sensor's column without the unit in its name, because the measurement has SI units: "acc" of
/// "acc_g", "Displacement" of "Displacement (mm)".
std::string name_without_unit(const Sensor& sensor) {
    for (const std::string_view form : {" ({})", "({})", " [{}]", "[{}]", "_{}"}) {
        const std::string end = fmt::format(fmt::runtime(form), sensor.unit);
        if (sensor.column.ends_with(end) && sensor.column.size() > end.size())
            return sensor.column.substr(0, sensor.column.size() - end.size());
    }
    return sensor.column;
}

/// One height or sensor of the measurement.
struct MeasuredRow {
    Sensor sensor;
    std::vector<double> history;
};

bool has_sensors(const std::vector<MeasuredRow>& rows) {
    return std::ranges::any_of(rows, [](const auto& row) { return !row.sensor.is_camera(); });
}

/// The rows of the measurement, from the lowest height up.
std::vector<MeasuredRow> measured_rows(const ImportMapping& mapping, const RecordedSeries& series) {
    std::vector<MeasuredRow> rows;
    const std::vector<double> clamp = motion_of_clamp(mapping, series);
    for (const MappedHeight& height : mapping.heights) {
        MeasuredRow& row = rows.emplace_back();
        row.sensor.height = height.height;
        row.history = mean_of(series, height.names);
        for (std::size_t i = 0; i < clamp.size(); ++i)
            row.history[i] -= clamp[i];
    }
    for (const Sensor& sensor : mapping.measurement.sensors) {
        rows.push_back({sensor, series.of(sensor.column)});
        rows.back().sensor.column = name_without_unit(sensor);
    }
    std::ranges::stable_sort(rows, {}, [](const MeasuredRow& row) { return row.sensor.height; });
    return rows;
}

/// The onset of the mean of the rows that are positions.
ReleaseOnset detected_release(const ImportMapping& mapping, const std::vector<double>& times,
                              const std::vector<MeasuredRow>& rows) {
    std::vector<double> mean(times.size(), 0.0);
    std::size_t count = 0;
    for (const auto& [sensor, history] : rows) {
        if (sensor.quantity != Quantity::Displacement)
            continue;
        ++count;
        for (std::size_t i = 0; i < mean.size(); ++i)
            mean[i] += history[i];
    }
    if (count == 0)
        refuse(mapping, "a release is detected in displacements only; set release_s");
    const std::optional<ReleaseOnset> onset = release_onset(times, mean);
    if (!onset)
        refuse(mapping, "no release was found: no fast motion sets in after the first five frames; "
                        "set release_s, or [release] kind = \"moving\"");
    return *onset;
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
bool is_moving_before(const ImportMapping& mapping, const std::vector<MeasuredRow>& rows,
                      std::size_t release, Measurement& measurement) {
    if (std::ranges::none_of(
            rows, [release](const auto& row) { return moves_before(row.history, release); }))
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

void estimate_noise(std::vector<MeasuredRow>& rows, std::size_t release, Measurement& measurement) {
    if (measurement.noise || !measurement.noise_by_height.empty() ||
        std::ranges::all_of(rows, [](const auto& row) { return row.sensor.noise.has_value(); }))
        return;
    std::vector<double> noise;
    std::size_t fewest = release;
    for (const MeasuredRow& row : rows) {
        const Level level = level_of(row.history, 0, release);
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
    if (has_sensors(rows)) { // each states its own; camera rows between them have one noise
        for (std::size_t j = 0; j < noise.size(); ++j)
            if (Sensor& sensor = rows[j].sensor; sensor.is_camera())
                measurement.noise = std::max(measurement.noise.value_or(0.0), noise[j]);
            else
                sensor.noise = sensor.noise.value_or(noise[j]);
    } else {
        measurement.noise_by_height = noise;
    }
    measurement.noise_source = fmt::format("scatter of {} frames before the release", fewest);
}

/// Rounds to a billionth: further digits are rounding errors.
double rounded(double value) {
    return std::round(value * 1e9) / 1e9;
}

void keep_frames(const ImportMapping& mapping, const RecordedSeries& series, double release,
                 const std::vector<MeasuredRow>& rows, Measurement& measurement) {
    for (std::size_t i = 0; i < series.times.size(); ++i) {
        const double time = rounded(series.times[i] - release);
        if ((mapping.before && time < -*mapping.before) || (mapping.after && time > *mapping.after))
            continue;
        measurement.times.push_back(time);
        for (const MeasuredRow& row : rows)
            measurement.deflections.push_back(rounded(row.history[i]));
    }
    if (measurement.times.empty() || measurement.times.back() <= 0.0)
        refuse(mapping, fmt::format("nothing was recorded after the release at {:g} s", release));
}

/// Travel and its rate without the frames that have a gap.
struct Travel {
    std::vector<double> times;
    std::vector<double> positions;
    std::vector<double> rates;
};

Travel travel_of(std::span<const double> times, std::span<const double> positions) {
    Travel travel;
    for (std::size_t i = 0; i < times.size(); ++i)
        if (!std::isnan(positions[i])) {
            travel.times.push_back(times[i]);
            travel.positions.push_back(positions[i]);
        }
    travel.rates.assign(travel.times.size(), 0.0);
    for (std::size_t i = 1; i + 1 < travel.times.size(); ++i)
        travel.rates[i] = (travel.positions[i + 1] - travel.positions[i - 1]) /
                          (travel.times[i + 1] - travel.times[i - 1]);
    return travel;
}

/// The first frame from `from` on whose rate reaches this share of the largest.
std::size_t first_at(const Travel& travel, double share, std::size_t from) {
    double largest = 0.0;
    for (const double rate : travel.rates)
        largest = std::max(largest, std::abs(rate));
    while (from < travel.rates.size() && std::abs(travel.rates[from]) < share * largest)
        ++from;
    return from;
}

/// A straight line through the positions of frames [begin, end).
struct Drift {
    Drift(const Travel& travel, std::size_t begin, std::size_t end) {
        const auto count = static_cast<Eigen::Index>(end - begin);
        const Eigen::Map<const Eigen::ArrayXd> times(&travel.times[begin], count);
        const Eigen::Map<const Eigen::ArrayXd> positions(&travel.positions[begin], count);
        time = times.mean();
        position = positions.mean();
        const double square = (times - time).square().sum();
        rate = ((times - time) * positions).sum() / square;
        const double scatter = (positions - position - rate * (times - time)).square().sum();
        variance = scatter / static_cast<double>(count - 2);
        rate_variance = variance / square;
    }
    [[nodiscard]] double travelled(const Travel& travel, std::size_t frame) const {
        return travel.positions[frame] - position - rate * (travel.times[frame] - time);
    }
    /// Standard deviation of travelled() in a frame in which the stem is still held.
    [[nodiscard]] double deviation(const Travel& travel, std::size_t frame) const {
        return std::sqrt(variance + rate_variance * std::pow(travel.times[frame] - time, 2));
    }

    double time, position, rate, variance, rate_variance;
};

} // namespace

Measurement import_recording(const ImportMapping& mapping) {
    const RecordedSeries series = read_recorded_table(mapping);
    std::vector<MeasuredRow> rows = measured_rows(mapping, series);
    Measurement measurement = mapping.measurement;
    const bool is_recorded = measurement.release != ReleaseKind::Moving;
    double release = mapping.release.value_or(0.0);
    if (is_recorded && !mapping.release) {
        const ReleaseOnset onset = detected_release(mapping, series.times, rows);
        release = onset.time;
        measurement.release_uncertainty = onset.uncertainty;
        measurement.remarks.push_back(
            fmt::format("the release was found at {:.6g} s ± {:.2g} ms (standard uncertainty)",
                        onset.time, 1e3 * onset.uncertainty));
    }
    const auto after = std::ranges::lower_bound(series.times, release) - series.times.begin();
    const std::size_t first_after = is_recorded ? static_cast<std::size_t>(after) : 0;
    for (auto& [sensor, history] : rows) {
        if (!sensor.is_camera())
            continue; // the zero of a sensor is a parameter of every fit
        const double zero = zero_of(mapping, history, first_after);
        for (double& value : history)
            value -= zero;
    }
    if (is_recorded && !is_moving_before(mapping, rows, first_after, measurement))
        estimate_noise(rows, first_after, measurement);
    measurement.sensors.clear();
    const bool lists_sensors = has_sensors(rows);
    for (const MeasuredRow& row : rows) {
        measurement.heights.push_back(row.sensor.height);
        if (lists_sensors)
            measurement.sensors.push_back(row.sensor);
    }
    if (!measurement.frames_per_second && mapping.has_markers && series.times.size() > 1)
        measurement.frames_per_second = rounded(static_cast<double>(series.times.size() - 1) /
                                                (series.times.back() - series.times.front()));
    keep_frames(mapping, series, release, rows, measurement);
    for (AddedMass& mass : measurement.stem.added_masses)
        for (const Sensor& sensor : mapping.measurement.sensors)
            if (mass.sensor == sensor.column)
                mass.sensor = name_without_unit(sensor);
    return measurement;
}

std::optional<ReleaseOnset> release_onset(std::span<const double> times,
                                          std::span<const double> positions) {
    constexpr double distinct = 4.0;    // standard deviations
    constexpr double frame_share = 0.5; // nearly the range of times between two frames
    constexpr double opening = 0.01;    // share of the swing by which a hand moves as it opens
    constexpr std::size_t fewest_held = 5;
    const Travel travel = travel_of(times, positions);
    const std::size_t half = first_at(travel, 0.5, 0);
    const std::size_t nearly_all = std::max(first_at(travel, 0.9, half), half + 1);
    if (half < fewest_held || nearly_all + 1 >= travel.times.size())
        return std::nullopt;
    // A rate sin ω(t − t₀) rises from half of its maximum to nine tenths while ω t grows by 0.6.
    const double unit = (travel.times[nearly_all] - travel.times[half]) / 0.6; // 1/ω
    const auto frame_at = [&](double units) {
        return static_cast<std::size_t>(
            std::ranges::lower_bound(travel.times, travel.times[half] - units * unit) -
            travel.times.begin());
    };
    const std::size_t end = std::max(std::min(frame_at(2.0), half), fewest_held);
    const Drift drift(travel, std::min(frame_at(8.0), end - fewest_held), end);
    double largest = 0.0;
    for (std::size_t i = 0; i < travel.times.size(); ++i)
        largest = std::max(largest, std::abs(travel.positions[i] - drift.position));
    std::size_t held = half;
    while (held > 0 && std::abs(drift.travelled(travel, held)) >
                           std::max(distinct * drift.deviation(travel, held), opening * largest))
        --held;
    if (held == 0 || held == half)
        return std::nullopt;
    // Under a sudden force the root of the travel is linear in time.
    const double first = std::sqrt(std::abs(drift.travelled(travel, held + 1)));
    const double second = std::sqrt(std::abs(drift.travelled(travel, held + 2)));
    const double rate = (second - first) / (travel.times[held + 2] - travel.times[held + 1]);
    ReleaseOnset onset{travel.times[held],
                       frame_share * (travel.times[held + 1] - travel.times[held])};
    if (rate > 0.0)
        onset.time = std::clamp(travel.times[held + 1] - first / rate, travel.times[held - 1],
                                travel.times[held + 1]);
    return onset;
}

TimeGaps time_gaps(std::span<const double> times) {
    TimeGaps gaps;
    if (times.size() < 3)
        return gaps;
    // A few gaps do not change the median.
    const double usual = core::median_interval({times.begin(), times.end()});
    for (std::size_t i = 1; i < times.size(); ++i) {
        const double step = times[i] - times[i - 1];
        gaps.count += step > 1.5 * usual ? 1 : 0;
        if (step > std::max(1.5 * usual, gaps.longest)) {
            gaps.longest = step;
            gaps.begin_of_longest = times[i - 1];
        }
    }
    return gaps;
}

} // namespace culm::measure
