// SPDX-License-Identifier: BSD-3-Clause
#include "core/error.hpp"
#include "core/order_statistics.hpp"
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

/// Spread between frames in the quietest eight frames, pixels, from second differences, which a
/// slow motion does not affect.
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
            // The second difference of independent readings has 1 + 4 + 1 times their variance.
            quietest = std::min(quietest, core::robust_deviation(differences) / std::sqrt(6.0));
    }
    return std::isfinite(quietest) ? quietest : 0.0;
}

void refuse_still_stem(const WatchedHistory& history, const std::string& source) {
    const std::vector<double> seen = known(history.column);
    if (seen.size() < 12)
        throw core::InputError(
            fmt::format("{}: the stem is seen in {} of {} frames only; 12 at least are needed",
                        source, seen.size(), history.column.size()));
    const double range = core::quantile(seen, 0.99) - core::quantile(seen, 0.01);
    // Readings of a still stem span five standard deviations, and the quietest of a few hundred
    // windows has about a quarter of one.
    const double limit = std::max(1.0, 20.0 * quietest_spread(history.column));
    if (range < limit)
        throw core::InputError(fmt::format("{}: the stem does not move (by {:.2f} pixels, where "
                                           "{:.2f} are needed): it is never released",
                                           source, range, limit));
}

/// Standard deviation of the readings in the frames begin … end − 1; NaN of fewer than two.
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

