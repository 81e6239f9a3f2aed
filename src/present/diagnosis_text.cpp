// SPDX-License-Identifier: BSD-3-Clause
#include "fit/solve/residual_statistics.hpp"
#include "present/diagnosis.hpp"
#include "present/parameters.hpp"
#include "present/text.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace culm::present {
namespace {

using diagnose::Conclusion;

constexpr std::size_t diagnosis_width = 96; ///< characters of a line of running text

std::string sentence_lines(const std::string& text) {
    return wrapped("  ", text, diagnosis_width);
}

/// Has the blind spot a size from which on it would show?
bool is_visible(const diagnose::EffectScore& blind_spot) {
    return blind_spot.failure.empty() && !blind_spot.is_beyond_bounds &&
           std::isfinite(blind_spot.smallest_visible);
}

std::string diagnosis_header(const DiagnosisReport& report) {
    std::string text;
    for (std::size_t k = 0; k < report.recordings.size(); ++k) {
        const measure::Measurement& recording = report.recordings[k];
        const fit::RecordingFit& part = report.best_fit().parts[k];
        const std::string noise = number_cell(1e3 * fit::typical_noise(part), 4);
        text +=
            fmt::format("{}: {} heights, {} frames, noise {}\n", recording.stem.id,
                        recording.heights.size(), recording.times.size(),
                        part.is_noise_known ? fmt::format("{} mm ({})", noise, part.noise_source)
                                            : fmt::format("not known; {} mm is left", noise));
    }
    return text + '\n';
}

/// "the published chain", with what is known to act.
std::string first_model(const diagnose::Diagnosis& found) {
    std::vector<std::string> known = found.ladder.front().fit.names;
    known.erase(known.begin());
    return known.empty() ? std::string("the published chain")
                         : fmt::format("the published chain with {}", fmt::join(known, " and "));
}

/// Strength of the effect, with its interval: its numbers in the final model.
std::string strength_lines(const DiagnosisReport& report, const std::string& effect) {
    std::string text;
    for (const auto& [key, parameter] : by_key(report.parameters()))
        if (parameter->id.effect == effect)
            text += fmt::format("    {:<40} {}  (95 %)\n", key, value_text(*parameter));
    return text;
}

/// Where the model misses more than noise: what its numbers would be if that did not count.
std::string weighing_lines(const DiagnosisReport& report) {
    if (!report.found.correlated)
        return {};
    std::string text = "What the model misses is alike from frame to frame, and the numbers "
                       "above count it so.";
    std::vector<std::string> counted;
    for (const auto& [key, parameter] : by_key(report.best_fit().parameters))
        if (parameter->id.is_of_effect())
            counted.push_back(fmt::format("{} = {}", key, number_cell(parameter->value, 4)));
    if (!counted.empty())
        text += fmt::format(" Were every reading independent: {}.", fmt::join(counted, ", "));
    return sentence_lines(text);
}

/// Relative error of a number of the baseline; NaN if one of the models does not have it.
double bias_of(const DiagnosisReport& report, const physics::ParameterId& id) {
    const auto value = [&id](const std::vector<fit::FittedParameter>& parameters) {
        const auto found = std::ranges::find(parameters, id, &fit::FittedParameter::id);
        return found == parameters.end() ? std::numeric_limits<double>::quiet_NaN() : found->value;
    };
    return value(report.found.baseline.parameters) / value(report.parameters()) - 1.0;
}

/// What the missing effects did to the calibration, and what they explain.
std::string consequence_lines(const DiagnosisReport& report) {
    const fit::Fit& first = report.found.ladder.front().fit;
    const fit::Fit& last = report.found.ladder.back().fit;
    std::string text =
        fmt::format("The error falls from {} mm (rms) to {} mm; the noise is {} mm.",
                    number_cell(1e3 * first.rmse, 4), number_cell(1e3 * last.rmse, 4),
                    number_cell(1e3 * report.noise(), 4));
    const double modulus = bias_of(report, physics::bond_youngs_modulus);
    const double damping = bias_of(report, physics::bond_damping);
    // With known effects the first model is not the baseline, whose numbers these are.
    if (first.names.size() == 1 && std::isfinite(modulus) && std::isfinite(damping))
        text += fmt::format(" Without {} the calibrated Y was off by {} and beta by {}.",
                            report.found.effects.size() == 1 ? "it" : "them", percent_text(modulus),
                            percent_text(damping));
    return sentence_lines(text);
}

std::string tie_lines(const std::vector<diagnose::TieGroup>& ties) {
    std::string text;
    for (const diagnose::TieGroup& tie : ties) {
        text += sentence_lines(
            fmt::format("This recording cannot tell {} apart.", fmt::join(tie.names, " and ")));
        if (!tie.separate_by.empty())
            text += wrapped("    to separate them: ", tie.separate_by, diagnosis_width - 20);
    }
    return text;
}

std::string named_lines(const DiagnosisReport& report) {
    const diagnose::Diagnosis& found = report.found;
    const bool is_tie = found.conclusion == Conclusion::Tie;
    std::string text = fmt::format("{}: {} {} missing from {}.\n", is_tie ? "TIE" : "EFFECT",
                                   fmt::join(found.effects, " and "),
                                   is_tie                      ? "or a look-alike is"
                                   : found.effects.size() == 1 ? "is"
                                                               : "are",
                                   first_model(found));
    for (const std::string& effect : found.effects) {
        if (const std::string summary = report.summary_of(effect); !summary.empty())
            text += wrapped("  " + effect + ": ", summary, diagnosis_width - effect.size());
        text += strength_lines(report, effect);
    }
    return text + weighing_lines(report) + tie_lines(found.ties) + consequence_lines(report);
}

std::string unknown_lines(const diagnose::Diagnosis& found) {
    if (found.ladder.back().finding == diagnose::Finding::Undecided)
        return "UNKNOWN: this recording cannot tell whether anything is missing.\n";
    const std::string text =
        fmt::format("UNKNOWN: something is missing that none of the {} candidates explains.\n",
                    found.ranking.size());
    if (!found.missing_force || found.missing_force->form.empty())
        return text + sentence_lines("No simple force of position and speed explains it either.");
    const diagnose::MissingForce& force = *found.missing_force;
    return text +
           sentence_lines(fmt::format(
               "This {} explains {:.0f} % of the misfit{}; x is the deflection, v its rate, kappa "
               "the curvature, in SI units:",
               force.kind == "bending_moment" ? "bending moment" : "force per length",
               100.0 * force.explained,
               force.character.empty() ? "" : fmt::format(" ({})", force.character))) +
           fmt::format("    {}\n", force.form);
}

std::string adequate_lines(const DiagnosisReport& report) {
    const diagnose::Diagnosis& found = report.found;
    return fmt::format("ADEQUATE: {} explains the recording.\n", first_model(found)) +
           sentence_lines(fmt::format(
               "It leaves {} mm (rms), the noise is {} mm. Of {} other effects {} would have shown "
               "from the sizes below on.",
               number_cell(1e3 * found.ladder.front().fit.rmse, 4),
               number_cell(1e3 * report.noise(), 4), found.blind_spots.size(),
               std::ranges::count_if(found.blind_spots, is_visible)));
}

std::string verdict_lines(const DiagnosisReport& report) {
    switch (report.found.conclusion) {
    case Conclusion::Adequate:
        return adequate_lines(report);
    case Conclusion::Unknown:
        return unknown_lines(report.found);
    case Conclusion::Effect:
    case Conclusion::Tie:
        break;
    }
    return named_lines(report);
}

constexpr std::size_t listed_candidates = 5;
constexpr std::size_t listed_experiments = 3;

std::string probability(double p_value) {
    return !std::isfinite(p_value) ? "-"
           : p_value < 1e-12       ? "<1e-12"
                                   : fmt::format("{:.1e}", p_value);
}

/// A change of BIC; empty where there is none.
std::string change_cell(double delta_bic) {
    return std::isfinite(delta_bic) ? fmt::format("{:+.0f}", delta_bic) : std::string();
}

std::string model_lines(const std::vector<diagnose::DiagnosisRung>& ladder,
                        const TextStyle& style) {
    std::size_t width = 15;
    for (const diagnose::DiagnosisRung& rung : ladder)
        width = std::max(width, model_name(rung.fit.names).size());
    std::string text = fmt::format("{:<{}} {:>9} {:>10} {:>10} {:>11}  {}\n", "the error falls",
                                   width, "rms mm", "red. chi2", "BIC", "held out", "");
    for (const diagnose::DiagnosisRung& rung : ladder) {
        const bool is_first = &rung == &ladder.front();
        const bool has_held_out = !is_first && rung.held_out > 0.0 && std::isfinite(rung.held_out);
        text += fmt::format(
            "{:<{}} {:>9} {:>10} {:>10} {:>11}  {}\n", model_name(rung.fit.names), width,
            number_cell(1e3 * rung.fit.rmse, 4), number_cell(rung.fit.reduced_chi_squared, 3),
            is_first ? std::string() : change_cell(rung.delta_bic),
            has_held_out ? fmt::format("{} > {}", number_cell(rung.held_out_before, 2),
                                       number_cell(rung.held_out, 2))
                         : std::string(),
            finding_text(rung.finding, style));
    }
    return text + '\n';
}

std::string remark_of(const diagnose::RankedEffect& ranked) {
    if (!ranked.obstacle.empty())
        return ranked.obstacle;
    return ranked.looks_like.empty()
               ? std::string()
               : fmt::format("looks like {}", fmt::join(ranked.looks_like, ", "));
}

std::string candidate_line(const diagnose::RankedEffect& ranked) {
    return fmt::format(
        "{:<24} {:>9} {:>10} {:>9}  {}\n", ranked.effect,
        fmt::format("{}{}", ranked.is_refitted ? "" : "~", number_cell(1e3 * ranked.rmse, 4)),
        change_cell(ranked.delta_bic), probability(ranked.p_value), remark_of(ranked));
}

std::string candidate_lines(const std::vector<diagnose::RankedEffect>& ranking) {
    std::string text =
        fmt::format("{:<24} {:>9} {:>10} {:>9}\n", "candidates, best first", "rms mm", "BIC", "p");
    std::size_t fitted = 0;
    std::string failed;
    for (const diagnose::RankedEffect& ranked : ranking) {
        const bool has_fit_failed = ranked.is_refitted && ranked.fit.failed();
        if (!has_fit_failed && ++fitted <= listed_candidates)
            text += candidate_line(ranked);
        if (const std::string reason = failure_of(ranked); !reason.empty())
            failed +=
                wrapped(fmt::format("failed: {}: ", ranked.effect), reason, diagnosis_width - 20);
    }
    if (fitted > listed_candidates)
        text += fmt::format("and {} more\n", fitted - listed_candidates);
    return text + failed + '\n';
}

std::string blind_spot_line(const diagnose::EffectScore& spot) {
    return fmt::format("{:<24} {:<38} {:>9} {:>9}\n", spot.effect,
                       fmt::format("{} {:.2g}{}{}", spot.parameter, spot.smallest_visible,
                                   spot.unit.empty() ? "" : " ", spot.unit),
                       percent_text(spot.youngs_modulus_bias), percent_text(spot.damping_bias));
}

std::string blind_spot_lines(const std::vector<diagnose::EffectScore>& spots) {
    if (spots.empty())
        return {};
    std::string text = fmt::format("{:<24} {:<38} {:>9} {:>9}\n", "blind spots",
                                   "visible at (3 sigma)", "bias of Y", "of beta");
    std::vector<std::string> hidden;
    std::string failed;
    for (const diagnose::EffectScore& spot : spots) {
        if (is_visible(spot))
            text += blind_spot_line(spot);
        else if (!spot.failure.empty())
            failed += wrapped(fmt::format("not known: {}: ", spot.effect), spot.failure,
                              diagnosis_width - 20);
        else
            hidden.push_back(spot.effect);
    }
    if (!hidden.empty())
        text += fmt::format("at no possible size: {}\n", fmt::join(hidden, ", "));
    return text + failed + '\n';
}

std::string false_naming_line(const diagnose::FalseNaming& naming) {
    if (naming.draws == 0)
        return "false naming: not estimated\n";
    return fmt::format("false naming: {:.0f} of {} recordings simulated from this fit without any "
                       "other effect ({:.1f} %, 95 %: at most {:.1f} %)\n",
                       naming.rate * naming.draws, naming.draws, 100.0 * naming.rate,
                       100.0 * naming.upper_bound);
}

/// Effects of one model that the other does not have; models are names with " + " between them.
std::vector<std::string> only_in(const std::string& model, const std::string& other) {
    constexpr std::string_view between = " + ";
    const auto parts = [&between](const std::string& text) {
        std::vector<std::string> names;
        std::size_t begin = 0;
        for (std::size_t end = 0; end != std::string::npos; begin = end + between.size()) {
            end = text.find(between, begin);
            names.push_back(text.substr(begin, end - begin));
        }
        return names;
    };
    std::vector<std::string> names = parts(model);
    const std::vector<std::string> others = parts(other);
    std::erase_if(names, [&others](const std::string& name) {
        return std::ranges::find(others, name) != others.end();
    });
    return names;
}

/// "tells viscous_drag from hysteretic_damping", "shows taper or tip_mass".
std::string what_it_tells(const diagnose::Experiment& experiment) {
    std::vector<std::string> told;
    std::vector<std::string> shown;
    for (const auto& [model, rival] : experiment.separates) {
        const std::vector<std::string> one = only_in(model, rival);
        const std::vector<std::string> other = only_in(rival, model);
        if (one.empty() || other.empty())
            shown.push_back(fmt::format("{}", fmt::join(one.empty() ? other : one, " with ")));
        else
            told.push_back(
                fmt::format("{} from {}", fmt::join(one, " with "), fmt::join(other, " with ")));
    }
    std::string text;
    if (!told.empty())
        text = fmt::format("tells {}", fmt::join(told, ", "));
    if (!shown.empty())
        text += fmt::format("{}shows {} that would just be visible here", told.empty() ? "" : "; ",
                            fmt::join(shown, ", "));
    return text;
}

std::string experiment_lines(const std::vector<diagnose::Experiment>& experiments) {
    std::string text = experiments.empty() ? "" : "next experiments, the most telling first:\n";
    for (std::size_t k = 0; k < std::min(listed_experiments, experiments.size()); ++k)
        text += wrapped("  - ",
                        fmt::format("{}: {} ({:.0f} sigma)", experiments[k].what,
                                    what_it_tells(experiments[k]),
                                    std::sqrt(experiments[k].expected_gap)),
                        diagnosis_width);
    return text;
}

/// Without blanks at the ends of lines.
std::string trimmed_lines(const std::string& text) {
    std::string out;
    for (const char letter : text) {
        if (letter == '\n')
            out.erase(out.find_last_not_of(' ') + 1);
        out += letter;
    }
    return out;
}

} // namespace

