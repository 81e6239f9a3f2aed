// SPDX-License-Identifier: BSD-3-Clause
#include "measure/swing_jumps.hpp"

#include "measure/order_statistics.hpp"
#include "measure/release_curve.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/core.h>

namespace culm::measure {
namespace {

std::string jump_between(int before, int after) {
    return fmt::format("between the frames {} and {} the swing jumps as if frames were lost or "
                       "doubled there; give their numbers as missing_frames if so",
                       before, after);
}

/// Twice the median time between passages, which a jump does not move; of fewer than four the
/// recurrence's period.
double usual_period(const std::vector<double>& passages, double otherwise) {
    std::vector<double> times;
    for (std::size_t i = 1; i < passages.size(); ++i)
        times.push_back(passages[i] - passages[i - 1]);
    return times.size() < 4 ? otherwise : 2.0 * median(std::move(times));
}

/// Passages through the rest that come too early or too late, until the swing has settled.
void judge_passages(const WatchedHistory& history, const ReleaseMoment& release,
                    const SwingModel& model, const SwingOfPlace& swing,
                    std::vector<std::string>& remarks) {
    const double period = usual_period(release.passages, 1.0 / model.cycles_per_frame());
    const ReleaseCurve curve{swing.relative_height, period, swing.decay_per_cycle};
    const double tolerance = (0.04 + 2.0 * release.held_noise / release.pull) * period;
    double before = release.number;
    double expected = curve.first_passage();
    for (const double passage : release.passages) {
        if (before > history.numbers[std::min(swing.settled_frame, history.numbers.size() - 1)])
            break;
        if (std::abs(passage - before - expected) > tolerance)
            remarks.push_back(jump_between(int(std::floor(before)), int(std::ceil(passage))));
        before = passage;
        expected = 0.5 * period;
    }
}

/// Largest distance from the rest within a period of a frame.
double amplitude_at(const WatchedHistory& history, std::size_t frame, std::size_t period,
                    double rest) {
    double amplitude = 0.0;
    const std::size_t end = std::min(history.column.size(), frame + period);
    for (std::size_t i = frame - std::min(frame, period); i < end; ++i)
        if (const double size = std::abs(history.column[i] - rest); size > amplitude)
            amplitude = size;
    return amplitude;
}

void judge_surprises(const WatchedHistory& history, const SwingModel& model,
                     const SwingOfPlace& swing, std::vector<std::string>& remarks) {
    const std::vector<double> surprises =
        swing_surprises(history.numbers, history.column, model, swing.rest);
    std::vector<double> usual;
    for (std::size_t k = swing.settled_frame; k < surprises.size(); ++k)
        if (!std::isnan(surprises[k]))
            usual.push_back(surprises[k]);
    if (usual.size() < 12)
        return;
    const double deviation = std::max(robust_deviation(usual), 0.01);
    const auto period = std::size_t(std::ceil(1.0 / std::max(1e-3, model.cycles_per_frame())));
    for (std::size_t k = swing.settled_frame; k < surprises.size(); ++k) {
        const double amplitude = amplitude_at(history, k, period, swing.rest);
        if (std::abs(surprises[k]) > std::max(10.0 * deviation, 0.12 * amplitude)) {
            remarks.push_back(jump_between(history.numbers[k - 1], history.numbers[k]));
            k += 2; // one lost frame also disturbs the prediction of the next one
        }
    }
}

} // namespace

std::vector<std::string> find_jumps(const WatchedHistory& history, const ReleaseMoment& release,
                                    const SwingModel& model, const SwingOfPlace& swing) {
    std::vector<std::string> remarks;
    judge_passages(history, release, model, swing, remarks);
    judge_surprises(history, model, swing, remarks);
    return remarks;
}

} // namespace culm::measure