/// Index of the first frame from which the readings of every period scatter by at most the limit.
std::optional<std::size_t> find_rest(const WatchedHistory& history, std::size_t after,
                                     double period, double limit) {
    // A window of one period contains the whole amplitude of a remaining swing. The search runs
    // backwards: the first window that exceeds the limit is the end of the swing.
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

/// Correlation between readings in consecutive frames over frames begin … end − 1, in which the
/// stem is still. Corrected for the mean of n frames, −(1 + 3r)/n (Kendall 1954); 0 if below two
/// standard deviations. Locations with common errors count as fewer.
std::optional<double> correlation_while_still(const AxisRecord& record, std::size_t begin,
                                              std::size_t end) {
    const auto frames = static_cast<Eigen::Index>(end - begin);
    Eigen::MatrixXd errors(frames, static_cast<Eigen::Index>(record.places.size()));
    Eigen::Index places = 0;
    for (std::size_t h = 0; h < record.places.size(); ++h) {
        for (Eigen::Index k = 0; k < frames; ++k)
            errors(k, places) = record.at(begin + static_cast<std::size_t>(k), h);
        errors.col(places).array() -= errors.col(places).mean();
        places += errors.col(places).allFinite() ? 1 : 0;
    }
    errors.conservativeResize(frames, places);
    const double sum = errors.squaredNorm();
    if (frames < 8 || sum <= 0.0)
        return std::nullopt;
    const auto n = static_cast<double>(frames);
    const double product =
        errors.topRows(frames - 1).cwiseProduct(errors.bottomRows(frames - 1)).sum();
    const double correlation = (n * (product / (n - 1.0)) / (sum / n) + 1.0) / (n - 3.0);
    // For p independent locations tr S²/(tr S)² is 1/p, plus 1/(n − 1) for a sample of n frames.
    const double shared = (errors.transpose() * errors).squaredNorm() / (sum * sum);
    const double share = std::max(shared - 1.0 / (n - 1.0), 1.0 / static_cast<double>(places));
    const double deviation = n / (n - 3.0) * std::sqrt(share / (n - 1.0));
    return correlation > 2.0 * deviation ? std::min(0.99, std::round(100.0 * correlation) / 100.0)
                                         : 0.0;
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

/// (locations) standard deviation of a reading, by the residuals of the recurrence from frame
/// `begin` on.
std::vector<double> spread_about(const SwingModel& swing, const AxisRecord& record,
                                 std::size_t begin) {
    // x_k − a x_{k−1} − b x_{k−2} of readings with the standard deviation σ has σ √(1 + a² + b²).
    const double amplification = std::sqrt(1.0 + swing.a * swing.a + swing.b * swing.b);
    std::vector<double> result;
    for (std::size_t h = 0; h < record.places.size(); ++h) {
        const std::vector<double> surprises =
            swing_surprises(record.numbers, record.history(h), swing, swing.rest[h]);
        // NaN if none is known
        result.push_back(core::robust_deviation(known(std::span(surprises).subspan(begin))) /
                         amplification);
    }
    return result;
}

void find_noise(RingDownWindow& window, const AxisRecord& record,
                const std::optional<SwingModel>& swing,
                const std::vector<double>& spread_about_swing) {
    const std::size_t count = record.numbers.size();
    const std::size_t at_rest = window.rest_begin ? count - *window.rest_begin : 0;
    const std::size_t held = window.release.held_frames;
    // Frames after rest are preferred if there are clearly more; a finger that holds may tremble.
    if (held >= fewest_still_frames && at_rest < 4 * held) {
        const std::size_t end = window.release.last_held + 1;
        const std::size_t begin = end - std::min(end, held);
        window.noise = spread(record, begin, end);
        draw_together(window.noise, held);
        window.noise_source = fmt::format("{} frames before the release", held);
        window.noise_correlation = correlation_while_still(record, begin, end);
    } else if (at_rest >= fewest_still_frames) {
        window.noise = spread(record, *window.rest_begin, count);
        // A good tracker still resolves the last of the swing, which is not noise.
        const std::vector<double> about_swing =
            swing ? spread_about(*swing, record, *window.rest_begin) : window.noise;
        // The last of the swing would also appear as a correlation.
        double excess = 0.0;
        for (std::size_t h = 0; h < window.noise.size(); ++h) {
            excess = std::fmax(excess, window.noise[h] / about_swing[h]);
            window.noise[h] = std::fmin(window.noise[h], about_swing[h]);
        }
        if (excess < 1.2)
            window.noise_correlation = correlation_while_still(record, *window.rest_begin, count);
        draw_together(window.noise, at_rest);
        window.noise_source = fmt::format("{} frames after rest", at_rest);
    }
    if (!known(window.noise).empty() || spread_about_swing.empty())
        return;
    window.noise = spread_about_swing;
    window.noise_source = "residual of a damped swing between neighbouring frames";
}

/// A location, its history, and the release there with a first estimate of the rest.
struct WatchedPlace {
    std::size_t place = 0;
    WatchedHistory history;
    ReleaseMoment release;
};

WatchedPlace watch(const AxisRecord& record, std::size_t place, const WindowOptions& options) {
    WatchedPlace watched{place, {record.numbers, record.history(place)}, {}};
    const std::vector<double>& column = watched.history.column;
    refuse_still_stem(watched.history, options.source);
    const std::vector<double> late = known(std::span(column).subspan(column.size() * 3 / 4));
    if (late.empty())
        throw core::InputError(fmt::format(
            "{}: the stem is not seen in the last quarter of the recording", options.source));
    watched.release = find_release(watched.history,
                                   {.rest = core::median(late),
                                    .relative_height = record.places[place] / options.length,
                                    .decay_per_cycle = 0.0,
                                    .last_held = options.release_frame},
                                   options.source);
    return watched;
}

/// Whether the location was seen while the stem was held and when it fell.
bool shows_release(const WatchedPlace& watched) {
    const std::vector<double>& column = watched.history.column;
    const auto unseen = [&](std::size_t begin, std::size_t end) {
        return std::count_if(column.begin() + std::ptrdiff_t(begin),
                             column.begin() + std::ptrdiff_t(std::min(end, column.size())),
                             [](double value) { return std::isnan(value); });
    };
    const std::size_t moving = watched.release.last_held + 1;
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

} // namespace

RingDownWindow find_ring_down(const AxisRecord& record, const WindowOptions& options) {
    const WatchedPlace chosen = choose_place(record, options);
    const std::size_t watched = chosen.place;
    const WatchedHistory& history = chosen.history;
    ReleaseMoment release = chosen.release;

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
    // In a hundred periods at rest of some 16 frames each, the largest scatter is 1.6 times the
    // reading's deviation; a swing that adds as much has an amplitude of 1.8 deviations.
    window.rest_begin =
        find_rest(history, release.last_held + 1, release.period, 1.6 * std::max(reading, 0.02));
    window.is_rest_seen =
        window.rest_begin && history.column.size() - *window.rest_begin >= fewest_still_frames;
    if (window.is_rest_seen) {
        for (std::size_t h = 0; h < record.places.size(); ++h) {
            const std::vector<double> columns = record.history(h);
            window.rest.push_back(
                core::median(known(std::span(columns).subspan(*window.rest_begin))));
        }
    } else if (swing) {
        window.rest = swing->rest;
    } else {
        throw core::InputError(fmt::format(
            "{}: the recording ends before the stem is at rest, and shows too little of the swing "
            "to determine the rest position",
            options.source));
    }
    const ReleaseClues clues{.rest = window.rest[watched],
                             .relative_height = record.places[watched] / options.length,
                             .decay_per_cycle =
                                 swing ? swing->decay_per_frame() * release.period : 0.0,
                             .last_held = options.release_frame};
    release = find_release(history, clues, options.source);
    window.release = release;
    window.watched = watched;
    window.moving_noise = about_swing;
    find_noise(window, record, swing, about_swing);
    if (const auto step = fit_swing(record, after_first_swings, history.column.size(), 1.0);
        step && step->cycles_per_frame() > 0.0)
        window.remarks = find_jumps(history, release, *step, clues, after_first_swings);
    // Blur, large deflections and the noise of a reading contribute 1 % at most.
    if (release.misfit > 0.04 + 4.0 * release.held_noise / release.pull)
        window.remarks.push_back(fmt::format(
            "the stem leaves its hold otherwise than a beam let go at its tip does, by {:.0f} % of "
            "the pull: was it let go slowly, or are frames missing there? The moment of release is "
            "uncertain",
            100.0 * release.misfit));
    return window;
}

} // namespace culm::measure
