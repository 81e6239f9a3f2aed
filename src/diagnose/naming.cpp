// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/naming.hpp"

#include "diagnose/swing.hpp"
#include "fit/coarse_image.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

namespace culm::diagnose {
namespace {

using nlohmann::json;

constexpr double certain_share = 0.1; ///< of χ² that may be left
/// Reduced χ² that no noise and no imperfection of a chain of spheres makes.
constexpr double glaring_misfit = 4.0;
/// Of such a misfit, that each effect of a step takes: of the three effects that an answer may
/// have, the largest takes a third and more unless they cancel. What takes less bends a wrong model
/// to fit.
constexpr double least_share = 0.2;

std::string to_text(const HeldOutPart& part) {
    return json{part.rms, part.over_noise, part.readings, part.blocks, part.failure}.dump();
}

HeldOutPart held_out_from(const std::string& text) {
    HeldOutPart part;
    if (text.empty()) {
        part.failure = "the rank that computed it was lost";
        return part;
    }
    const json told = json::parse(text);
    return {told[0], told[1], told[2], told[3].get<std::vector<double>>(), told[4]};
}

} // namespace

std::string step_obstacle(const fit::Fit& smaller, const fit::Fit& larger, const Yardstick& by,
                          std::size_t tried) {
    const double gain = bic(smaller, by) - bic(larger, by);
    if (!(gain >= naming_gain))
        return fmt::format("BIC falls by {:.1f}, less than {:g}", gain, naming_gain);
    const double p =
        gain_p_value(smaller, larger, by) * static_cast<double>(std::max<std::size_t>(tried, 1));
    if (!(p < naming_level))
        return fmt::format("the gain is not significant (p = {:.2g})", p);
    if (larger.chi_squared > step_limit(smaller, larger.names.size() - smaller.names.size()))
        return fmt::format("it takes {:.0f} % of a misfit that stays glaring",
                           100.0 * (1.0 - larger.chi_squared / smaller.chi_squared));
    return {};
}

bool acts_for_certain(const fit::Fit& smaller, const fit::Fit& larger) {
    return larger.parameters.size() <= smaller.parameters.size() &&
           larger.chi_squared < certain_share * smaller.chi_squared;
}

bool promises_significant_gain(const std::vector<EffectScore>& scores, const fit::Fit& fit) {
    const Yardstick own = yardstick(std::vector{fit});
    return std::ranges::any_of(scores, [&](const EffectScore& score) {
        const double gain = score.gain / own.inflation * own.share;
        return score.failure.empty() &&
               gain_p_value(gain, score.added) * static_cast<double>(scores.size()) < naming_level;
    });
}

bool explains(const fit::Fit& smaller, const fit::Fit& larger, double share) {
    const auto readings = static_cast<double>(smaller.readings);
    return larger.is_fitted() && !larger.out_of_reach &&
           larger.chi_squared - readings < (1.0 - share) * (smaller.chi_squared - readings);
}

double step_limit(const fit::Fit& smaller, std::size_t added) {
    const auto readings = static_cast<double>(smaller.readings);
    const double share = least_share * static_cast<double>(added);
    return std::max(glaring_misfit * readings,
                    smaller.chi_squared - share * (smaller.chi_squared - readings));
}

SetVerdict judge(const fit::Fit& fit, std::span<const measure::Measurement> recordings) {
    SetVerdict out;
    out.finding = Finding::Adequate;
    bool can_tell = false;
    for (std::size_t m = 0; m < fit.parts.size(); ++m) {
        const Verdict own = judge(fit.parts[m], swing_of(fit.parts[m], recordings[m]));
        if (own.finding == Finding::Undecided) {
            if (!can_tell)
                out.reason = own.reason;
            continue;
        }
        if (!can_tell)
            out.reason.clear();
        can_tell = true;
        const double p =
            std::min(1.0, own.p_value * static_cast<double>(fit.parts.size())); // Bonferroni
        out.p_value = std::min(out.p_value, p);
        if (p >= naming_level)
            continue;
        out.finding = Finding::Inadequate;
        if (!out.reason.empty())
            out.reason += "; ";
        out.reason += own.reason;
    }
    if (!can_tell)
        out.finding = Finding::Undecided;
    return out;
}

HeldOutGain held_out_gain(const fit::Fit& smaller, const fit::Fit& larger,
                          std::span<const measure::Measurement> recordings,
                          const fit::FitOptions& options, const fit::WorkMap& map) {
    std::vector<HoldOut> hold_out;
    for (std::size_t m = 0; m < recordings.size(); ++m)
        hold_out.push_back(hold_out_of(row_to_leave_out(smaller.parts[m]), larger.parts[m]));
    const fit::CoarseImage smaller_image(smaller, recordings, options);
    const fit::CoarseImage larger_image(larger, recordings, options);
    const auto work = [&](std::size_t item, const run::Heartbeat& heartbeat) {
        fit::FitOptions own = options;
        own.heartbeat = heartbeat;
        const fit::CoarseImage& image = item < 2 ? smaller_image : larger_image;
        return to_text(predict_held_out(
            item % 2 == 0 ? HeldOutReadings::LastThird : HeldOutReadings::OneHeight,
            image.fit().parts, hold_out, image.recordings(), fit::belongs_to_recording, own));
    };
    const std::vector<std::string> answers = map({1.0, 1.0, 2.0, 2.0}, work);
    const HeldOut before{held_out_from(answers[0]), held_out_from(answers[1])};
    const HeldOut after{held_out_from(answers[2]), held_out_from(answers[3])};
    return {after.last_third.over_noise, before.last_third.over_noise,
            held_out_obstacle(after, before)};
}

} // namespace culm::diagnose
