// SPDX-License-Identifier: BSD-3-Clause
#include "fit/solve/residual_statistics.hpp"
#include "present/comparison.hpp"
#include "present/parameters.hpp"
#include "present/text.hpp"

#include <algorithm>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace culm::present {
namespace {

const diagnose::Comparison& comparison_of(const diagnose::Ladder& ladder, std::size_t model) {
    return ladder.comparisons[*ladder.comparison[model]];
}

/// The uppermost model that could be fitted; null if none could.
const diagnose::LadderModel* last_fitted(const diagnose::Ladder& ladder) {
    const auto last = std::find_if(ladder.models.rbegin(), ladder.models.rend(),
                                   [](const auto& model) { return !model.fit.failed(); });
    return last == ladder.models.rend() ? nullptr : &*last;
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

std::string ladder_line(const diagnose::Ladder& ladder, std::size_t k, std::size_t width,
                        const TextStyle& style) {
    const diagnose::LadderModel& model = ladder.models[k];
    const std::string name = ladder_name(model, width);
    if (model.fit.failed())
        return fmt::format("{} {}: {}\n", name, style.failure("failed"), model.fit.reason);
    const diagnose::Comparison& comparison = comparison_of(ladder, k);
    const diagnose::Verdict& verdict = comparison.verdict;
    const bool is_noise_known = model.stated.is_noise_known_everywhere();
    return fmt::format("{} {:>9} {:>7} {:>10} {:>13}  {}\n", name,
                       number_cell(comparison.unit.factor * comparison.rmse, 4),
                       is_noise_known ? number_cell(comparison.over_noise, 2) : "-",
                       number_cell(verdict.reduced_chi_squared, 3),
                       k == 0 ? std::string() : fmt::format("{:+.0f}", model.log_evidence),
                       finding_text(verdict.finding, style));
}

std::string ladder_lines(const diagnose::Ladder& ladder, const TextStyle& style) {
    constexpr std::size_t width = 22;
    const auto first =
        std::ranges::find_if(ladder.comparison, &std::optional<std::size_t>::has_value);
    const std::string_view unit = first == ladder.comparison.end()
                                      ? measure::ReadingUnit{}.name
                                      : ladder.comparisons[**first].unit.name;
    std::string text = fmt::format("{:<{}} {:>9} {:>7} {:>10} {:>13}  {}\n", "model", width,
                                   fmt::format("rms {}", unit), "/noise", "red. chi2*",
                                   "log evidence*", "verdict*");
    for (std::size_t k = 0; k < ladder.models.size(); ++k)
        text += ladder_line(ladder, k, width, style);
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
    std::vector<std::string> effects = ladder.models[best].fit.names;
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
    const std::vector<std::string>& smaller = ladder.models[model.compared_with].fit.names;
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

std::string comparison_text(const diagnose::Ladder& ladder, const measure::Measurement& measurement,
                            const std::string& law, bool with_details, const TextStyle& style) {
    const diagnose::LadderModel* last = last_fitted(ladder);
    std::string text = comparison_header(ladder, measurement, law) + ladder_lines(ladder, style);
    for (std::size_t k = 0; k < ladder.models.size(); ++k) {
        const diagnose::LadderModel& model = ladder.models[k];
        const bool is_shown = with_details || &model == last;
        if (k > 0)
            text += fmt::format("{}\n", fmt::join(step_sentences(ladder, k), "\n    "));
        else if (is_shown)
            text += "baseline:\n";
        if (is_shown)
            text += model_parameters(model.stated);
        if (const std::string said = contradiction_sentence(model.fit.parameters);
            is_shown && !said.empty())
            text += result_lines("    ", said);
    }
    if (last == nullptr)
        return text;
    text += fmt::format("\n{}:\n", model_name(last->fit.names));
    const auto place = static_cast<std::size_t>(last - ladder.models.data());
    for (const std::string& sentence : comparison_sentences(comparison_of(ladder, place)))
        text += result_lines("  ", sentence);
    return text;
}

} // namespace culm::present
