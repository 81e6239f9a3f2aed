// SPDX-License-Identifier: BSD-3-Clause
#include "measure/ring_down_window.hpp"

#include "core/error.hpp"
#include "measure/order_statistics.hpp"
#include "measure/release_moment.hpp"
#include "measure/swing_model.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/core.h>

namespace culm::measure {
namespace {

constexpr double nothing = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t fewest_still_frames = 5;

/// The highest place seen in 19 of 20 frames; if none is, the one seen most.
std::size_t place_to_watch(const AxisRecord& record) {
    std::size_t most_seen = 0;
    for (std::size_t h = record.places.size(); h-- > 0;) {
        if (record.seen(h) >= 0.95)
            return h;
        if (record.seen(h) > record.seen(most_seen))
            most_seen = h;
    }
    return most_seen;
}

/// Spread from frame to frame in the quietest eight frames, pixels: of the second differences,
/// which a slow motion does not enter.
double quietest_spread(const std::vector<double>& column) {
    constexpr std::size_t window = 8;
    double quietest = std::numeric_limits<double>::infinity();
    std::vector<double> differences;
    for (std::size_t begin = 0; begin + window <= column.size(); ++begin) {
        differences.clear();
        for (std::size_t k = begin + 2; k < begin + window; ++k)
            if (const double d = column[k] - 2.0 * column[k - 1] + column[k - 2]; !std::isnan(d))
                differences.push_back(d);
        if (differences.size() + 2 == window)
            quietest = std::min(quietest, robust_deviation(differences) / std::sqrt(6.0));
    }
    return std::isfinite(quietest) ? quietest : 0.0;
}

void refuse_still_stem(const WatchedHistory& history, const std::string& source) {
    std::vector<double> seen;
    for (const double column : history.column)
        if (!std::isnan(column))
            seen.push_back(column);
    if (seen.size() < 12)
        throw core::InputError(
            fmt::format("{}: the stem is seen in {} of {} frames only; 12 at least are needed",
                        source, seen.size(), history.column.size()));
    const double range = quantile(seen, 0.99) - quantile(seen, 0.01);
    // Readings of a still stem spread over five standard deviations, and the quietest of a few
    // hundred windows shows about a quarter of one.
    const double limit = std::max(1.0, 20.0 * quietest_spread(history.column));
    if (range < limit)
        throw core::InputError(fmt::format("{}: the stem does not move (by {:.2f} pixels, where "
                                           "{:.2f} are needed): it is never released",
                                           source, range, limit));
}

/// Standard deviation of what was seen in the frames begin … end − 1; NaN of fewer than two.
double deviation_of(const std::vector<double>& column, std::size_t begin, std::size_t end) {
    double count = 0.0;
    double mean = 0.0;
    double squares = 0.0; // about the mean so far (Welford)
    for (std::size_t k = begin; k < end; ++k) {
        if (std::isnan(column[k]))
            continue;
        count += 1.0;
        const double step = column[k] - mean;
        mean += step / count;
        squares += step * (column[k] - mean);
    }
    return count > 1.0 ? std::sqrt(squares / (count - 1.0)) : nothing;
}

/// Index of the first frame from which the readings of every period scatter by no more than the
/// limit.
std::optional<std::size_t> find_rest(const WatchedHistory& history, std::size_t after,
                                     double period, double limit) {
    const auto window = std::max<std::size_t>(8, std::size_t(std::ceil(period)));
    const std::size_t count = history.column.size();
    std::optional<std::size_t> begin;
    for (std::size_t end = count; end >= after + window; --end) {
        if (deviation_of(history.column, end - window, end) > limit)
            break;
        begin = end - window;
    }
    return begin;
}

/// Standard deviations of the places over frames begin … end − 1, for places seen there.
std::vector<double> spread(const AxisRecord& record, std::size_t begin, std::size_t end) {
    std::vector<double> result;
    for (std::size_t h = 0; h < record.places.size(); ++h) {
        const std::vector<double> history = record.history(h);
        const auto seen = std::count_if(history.begin() + std::ptrdiff_t(begin),
                                        history.begin() + std::ptrdiff_t(end),
                                        [](double value) { return !std::isnan(value); });
        result.push_back(
            std::size_t(seen) >= fewest_still_frames ? deviation_of(history, begin, end) : nothing);
    }
    return result;
}

bool is_any_known(const std::vector<double>& values) {
    return std::ranges::any_of(values, [](double value) { return !std::isnan(value); });
}

/// Standard deviations from few frames scatter themselves: each variance is averaged with that of
/// all places, which counts as much as 20 frames.
void draw_together(std::vector<double>& deviations, std::size_t frames) {
    double sum = 0.0;
    double count = 0.0;
    for (const double deviation : deviations)
        if (!std::isnan(deviation)) {
            sum += deviation * deviation;
            count += 1.0;
        }
    const auto own = static_cast<double>(frames);
    constexpr double common = 20.0;
    for (double& deviation : deviations)
        deviation =
            std::sqrt((own * deviation * deviation + common * sum / count) / (own + common));
}

/// (places) standard deviation of a reading by what the recurrence leaves from frame `begin` on.
std::vector<double> spread_about(const SwingModel& swing, const AxisRecord& record,
                                 std::size_t begin) {
    const double amplification = std::sqrt(1.0 + swing.a * swing.a + swing.b * swing.b);
    std::vector<double> result;
    for (std::size_t h = 0; h < record.places.size(); ++h) {
        const std::vector<double> surprises =
            swing_surprises(record.numbers, record.history(h), swing, swing.rest[h]);
        std::vector<double> known;
        for (std::size_t k = begin; k < surprises.size(); ++k)
            if (!std::isnan(surprises[k]))
                known.push_back(surprises[k]);
        result.push_back(known.empty() ? nothing : robust_deviation(known) / amplification);
    }
    return result;
}

void find_noise(RingDownWindow& window, const AxisRecord& record,
                const std::vector<double>& spread_about_swing) {
    const std::size_t count = record.numbers.size();
    const std::size_t at_rest = window.rest_begin ? count - *window.rest_begin : 0;
    // After rest if there is clearly more of it: a finger that holds may tremble.
    if (window.held_frames >= fewest_still_frames && at_rest < 4 * window.held_frames) {
        const std::size_t end = window.last_held + 1;
        window.noise = spread(record, end - std::min(end, window.held_frames), end);
        draw_together(window.noise, window.held_frames);
        window.noise_source = fmt::format("{} frames before the release", window.held_frames);
    } else if (at_rest >= fewest_still_frames) {
        window.noise = spread(record, *window.rest_begin, count);
        draw_together(window.noise, at_rest);
        window.noise_source = fmt::format("{} frames after rest", at_rest);
    }
    if (is_any_known(window.noise) || spread_about_swing.empty())
        return;
    window.noise = spread_about_swing;
    window.noise_source = "what a damped swing leaves between neighbouring frames";
}

/// Remarks about frames at which the swing jumps as if some before them were lost.
void find_jumps(RingDownWindow& window, const WatchedHistory& history, const SwingModel& swing,
                double rest, std::size_t begin) {
    const std::vector<double> surprises =
        swing_surprises(history.numbers, history.column, swing, rest);
    std::vector<double> usual;
    for (std::size_t k = begin; k < surprises.size(); ++k)
        if (!std::isnan(surprises[k]))
            usual.push_back(surprises[k]);
    if (usual.size() < 12)
        return;
    const double deviation = std::max(robust_deviation(usual), 0.01);
    const auto period = std::size_t(std::ceil(1.0 / std::max(1e-3, swing.cycles_per_frame())));
    for (std::size_t k = begin; k < surprises.size(); ++k) {
        double amplitude = 0.0;
        for (std::size_t i = k - std::min(k, period); i < std::min(surprises.size(), k + period);
             ++i)
            if (const double size = std::abs(history.column[i] - rest); size > amplitude)
                amplitude = size;
        // One lost frame also disturbs the prediction of the next one.
        if (std::abs(surprises[k]) > std::max(10.0 * deviation, 0.12 * amplitude)) {
            window.remarks.push_back(fmt::format(
                "between the frames {} and {} the swing jumps as if frames were lost or doubled "
                "there; give their numbers as missing_frames if so",
                history.numbers[k - 1], history.numbers[k]));
            k += 2;
        }
    }
}

} // namespace

RingDownWindow find_ring_down(const AxisRecord& record, const WindowOptions& options) {
    const std::size_t watched = place_to_watch(record);
    const WatchedHistory history{record.numbers, record.history(watched)};
    refuse_still_stem(history, options.source);
    std::vector<double> late;
    for (std::size_t k = history.column.size() * 3 / 4; k < history.column.size(); ++k)
        if (!std::isnan(history.column[k]))
            late.push_back(history.column[k]);
    if (late.empty())
        throw core::InputError(fmt::format(
            "{}: the stem is not seen in the last quarter of the recording", options.source));
    double rest = median(late);
    ReleaseMoment release = find_release(history, rest, options.release_frame, options.source);

    RingDownWindow window;
    const std::size_t after_first_swings = std::min(
        history.column.size(), release.last_held + std::size_t(std::ceil(1.5 * release.period)));
    const std::optional<SwingModel> swing =
        fit_swing(record, after_first_swings, history.column.size(), release.period);
    const std::vector<double> about_swing =
        swing ? spread_about(*swing, record, after_first_swings) : std::vector<double>{};
    double reading = swing ? about_swing[watched] : 0.0;
    if (release.held_frames >= fewest_still_frames) {
        const std::size_t end = release.last_held + 1;
        reading = std::max(reading, deviation_of(history.column, end - release.held_frames, end));
    }
    // Of a hundred periods at rest, with some 16 frames each, the worst scatters by 1.6 times the
    // reading's deviation; a swing that adds as much has an amplitude of 1.8 deviations.
    window.rest_begin =
        find_rest(history, release.last_held + 1, release.period, 1.6 * std::max(reading, 0.02));
    const bool is_rest_seen =
        window.rest_begin && history.column.size() - *window.rest_begin >= fewest_still_frames;
    if (is_rest_seen) {
        for (std::size_t h = 0; h < record.places.size(); ++h) {
            const std::vector<double> columns = record.history(h);
            std::vector<double> still;
            for (std::size_t k = *window.rest_begin; k < columns.size(); ++k)
                if (!std::isnan(columns[k]))
                    still.push_back(columns[k]);
            window.rest.push_back(median(std::move(still)));
        }
    } else if (swing) {
        window.rest_source = RestSource::DecayingSwing;
        window.rest = swing->rest;
    } else {
        throw core::InputError(fmt::format(
            "{}: the recording ends before the stem is at rest, and shows too little of the swing "
            "to tell where rest is",
            options.source));
    }
    rest = window.rest[watched];
    release = find_release(history, rest, options.release_frame, options.source);
    window.last_held = release.last_held;
    window.held_frames = release.held_frames;
    window.release_number = release.number;
    window.sign = release.sign;
    window.watched = watched;
    window.pull = release.pull;
    window.cycles_per_frame = 1.0 / release.period;
    window.moving_noise = about_swing;
    find_noise(window, record, about_swing);
    if (const auto step = fit_swing(record, after_first_swings, history.column.size(), 1.0);
        step && step->cycles_per_frame() > 0.0)
        find_jumps(window, history, *step, rest, after_first_swings);
    return window;
}

} // namespace culm::measure
