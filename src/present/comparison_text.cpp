// SPDX-License-Identifier: BSD-3-Clause
#include "fit/solve/residual_statistics.hpp"
#include "present/comparison.hpp"
#include "present/parameters.hpp"
#include "present/text.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace culm::present {
namespace {

using diagnose::Comparison;
using diagnose::Finding;

constexpr double largest_relative_error = 0.25; ///< of a damping ratio that is quoted
constexpr double explained_by_noise = 1.1;      ///< residual over noise

std::string whether_it_fits(const Comparison& comparison) {
    const diagnose::Verdict& verdict = comparison.verdict;
    const measure::ReadingUnit& unit = comparison.unit;
    const std::string sizes =
        !verdict.is_noise_known
            ? fmt::format("residual {} (rms); the noise is not stated", unit.text(comparison.rmse))
            : fmt::format("residual {} (rms), noise {}, ratio {:.2f}", unit.text(comparison.rmse),
                          unit.text(comparison.noise), comparison.over_noise);
    if (verdict.finding == Finding::Undecided)
        return fmt::format("Undecided: {}.", verdict.reason);
    return fmt::format("The model is {}: {} ({}).", diagnose::to_string(verdict.finding), sizes,
                       verdict.p_value < 1e-12 ? "p < 1e-12"
                                               : fmt::format("p = {:.2g}", verdict.p_value));
}

std::string where_it_fails(const Comparison& comparison) {
    const auto height =
        std::ranges::max_element(comparison.by_height, {}, &fit::ResidualGroup::over_noise);
    const auto time =
        std::ranges::max_element(comparison.by_time, {}, &fit::ResidualGroup::over_noise);
    if (height == comparison.by_height.end() || time == comparison.by_time.end())
        return {};
    static constexpr std::array<const char*, 3> names{"first", "second", "last"};
    const auto third = static_cast<std::size_t>(time - comparison.by_time.begin());
    std::string text = "The misfit is largest";
    if (comparison.by_height.size() > 1)
        text += fmt::format(" at h = {:.4g} mm ({:.1f} times the noise; the mean over the heights "
                            "is {:.1f}) and",
                            1e3 * height->lower, height->over_noise, comparison.over_noise);
    text += fmt::format(" in the {} third of the time ({:.1f} times the noise", names[third],
                        time->over_noise);
    for (std::size_t k = 0; k < comparison.by_time.size(); ++k)
        if (k != third)
            text += fmt::format(", {} {:.1f}", names[k], comparison.by_time[k].over_noise);
    text += ")";
    const std::vector<double>& shares = comparison.spectrum.mode_shares;
    if (const auto share = std::ranges::max_element(shares); share != shares.end() && *share > 0.0)
        text += fmt::format("; {:.0f} % of its power lies within a quarter of the frequency of "
                            "mode {}",
                            100.0 * *share, share - shares.begin() + 1);
    return text + ".";
}

/// Frequency and damping ratio of mode 1 at the largest and at the smallest amplitude where the
/// readings determine them; empty if there are no two such amplitudes.
std::string backbone_sentence(const residuals::BackbonesOfBoth& both) {
    if (both.measured.empty() || both.modelled.empty() || both.modelled.front().points.empty())
        return {};
    std::vector<reduce::BackbonePoint> measured;
    for (const reduce::BackbonePoint& point : both.measured.front().points)
        if (point.damping_error < largest_relative_error * std::abs(point.damping_ratio))
            measured.push_back(point);
    if (measured.size() < 2)
        return {};
    const auto modelled_at = [&](double amplitude) {
        return *std::ranges::min_element(both.modelled.front().points, {},
                                         [&](const reduce::BackbonePoint& point) {
                                             return std::abs(std::log(point.amplitude / amplitude));
                                         });
    };
    const reduce::BackbonePoint modelled_first = modelled_at(measured.front().amplitude);
    const reduce::BackbonePoint modelled_last = modelled_at(measured.back().amplitude);
    return fmt::format(
        "From {:.2g} to {:.2g} {} of amplitude the measured frequency goes from {:.2f} to {:.2f} "
        "Hz and the damping ratio from {:.4f} to {:.4f}; the modelled ones go from {:.2f} to "
        "{:.2f} Hz and from {:.4f} to {:.4f}.",
        1e3 * measured.front().amplitude, 1e3 * measured.back().amplitude,
        both.measured.front().is_strain ? "mm/m" : "mm", measured.front().frequency,
        measured.back().frequency, measured.front().damping_ratio, measured.back().damping_ratio,
        modelled_first.frequency, modelled_last.frequency, modelled_first.damping_ratio,
        modelled_last.damping_ratio);
}

const diagnose::Comparison& comparison_of(const diagnose::Ladder& ladder, std::size_t model) {
    return *ladder.models[model].comparison;
}

std::string comparison_header(const diagnose::Ladder& ladder,
                              const measure::Measurement& measurement, const std::string& law) {
    const diagnose::LadderModel* last = last_fitted(ladder);
    const bool is_noise_known = last != nullptr && last->fit.parts.front().is_noise_known;
    return result_lines(
        "", fmt::format(
                "{}: {}, {} frames, law {}, {}", measurement.stem.id,
                counted(measurement.heights.size(), "height"), measurement.times.size(), law,
                is_noise_known ? fmt::format("noise {} ({})",
                                             measure::reading_unit(measurement.sensors)
                                                 .text(fit::typical_noise(last->fit.parts.front())),
                                             last->fit.parts.front().noise_source)
                               : std::string("noise not stated")));
}

/// The effects that a model adds to the one above it, in `width` columns; a longer name gets its
/// own line.
std::string ladder_name(const diagnose::LadderModel& model, std::size_t width) {
    const std::string name =
        model.added.empty() ? "baseline" : fmt::format("+ {}", fmt::join(model.added, " + "));
    return name.size() <= width ? fmt::format("{:<{}}", name, width)
                                : fmt::format("{}\n{:<{}}", name, "", width);
}

std::string ladder_line(const diagnose::Ladder& ladder, std::size_t k, std::size_t width) {
    const diagnose::LadderModel& model = ladder.models[k];
    const std::string name = ladder_name(model, width);
    if (model.fit.failed())
        return fmt::format("{} failed: {}\n", name, model.fit.reason);
    const diagnose::Comparison& comparison = comparison_of(ladder, k);
    const diagnose::Verdict& verdict = comparison.verdict;
    const bool is_noise_known = model.fit.is_noise_known_everywhere();
    return fmt::format("{} {:>9} {:>7} {:>10} {:>13}  {}\n", name,
                       number_cell(comparison.unit.factor * comparison.rmse, 4),
                       is_noise_known ? number_cell(comparison.over_noise, 2) : "-",
                       number_cell(verdict.reduced_chi_squared, 3),
                       k == 0 ? std::string() : fmt::format("{:+.0f}", model.log_evidence),
                       diagnose::to_string(verdict.finding));
}

std::string ladder_lines(const diagnose::Ladder& ladder) {
    constexpr std::size_t width = 22;
    const auto first = std::ranges::find_if(
        ladder.models, [](const auto& model) { return model.comparison.has_value(); });
    const std::string_view unit =
        first == ladder.models.end() ? measure::ReadingUnit{}.name : first->comparison->unit.name;
    std::string text = fmt::format("{:<{}} {:>9} {:>7} {:>10} {:>13}  {}\n", "model", width,
                                   fmt::format("rms {}", unit), "/noise", "red. chi2*",
                                   "log evidence*", "verdict*");
    for (std::size_t k = 0; k < ladder.models.size(); ++k)
        text += ladder_line(ladder, k, width);
    return text + "* with the inputs free within their uncertainties; all else with every input as "
                  "stated\n± is half of the 95 % interval\n\n";
}

/// Empty for a model in which nothing moves, because its parameters keep their initial values.
std::string model_parameters(const fit::Fit& fit) {
    std::string text;
    if (!fit.failed() && fit.moves())
        for (const auto& [key, parameter] : by_key(fit.parts.front().parameters))
            text +=
                fmt::format("    {:<40} {}\n", readable(*parameter).name, value_text(*parameter));
    return text;
}

} // namespace

