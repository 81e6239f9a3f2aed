// SPDX-License-Identifier: BSD-3-Clause
#include "core/error.hpp"
#include "core/order_statistics.hpp"
#include "measure/track/ring_down.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include <fmt/core.h>

namespace culm::measure {

namespace {

/// Deflections in the direction of the pull, without the frames in which the stem was not seen.
struct Deflections {
    std::vector<std::size_t> frame;
    std::vector<double> value;
};

Deflections deflections_of(const WatchedHistory& history, double rest, double sign) {
    Deflections result;
    for (std::size_t k = 0; k < history.column.size(); ++k)
        if (!std::isnan(history.column[k])) {
            result.frame.push_back(k);
            result.value.push_back(sign * (history.column[k] - rest));
        }
    return result;
}

/// Crossings of the rest after position `from`, in frame numbers with fractions. A swing counts if
/// it exceeds the rest by more than `least` on the other side.
std::vector<double> crossings(const Deflections& deflections, const std::vector<int>& numbers,
                              std::size_t from, double least) {
    std::vector<double> found;
    double side = 1.0;
    std::optional<double> pending;
    for (std::size_t i = from + 1; i < deflections.value.size(); ++i) {
        const double before = side * deflections.value[i - 1];
        const double now = side * deflections.value[i];
        if (before > 0.0 && now <= 0.0) {
            const double begin = numbers[deflections.frame[i - 1]];
            const double step = numbers[deflections.frame[i]] - begin;
            pending = begin + step * before / (before - now);
        }
        // Noise crosses the rest often, so a crossing counts only after the stem has moved further.
        if (pending && now < -least) {
            found.push_back(*pending);
            pending.reset();
            side = -side;
        }
    }
    return found;
}

/// Position (in the seen frames) of the first value below half the largest that follows it.
std::optional<std::size_t> first_fall(const Deflections& deflections, double largest) {
    // A held stem drifts and trembles slightly, so a level just below the largest one is
    // sufficient.
    const auto peak = std::ranges::find_if(deflections.value,
                                           [&](double value) { return value >= 0.97 * largest; });
    const auto fall = std::find_if(peak, deflections.value.end(),
                                   [&](double value) { return value < 0.5 * largest; });
    if (fall == deflections.value.end())
        return std::nullopt;
    return std::size_t(fall - deflections.value.begin());
}

/// Position of the last held frame before `fall`, and the held level.
struct Hold {
    std::size_t last = 0;
    std::size_t frames = 0;
    double level = 0.0;
    double noise = 0.0;
    double tolerance = 0.0; ///< of what counts as held
};

Hold find_hold(const Deflections& deflections, std::size_t fall, double largest) {
    std::vector<double> near; // at most 50 frames before the fall, as long as they are held
    for (std::size_t i = fall; i-- > 0 && near.size() < 50;)
        if (deflections.value[i] > 0.9 * largest)
            near.push_back(deflections.value[i]);
        else if (!near.empty())
            break;
    // The first frames in motion are included: at most a handful, so the median remains that of the
    // held frames if there are enough; otherwise the frames furthest from the fall are used.
    if (near.size() <= 6)
        std::ranges::reverse(near), near.resize(std::max<std::size_t>(1, (near.size() + 1) / 2));
    Hold hold;
    hold.level = core::median(near);
    hold.noise = near.size() > 2 ? core::robust_deviation(near) : 0.0;
    hold.tolerance = std::max(4.0 * hold.noise, std::max(0.05, 0.005 * largest));
    const auto is_held = [&](std::size_t i) {
        return std::abs(deflections.value[i] - hold.level) <= hold.tolerance;
    };
    hold.last = fall;
    while (hold.last > 0 && !is_held(hold.last))
        --hold.last;
    for (std::size_t i = hold.last + 1; i-- > 0 && is_held(i);)
        ++hold.frames;
    return hold;
}

struct FittedMoment {
    double number = 0.0;
    double misfit = 0.0; ///< largest difference from the curve, of the held level
};

/// Frame number from which the readings of a tenth of a swing (at least three frames) after the
/// hold follow the curve best, by least squares. The noise of the hold hides a slow start: the
/// moment may precede the last apparently held frame by as much, unless that frame is given.
FittedMoment moment_of_release(const Deflections& deflections, const std::vector<int>& numbers,
                               const Hold& hold, const ReleaseCurve& curve, bool is_given) {
    const double reach = std::max(3.0, 0.1 * curve.period);
    const double last = numbers[deflections.frame[hold.last]];
    const double earliest = is_given ? last : last - 0.1 * curve.period;
    constexpr double step = 0.005;
    FittedMoment best{last + 0.5, 0.0};
    double least = std::numeric_limits<double>::infinity();
    for (double moment = earliest; moment <= last + 1.0; moment += step) {
        double squares = 0.0;
        double largest = 0.0;
        for (std::size_t i = 0; i < deflections.value.size(); ++i) {
            const double number = numbers[deflections.frame[i]];
            if (number < earliest || number > last + reach)
                continue;
            const double off =
                std::abs(deflections.value[i] / hold.level - curve.at(number - moment));
            squares += off * off;
            largest = std::max(largest, off);
        }
        if (squares < least) {
            least = squares;
            best = {moment, largest};
        }
    }
    return best;
}

/// Number of frames for which the turning point of a swing stays within the hold's tolerance, above
/// and below its level.
double turning_frames(const Hold& hold, double period) {
    const double cosine = std::clamp(1.0 - 2.0 * hold.tolerance / hold.level, -1.0, 1.0);
    return std::acos(cosine) / std::numbers::pi * period;
}

void refuse_unheld(const Hold& hold, double least, const std::string& source) {
    if (static_cast<double>(hold.frames) < least)
        throw core::InputError(fmt::format(
            "{}: no frame shows the stem held still before the release: the recording begins too "
            "late (or give the last held frame as release_frame)",
            source));
}

} // namespace

ReleaseMoment find_release(const WatchedHistory& history, const ReleaseClues& clues,
                           const std::string& source) {
    ReleaseMoment release;
    // The pull is first; the swing to the other side may look as wide with an inaccurate rest.
    double widest = 0.0;
    for (const double column : history.column)
        if (std::abs(column - clues.rest) > widest)
            widest = std::abs(column - clues.rest);
    const auto pulled = std::ranges::find_if(history.column, [&](double column) {
        return std::abs(column - clues.rest) >= 0.7 * widest;
    });
    release.sign = *pulled >= clues.rest ? 1.0 : -1.0;
    const Deflections deflections = deflections_of(history, clues.rest, release.sign);

    const double largest = std::ranges::max(deflections.value);
    const std::optional<std::size_t> fall = first_fall(deflections, largest);
    if (!fall)
        throw core::InputError(fmt::format(
            "{}: the stem is never let go: it is pulled aside by {:.1f} pixels and does not come "
            "back",
            source, largest));
    Hold hold = find_hold(deflections, *fall, largest);
    if (clues.last_held) {
        const auto found = std::ranges::lower_bound(deflections.frame, *clues.last_held);
        hold.last =
            std::min(std::size_t(found - deflections.frame.begin()), deflections.frame.size() - 1);
        hold.level = deflections.value[hold.last];
        hold.frames = std::max<std::size_t>(1, std::min(hold.frames, hold.last + 1));
    } else {
        refuse_unheld(hold, 2.0, source);
    }
    release.passages = crossings(deflections, history.numbers, hold.last,
                                 std::max(6.0 * hold.noise, 0.01 * largest));
    if (release.passages.size() < 2)
        throw core::InputError(fmt::format(
            "{}: the stem does not swing: after frame {} it passes its rest position {} instead of "
            "at least 2 times, so no release was found (was it let go, is the recording long "
            "enough?)",
            source, history.numbers[deflections.frame[hold.last]],
            release.passages.empty() ? "never" : "once"));
    release.period = 2.0 * (release.passages.back() - release.passages.front()) /
                     double(release.passages.size() - 1);
    if (!clues.last_held)
        refuse_unheld(hold, 2.0 + turning_frames(hold, release.period), source);
    const FittedMoment moment =
        moment_of_release(deflections, history.numbers, hold,
                          {clues.relative_height, release.period, clues.decay_per_cycle},
                          clues.last_held.has_value());
    release.number = moment.number;
    release.misfit = moment.misfit;
    while (hold.last > 0 && hold.frames > 1 &&
           history.numbers[deflections.frame[hold.last]] > release.number) {
        --hold.last;
        --hold.frames;
    }
    release.last_held = deflections.frame[hold.last];
    release.held_frames = hold.frames;
    release.held_noise = hold.noise;
    release.pull = hold.level;
    return release;
}

} // namespace culm::measure
