// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/naming.hpp"

#include "diagnose/swing.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

namespace culm::diagnose {
namespace {

using nlohmann::json;

constexpr double needed_fall = 10.0; ///< of χ² of readings that were held out

std::string to_text(const HeldOut& held_out) {
    json out = json::array();
    for (const HeldOutPart* part : {&held_out.last_third, &held_out.one_height})
        out.push_back({part->rms, part->over_noise, part->readings, part->blocks, part->failure});
    return out.dump();
}

HeldOut held_out_from(const std::string& text) {
    HeldOut out;
    if (text.empty()) {
        out.last_third.failure = out.one_height.failure = "the rank that computed it was lost";
        return out;
    }
    const json told = json::parse(text);
    HeldOutPart* const parts[]{&out.last_third, &out.one_height};
    for (std::size_t k = 0; k < 2; ++k)
        *parts[k] = {told[k][0], told[k][1], told[k][2], told[k][3].get<std::vector<double>>(),
                     told[k][4]};
    return out;
}

/// By blocks of time (predicts_better), or as a whole: what an effect does in the first
/// milliseconds only is in one block of many. A fall of χ² by 10 in readings that neither model has
/// seen is odds of 150 to 1.
bool is_better(const HeldOutPart& larger, const HeldOutPart& smaller) {
    if (!larger.failure.empty() || !smaller.failure.empty())
        return false;
    const double square = larger.over_noise * larger.over_noise;
    const double fall = static_cast<double>(larger.readings) *
                        (smaller.over_noise * smaller.over_noise - square) / std::max(1.0, square);
    return fall > needed_fall || predicts_better(larger, smaller);
}

/// A late part of the record that has died down tells nothing of an effect on the modes' shapes,
/// and one row little of a slow drift: one of the two has to be predicted better, neither worse.
std::string obstacle(const HeldOut& larger, const HeldOut& smaller) {
    const HeldOutPart& time = larger.last_third;
    const HeldOutPart& height = larger.one_height;
    if (!time.failure.empty())
        return "the fit to the first two thirds failed: " + time.failure;
    const bool has_height = height.failure.empty() && smaller.one_height.failure.empty();
    const bool is_time_better = is_better(time, smaller.last_third);
    const bool is_height_better = has_height && is_better(height, smaller.one_height);
    if (!is_time_better && !is_height_better)
        return fmt::format("neither the last third of the time ({:.3f} times the noise, before "
                           "{:.3f}) nor the height that was left out is predicted better",
                           time.over_noise, smaller.last_third.over_noise);
    if (predicts_better(smaller.last_third, time))
        return fmt::format("the last third of the time is predicted worse ({:.3f} times the noise, "
                           "before {:.3f})",
                           time.over_noise, smaller.last_third.over_noise);
    if (has_height && height.over_noise > allowed_rise * smaller.one_height.over_noise)
        return fmt::format("the height that was left out is predicted worse ({:.3f} times the "
                           "noise, before {:.3f})",
                           height.over_noise, smaller.one_height.over_noise);
    return {};
}

} // namespace

SetVerdict judge(const ModelFit& fit, std::span<const measure::Measurement> recordings) {
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

HeldOutGain held_out_gain(const ModelFit& smaller, const ModelFit& larger,
                          std::span<const measure::Measurement> recordings,
                          const CandidateOptions& options, const WorkMap& map) {
    std::vector<HoldOut> hold_out;
    for (std::size_t m = 0; m < recordings.size(); ++m)
        hold_out.push_back(hold_out_of(row_to_leave_out(smaller.parts[m]), larger.parts[m]));
    const auto work = [&](std::size_t item, const run::Heartbeat& heartbeat) {
        CandidateOptions own = options;
        own.heartbeat = heartbeat;
        return to_text(predict_held_out(item == 0 ? smaller.parts : larger.parts, hold_out,
                                        recordings, belongs_to_recording, own));
    };
    const std::vector<std::string> answers = map({1.0, 1.0}, work);
    const HeldOut before = held_out_from(answers[0]);
    const HeldOut after = held_out_from(answers[1]);
    return {after.last_third.over_noise, before.last_third.over_noise, obstacle(after, before)};
}

} // namespace culm::diagnose
