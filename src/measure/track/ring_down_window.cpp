// SPDX-License-Identifier: BSD-3-Clause
#include "core/error.hpp"
#include "core/order_statistics.hpp"
#include "measure/release/release_curve.hpp"
#include "measure/track/track.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Core>
#include <fmt/core.h>

namespace culm::measure {
namespace {

constexpr double nothing = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t fewest_still_frames = 5;

/// Locations seen in 19 of 20 frames, from the highest down; if there are none, the one seen most.
std::vector<std::size_t> places_to_watch(const AxisRecord& record) {
    std::vector<std::size_t> places;
    std::size_t most_seen = 0;
    for (std::size_t h = record.places.size(); h-- > 0;) {
        if (record.seen(h) >= 0.95)
            places.push_back(h);
        if (record.seen(h) > record.seen(most_seen))
            most_seen = h;
    }
    if (places.empty())
        places.push_back(most_seen);
    return places;
}

void refuse_still_stem(const std::vector<double>& column, const std::string& source) {
    const std::vector<double> seen = known(column);
    if (seen.size() < 12)
        throw core::InputError(
            fmt::format("{}: the stem is seen in {} of {} frames only; 12 at least are needed",
                        source, seen.size(), column.size()));
    const double range = core::quantile(seen, 0.99) - core::quantile(seen, 0.01);
    if (range < 1.0)
        throw core::InputError(fmt::format("{}: the stem does not move (by {:.2f} pixels, where 1 "
                                           "is needed): it is never released",
                                           source, range));
}

/// Standard deviation of the readings in the frames begin … end − 1; NaN of fewer than two.
double deviation_of(const std::vector<double>& column, std::size_t begin, std::size_t end) {
    const std::vector<double> seen = known(std::span(column).subspan(begin, end - begin));
    const Eigen::Map<const Eigen::ArrayXd> values(seen.data(), std::ssize(seen));
    return seen.size() > 1
               ? (values - values.mean()).matrix().norm() / std::sqrt(double(seen.size() - 1))
               : nothing;
}

/// Index of the first frame from which the readings of every period scatter by at most the limit.
std::optional<std::size_t> find_rest(const std::vector<double>& column, std::size_t after,
                                     double period, double limit) {
    // A window of one period contains the whole amplitude of a remaining swing. The search runs
    // backwards: the first window that exceeds the limit is the end of the swing.
    const auto window = std::max<std::size_t>(8, std::size_t(std::ceil(period)));
    const std::size_t count = column.size();
    std::optional<std::size_t> begin;
    for (std::size_t end = count; end >= after + window; --end) {
        if (deviation_of(column, end - window, end) > limit)
            break;
        begin = end - window;
    }
    return begin;
}

/// Standard deviations of the locations over frames begin … end − 1, for locations seen there.
std::vector<double> spread(const AxisRecord& record, std::size_t begin, std::size_t end) {
    std::vector<double> result;
    for (std::size_t h = 0; h < record.places.size(); ++h) {
        const std::vector<double> history = record.history(h);
        const std::size_t seen = known(std::span(history).subspan(begin, end - begin)).size();
        result.push_back(seen >= fewest_still_frames ? deviation_of(history, begin, end) : nothing);
    }
    return result;
}

/// Standard deviations from few frames are inaccurate: each variance is averaged with that of all
/// locations, which has the weight of 20 frames.
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

/// (places) standard deviation of a reading about a swing, of the frames from an index on.
std::vector<double> spread_about_swing(const RingDownWindow& window, const AxisRecord& record,
                                       std::size_t begin) {
    std::vector<double> result;
    for (std::size_t h = 0; h < record.places.size(); ++h)
        result.push_back(scatter_about_swing(record.times, record.history(h), record.times[begin],
                                             window.period(), window.release.decay_per_cycle));
    return result;
}

void find_noise(RingDownWindow& window, const AxisRecord& record) {
    const std::size_t count = record.numbers.size();
    const std::size_t at_rest = window.rest_begin ? count - *window.rest_begin : 0;
    const std::size_t held = window.held_frames;
    // Frames after rest are preferred if there are clearly more; a finger that holds may tremble.
    if (held >= fewest_still_frames && at_rest < 4 * held) {
        const std::size_t end = window.last_held + 1;
        const std::size_t begin = end - std::min(end, held);
        window.noise = spread(record, begin, end);
        draw_together(window.noise, held);
        window.noise_source = fmt::format("{} frames before the release", held);
    } else if (at_rest >= fewest_still_frames) {
        window.noise = spread(record, *window.rest_begin, count);
        // A good tracker still resolves the last of the swing, which is not noise.
        const std::vector<double> about_swing =
            spread_about_swing(window, record, *window.rest_begin);
        for (std::size_t h = 0; h < window.noise.size(); ++h)
            window.noise[h] = std::fmin(window.noise[h], about_swing[h]);
        draw_together(window.noise, at_rest);
        window.noise_source = fmt::format("{} frames after rest", at_rest);
    }
    if (!known(window.noise).empty())
        return;
    window.noise = window.moving_noise;
    window.noise_source = "residual of a damped sine in the last cycles";
}

/// The history of a location, (frames), and what is known of the window from it.
struct WatchedPlace {
    std::vector<double> column;
    RingDownWindow window;
};

/// Counts the frames in which the stem is held: at the same position, before the release.
void count_held(WatchedPlace& watched, const AxisRecord& record, const WindowOptions& options) {
    RingDownWindow& window = watched.window;
    const SwingRelease& release = window.release;
    const double close = std::max({4.0 * release.noise, 0.005 * window.pull(), 0.05});
    const auto is_held = [&](std::size_t k) {
        return std::abs(watched.column[k] - release.held) <= close;
    };
    for (std::size_t k = 0; k < record.times.size() && record.times[k] <= release.time; ++k)
        if (is_held(k))
            window.last_held = k;
    window.last_held = options.release_frame.value_or(window.last_held);
    for (std::size_t k = window.last_held + 1;
         k-- > 0 && record.times[k] >= release.held_begin && is_held(k);)
        ++window.held_frames;
    window.held_frames = std::max<std::size_t>(1, window.held_frames);
}

WatchedPlace watch(const AxisRecord& record, std::size_t place, const WindowOptions& options) {
    WatchedPlace watched{record.history(place), {}};
    RingDownWindow& window = watched.window;
    window.watched = place;
    refuse_still_stem(watched.column, options.source);
    std::optional<double> last_held;
    if (options.release_frame)
        last_held = record.times[*options.release_frame];
    try {
        window.release = find_swing_release(record.times, watched.column,
                                            record.places[place] / options.length, last_held);
    } catch (const core::InputError& error) {
        throw core::InputError(fmt::format(
            "{}: {}. If the recording shows the release, give the last frame in which the stem is "
            "held as release_frame",
            options.source, error.what()));
    }
    count_held(watched, record, options);
    return watched;
}

/// Whether the location was seen while the stem was held and when it fell.
bool shows_release(const WatchedPlace& watched) {
    const std::vector<double>& column = watched.column;
    const auto unseen = [&](std::size_t begin, std::size_t end) {
        return std::count_if(column.begin() + std::ptrdiff_t(begin),
                             column.begin() + std::ptrdiff_t(std::min(end, column.size())),
                             [](double value) { return std::isnan(value); });
    };
    const std::size_t moving = watched.window.last_held + 1;
    return 10 * unseen(0, moving) <= std::ptrdiff_t(moving) && unseen(moving, moving + 4) == 0;
}

/// The highest location that shows the release: higher ones may be outside the picture or hidden at
/// that time. If there is none, a location without gaps determines the error message.
WatchedPlace choose_place(const AxisRecord& record, const WindowOptions& options) {
    std::optional<WatchedPlace> second_best;
    std::optional<core::InputError> refusal;
    for (const std::size_t place : places_to_watch(record)) {
        try {
            WatchedPlace watched = watch(record, place, options);
            if (shows_release(watched))
                return watched;
            if (!second_best)
                second_best = std::move(watched);
        } catch (const core::InputError& error) {
            refusal = error;
            if (record.seen(place) == 1.0)
                break;
        }
    }
    if (refusal || !second_best)
        throw *refusal;
    return *second_best;
}

/// (places) the median after the motion has died down, or the centre of the decaying swing.
std::vector<double> rest_positions(const RingDownWindow& window, const AxisRecord& record) {
    std::vector<double> rest;
    for (std::size_t h = 0; h < record.places.size(); ++h) {
        const std::vector<double> columns = record.history(h);
        rest.push_back(window.is_rest_seen
                           ? core::median(known(std::span(columns).subspan(*window.rest_begin)))
                           : centre_of_swing(record.times, columns, window.release.passages.front(),
                                             window.period()));
    }
    return rest;
}

/// Remarks about frames that were lost or doubled: there a passage of the swing through its rest
/// comes 4 % of a period too early or too late. `relative_height` is that of the location.
std::vector<std::string> find_jumps(const SwingRelease& release, double relative_height) {
    std::vector<std::string> remarks;
    const std::vector<double>& passages = release.passages;
    // A jump does not change the median time between passages.
    const double period =
        passages.size() < 5 ? release.period : 2.0 * core::median_interval(passages);
    double noise = release.noise / std::abs(release.held - release.rest); // over the amplitude
    double before = release.time;
    double expected =
        ReleaseCurve{relative_height, period, release.decay_per_cycle}.first_passage();
    for (const double passage : passages) {
        if (std::abs(passage - before - expected) > (0.04 + 2.0 * noise) * period)
            remarks.push_back(fmt::format(
                "between the frames {:.0f} and {:.0f} the swing jumps as if frames were lost or "
                "doubled there; give their numbers as missing_frames if so",
                std::floor(before), std::ceil(passage)));
        before = passage;
        expected = 0.5 * period;
        noise *= std::exp(0.5 * release.decay_per_cycle);
    }
    return remarks;
}

} // namespace

RingDownWindow find_ring_down(const AxisRecord& record, const WindowOptions& options) {
    auto [column, window] = choose_place(record, options);
    const std::size_t settled = window.last_held + std::size_t(std::ceil(1.5 * window.period()));
    window.moving_noise = spread_about_swing(window, record, std::min(settled, column.size() - 1));
    double reading = std::fmax(0.0, window.moving_noise[window.watched]);
    if (window.held_frames >= fewest_still_frames) {
        const std::size_t end = window.last_held + 1;
        reading = std::max(reading, deviation_of(column, end - window.held_frames, end));
    }
    // In a hundred periods at rest of some 16 frames each, the largest scatter is 1.6 times the
    // reading's deviation; a swing that adds as much has an amplitude of 1.8 deviations.
    window.rest_begin =
        find_rest(column, window.last_held + 1, window.period(), 1.6 * std::max(reading, 0.02));
    window.is_rest_seen =
        window.rest_begin && column.size() - *window.rest_begin >= fewest_still_frames;
    if (!window.is_rest_seen && window.release.passages.size() < 3)
        throw core::InputError(fmt::format(
            "{}: the recording ends before the stem is at rest, and shows too little of the swing "
            "to determine the rest position",
            options.source));
    window.rest = rest_positions(window, record);
    find_noise(window, record);
    if (record.is_even())
        window.remarks = find_jumps(window.release, record.places[window.watched] / options.length);
    if (window.release.uncertainty > 0.02 * window.period())
        window.remarks.push_back(fmt::format(
            "the moment of release is uncertain by {:.1g} frames (standard): was the stem let go "
            "slowly, or are frames missing there?",
            window.release.uncertainty));
    return window;
}

} // namespace culm::measure