std::size_t best_model(const diagnose::Ladder& ladder) {
    const auto best = std::find_if(ladder.models.rbegin(), ladder.models.rend(),
                                   [](const auto& model) { return model.is_gain; });
    return best == ladder.models.rend() ? 0
                                        : static_cast<std::size_t>(ladder.models.rend() - best) - 1;
}

const diagnose::LadderModel* last_fitted(const diagnose::Ladder& ladder) {
    const auto last = std::find_if(ladder.models.rbegin(), ladder.models.rend(),
                                   [](const auto& model) { return !model.fit.failed(); });
    return last == ladder.models.rend() ? nullptr : &*last;
}

std::string comparison_headline(const diagnose::Ladder& ladder, const std::string& measurement) {
    const std::size_t best = best_model(ladder);
    if (ladder.models[best].fit.failed())
        return fmt::format("The published chain could not be fitted to {}.", measurement);
    const diagnose::Finding finding = comparison_of(ladder, best).verdict.finding;
    if (finding == diagnose::Finding::Undecided)
        return fmt::format("{} is too short, too small or too noisy to decide whether the model is "
                           "adequate.",
                           measurement);
    const bool is_adequate = finding == diagnose::Finding::Adequate;
    if (best == 0)
        return is_adequate
                   ? fmt::format("The published chain explains {} to its noise.", measurement)
                   : fmt::format("The published chain is inadequate for {}.", measurement);
    std::vector<std::string> effects = ladder.models[best].fit.names();
    effects.erase(effects.begin()); // the baseline
    return fmt::format("The published chain is inadequate for {}; with {} it {}.", measurement,
                       fmt::join(effects, " and "),
                       is_adequate ? "is adequate" : "fits better, but is still inadequate");
}

