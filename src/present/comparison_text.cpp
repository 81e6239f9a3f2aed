// SPDX-License-Identifier: BSD-3-Clause
#include "fit/solve/residual_statistics.hpp"
#include "present/comparison.hpp"
#include "present/parameters.hpp"
#include "present/text.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace culm::present {
namespace {

using diagnose::Comparison;
using diagnose::Finding;
using residuals::ResidualStructure;
using residuals::SwingError;

constexpr double largest_relative_error = 0.25; ///< of a damping ratio that is quoted
constexpr double standard_errors = 3.0;         ///< of a difference that is mentioned
constexpr double explained_by_noise = 1.1;      ///< residual over noise
constexpr double smallest_swing = 3.0;          ///< amplitude over noise; below, the swing is over

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
    const auto band =
        std::ranges::max_element(comparison.spectrum.bands, {}, &fit::SpectrumBand::share);
    if (band != comparison.spectrum.bands.end() && band->share > 0.0)
        text += fmt::format("; {:.0f} % of its power lies {}{} ({:.3g} … {:.3g} Hz)",
                            100.0 * band->share, band->lower == 0.0 ? "" : "about ", band->name,
                            band->lower, band->upper);
    return text + ".";
}

/// " … early, … in the middle, … late", for the thirds for which `words` returns a text.
template <class Words>
std::string in_thirds(const ResidualStructure& structure, const Words& words) {
    static constexpr std::array<const char*, 3> places{"early", "in the middle", "late"};
    std::string text;
    for (std::size_t k = 0; k < structure.thirds.size(); ++k) {
        const std::string phrase = words(structure.thirds[k], places[k]);
        if (phrase.empty())
            continue;
        text += text.empty() ? " " : ", ";
        text += phrase;
    }
    return text;
}

bool has_died(double over_noise) {
    return over_noise < smallest_swing;
}

/// The model's amplitude relative to the measured one, in the thirds in which either swings.
std::string amplitude_words(const ResidualStructure& structure) {
    const auto words = [](const SwingError& error, const char* place) -> std::string {
        const bool has_stopped = has_died(error.measured_over_noise);
        if (has_stopped && has_died(error.modelled_over_noise))
            return {};
        if (std::abs(error.amplitude) < standard_errors * error.amplitude_error)
            return fmt::format("about right {}", place);
        if (has_stopped)
            return fmt::format("not yet zero {} (the stem rests)", place);
        const double measured_over_modelled = 1.0 + error.amplitude;
        if (measured_over_modelled < 0.1)
            return fmt::format("ten times too large or more {}", place);
        return fmt::format("{:.1f} % too {} {}",
                           100.0 * std::abs(1.0 / measured_over_modelled - 1.0),
                           error.amplitude < 0.0 ? "large" : "small", place);
    };
    const std::string thirds = in_thirds(structure, words);
    return thirds.empty() ? "amplitude error"
                          : "amplitude error: the model's amplitude is" + thirds;
}

/// Ends of the backbones of mode 1 where both are known well enough to be quoted.
struct BackboneEnds {
    reduce::BackbonePoint measured_first;
    reduce::BackbonePoint measured_last;
    reduce::BackbonePoint modelled_first;
    reduce::BackbonePoint modelled_last;
    std::string unit; ///< of the amplitudes, which are in thousandths of SI units
};

std::optional<BackboneEnds> backbone_ends(const residuals::BackbonesOfBoth& both) {
    if (both.measured.empty() || both.modelled.empty() || both.modelled.front().points.empty())
        return std::nullopt;
    std::vector<reduce::BackbonePoint> known;
    for (const reduce::BackbonePoint& point : both.measured.front().points)
        if (point.damping_error < largest_relative_error * std::abs(point.damping_ratio))
            known.push_back(point);
    if (known.size() < 2)
        return std::nullopt;
    return BackboneEnds{known.front(), known.back(), both.modelled.front().points.front(),
                        both.modelled.front().points.back(),
                        both.measured.front().is_strain ? "mm/m" : "mm"};
}