std::string failure_of(const diagnose::RankedEffect& ranked) {
    if (ranked.is_refitted)
        return ranked.fit.failed() ? ranked.fit.reason : std::string();
    return ranked.obstacle; // without a fit it says why there is no score
}

double DiagnosisReport::noise() const {
    double sum = 0.0;
    for (const fit::RecordingFit& part : best_fit().parts)
        sum += std::pow(fit::typical_noise(part), 2);
    return std::sqrt(sum / static_cast<double>(best_fit().parts.size()));
}

std::string DiagnosisReport::summary_of(const std::string& effect) const {
    const auto candidate = std::ranges::find_if(
        candidates, [&effect](const auto& each) { return each.effect->name() == effect; });
    return candidate == candidates.end() ? std::string() : candidate->effect->summary();
}

std::string diagnosis_text(const DiagnosisReport& report, const TextStyle& style) {
    std::string text = diagnosis_header(report) + style.headline(verdict_lines(report));
    if (!report.found.reason.empty())
        text += wrapped("  why: ", report.found.reason, diagnosis_width - 5);
    const diagnose::Diagnosis& found = report.found;
    return trimmed_lines(text + '\n' + model_lines(found.ladder, style) +
                         candidate_lines(found.ranking) + blind_spot_lines(found.blind_spots) +
                         false_naming_line(found.false_naming) +
                         experiment_lines(found.next_experiments));
}

} // namespace culm::present