std::vector<std::string> step_sentences(const diagnose::Ladder& ladder, std::size_t k) {
    const diagnose::LadderModel& model = ladder.models[k];
    const std::string added = fmt::format("{}", fmt::join(model.added, " and "));
    if (model.fit.failed())
        return {fmt::format("{} could not be fitted.", added)};
    const bool is_one = model.added.size() == 1;
    const std::vector<std::string> smaller = ladder.models[model.compared_with].fit.names();
    std::vector<std::string> sentences{
        fmt::format("{}{} {} {}{}.", added, is_one ? "" : " together",
                    model.is_gain ? (is_one ? "improves on" : "improve on")
                                  : (is_one ? "does not improve on" : "do not improve on"),
                    smaller.size() == 1 ? std::string("the baseline") : model_name(smaller),
                    model.why.empty() ? std::string() : ": " + model.why)};
    if (model.modulus_change != 0.0)
        sentences.push_back(fmt::format("Y changes by {:+.2f} %, beta by {:+.2f} %.",
                                        100.0 * model.modulus_change,
                                        100.0 * model.damping_change));
    return sentences;
}

std::vector<std::string> comparison_sentences(const Comparison& comparison) {
    std::vector<std::string> sentences{whether_it_fits(comparison)};
    if (!comparison.moves) {
        sentences.emplace_back("Nothing in this model moves a stem that was held straight: the "
                               "residual is the whole measured motion; add gravity.");
        return sentences;
    }
    if (comparison.verdict.finding == Finding::Adequate) {
        sentences.emplace_back(
            comparison.over_noise > explained_by_noise
                ? "The uncertainty of the stated inputs explains what exceeds the noise."
                : "The residuals are noise at every height, time and frequency.");
        return sentences;
    }
    if (comparison.verdict.finding == Finding::Undecided)
        return sentences;
    if (std::string where = where_it_fails(comparison); !where.empty())
        sentences.push_back(std::move(where));
    if (std::string backbone = backbone_sentence(comparison.backbones); !backbone.empty())
        sentences.push_back(std::move(backbone));
    return sentences;
}

std::string comparison_text(const diagnose::Ladder& ladder, const measure::Measurement& measurement,
                            const std::string& law, bool with_details) {
    const diagnose::LadderModel* last = last_fitted(ladder);
    std::string text = comparison_header(ladder, measurement, law) + ladder_lines(ladder);
    for (std::size_t k = 0; k < ladder.models.size(); ++k) {
        const diagnose::LadderModel& model = ladder.models[k];
        const bool is_shown = with_details || &model == last;
        if (k > 0)
            text += fmt::format("{}\n", fmt::join(step_sentences(ladder, k), "\n    "));
        else if (is_shown)
            text += "baseline:\n";
        if (is_shown)
            text += model_parameters(model.fit);
        for (std::size_t part = 0; is_shown && part < model.fit.parts.size(); ++part)
            for (const std::string& remark : remarks_on(model.fit.parts[part]))
                text += result_lines("    ", remark);
        if (const std::string said = contradiction_sentence(
                model.fit.pulls, !model.comparison || model.comparison->verdict.finding !=
                                                          diagnose::Finding::Inadequate);
            is_shown && !said.empty())
            text += result_lines("    ", said);
    }
    if (last == nullptr)
        return text;
    text += fmt::format("\n{}:\n", model_name(last->fit.names()));
    const auto place = static_cast<std::size_t>(last - ladder.models.data());
    for (const std::string& sentence : comparison_sentences(comparison_of(ladder, place)))
        text += result_lines("  ", sentence);
    return text;
}

} // namespace culm::present