/// The change of the measured and of the modelled decay as the amplitude falls.
std::string decay_words(const Comparison& comparison) {
    const auto ends = backbone_ends(comparison.backbones);
    if (!ends)
        return {};
    return fmt::format("; from {:.2g} to {:.2g} {} of amplitude the measured damping ratio goes "
                       "from {:.4f} to {:.4f}, the modelled one from {:.4f} to {:.4f}",
                       1e3 * ends->measured_first.amplitude, 1e3 * ends->measured_last.amplitude,
                       ends->unit, ends->measured_first.damping_ratio,
                       ends->measured_last.damping_ratio, ends->modelled_first.damping_ratio,
                       ends->modelled_last.damping_ratio);
}

/// The phase lead or lag of the measured swing while both swing, in degrees (360 per cycle).
std::string phase_words(const Comparison& comparison) {
    const auto words = [](const SwingError& error, const char* place) -> std::string {
        if (has_died(error.measured_over_noise) || has_died(error.modelled_over_noise))
            return {};
        if (std::abs(error.lag) < standard_errors * error.lag_error)
            return fmt::format("in step {}", place);
        return fmt::format("{:.2f}° {} {}", std::abs(error.lag) * 180.0 / std::numbers::pi,
                           error.lag > 0.0 ? "behind" : "ahead", place);
    };
    const std::string thirds = in_thirds(comparison.structure, words);
    std::string text = thirds.empty() ? "phase error"
                                      : "phase error: against the model the measured swing is" +
                                            thirds + " (a cycle has 360°)";
    if (const auto ends = backbone_ends(comparison.backbones))
        text += fmt::format(
            "; as the amplitude falls from {:.2g} to {:.2g} {} the measured frequency goes from "
            "{:.2f} to {:.2f} Hz, the modelled one from {:.2f} to {:.2f} Hz",
            1e3 * ends->measured_first.amplitude, 1e3 * ends->measured_last.amplitude, ends->unit,
            ends->measured_first.frequency, ends->measured_last.frequency,
            ends->modelled_first.frequency, ends->modelled_last.frequency);
    return text;
}

std::string rest_words(const Comparison& comparison) {
    const auto rest = [&](std::size_t third) {
        return fmt::format("{:+.4f} {}",
                           comparison.unit.factor * comparison.structure.thirds[third].rest,
                           comparison.unit.name);
    };
    return fmt::format("an error of the rest position: measured minus modelled {} early, {} in the "
                       "middle, {} late",
                       rest(0), rest(1), rest(2));
}

/// Names the error in the shape over the heights, by its spectrum.
std::string shape_words(const Comparison& comparison) {
    const auto second = std::ranges::find(comparison.spectrum.bands, std::string("mode 2"),
                                          &fit::SpectrumBand::name);
    const bool is_second = second != comparison.spectrum.bands.end() && second->share > 0.5;
    return is_second ? "error of the second mode"
                     : "shape error: the stem bends at other heights than the model";
}

std::string what_it_is(const Comparison& comparison) {
    const ResidualStructure& structure = comparison.structure;
    struct Part {
        double share;
        std::string words;
    };
    std::array<Part, 5> parts{
        Part{structure.amplitude_share, amplitude_words(structure) + decay_words(comparison)},
        Part{structure.phase_share, phase_words(comparison)},
        Part{structure.rest_share, rest_words(comparison)},
        Part{structure.other_motion_share,
             "motion with the shape of the swing but another frequency"},
        Part{structure.other_shape_share, shape_words(comparison)}};
    std::ranges::stable_sort(parts, std::greater{}, &Part::share);
    std::string text = fmt::format("{:.0f} % of the remaining misfit is {}", 100.0 * parts[0].share,
                                   parts[0].words);
    if (parts[1].share > 0.2)
        text += fmt::format(". Another {:.0f} % is {}", 100.0 * parts[1].share, parts[1].words);
    return text + ".";
}

const diagnose::Comparison& comparison_of(const diagnose::Ladder& ladder, std::size_t model) {
    return *ladder.models[model].comparison;
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
    if (comparison.structure.excess_over_noise > 0.0)
        sentences.push_back(what_it_is(comparison));
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
