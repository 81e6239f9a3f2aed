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

/// Is there a size from which on the effect would be detected?
bool is_detectable(const diagnose::EffectScore& blind_spot) {
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
            fmt::format("{}: {}, {} frames, noise {}\n", recording.stem.id,
                        counted(recording.heights.size(), "height"), recording.times.size(),
                        part.is_noise_known ? fmt::format("{} mm ({})", noise, part.noise_source)
                                            : fmt::format("not stated; residual {} mm", noise));
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

/// Relative error of a number of the baseline; NaN if one of the fits is missing.
double bias_of(const DiagnosisReport& report, double physics::StemParameters<double>::*member) {
    if (report.found.stated_baseline.parts.empty() || report.best_fit().parts.empty())
        return std::numeric_limits<double>::quiet_NaN();
    const auto value = [member](const fit::Fit& fit) {
        return fit.parts.front().model.spec.stem.*member;
    };
    return value(report.found.stated_baseline) / value(report.best_fit()) - 1.0;
}

/// What the missing effects did to the calibration, and what they explain.
std::string consequence_sentence(const DiagnosisReport& report) {
    const fit::Fit& first = report.found.ladder.front().stated;
    const fit::Fit& last = report.best_fit();
    std::string text =
        fmt::format("The residual falls from {} mm (rms) to {} mm; the noise is {} mm.",
                    number_cell(1e3 * first.rmse, 4), number_cell(1e3 * last.rmse, 4),
                    number_cell(1e3 * report.noise(), 4));
    const double modulus = bias_of(report, &physics::StemParameters<double>::bond_youngs_modulus);
    const double damping = bias_of(report, &physics::StemParameters<double>::bond_damping);
    // With known effects the first model is not the baseline, whose numbers these are.
    if (first.names.size() == 1 && first.moves() && std::isfinite(modulus) &&
        std::isfinite(damping))
        text += fmt::format(" Without {} the calibrated Y is off by {} and beta by {}.",
                            report.found.effects.size() == 1 ? "it" : "them", percent_text(modulus),
                            percent_text(damping));
    return text;
}

std::vector<std::string> sentences_on_named(const DiagnosisReport& report) {
    std::vector<std::string> sentences;
    for (const diagnose::TieGroup& tie : report.found.ties) {
        sentences.push_back(fmt::format(
            "This recording cannot distinguish between {}{}.", fmt::join(tie.names, " and "),
            tie.is_of_one_family ? "; the numbers are those of the first, as an estimate" : ""));
        if (!tie.separate_by.empty())
            sentences.push_back("To separate them: " + tie.separate_by);
    }
    sentences.push_back(consequence_sentence(report));
    return sentences;
}

std::vector<std::string> sentences_on_unknown(const diagnose::Diagnosis& found) {
    if (found.ladder.back().finding == diagnose::Finding::Undecided)
        return {};
    if (!found.missing_force || found.missing_force->form.empty())
        return {"No simple force law of position and velocity explains it either."};
    const diagnose::MissingForce& force = *found.missing_force;
    return {fmt::format("This {} explains {:.0f} % of the misfit{}; x is the deflection, v its "
                        "rate, kappa the curvature, in SI units:",
                        force.kind == "bending_moment" ? "bending moment" : "force per length",
                        100.0 * force.explained,
                        force.character.empty() ? "" : fmt::format(" ({})", force.character)),
            force.form};
}

std::string adequate_sentence(const DiagnosisReport& report) {
    const diagnose::Diagnosis& found = report.found;
    return fmt::format("The residual is {} mm (rms), the noise {} mm. {} of {} other effects would "
                       "be detected from the sizes below on.",
                       number_cell(1e3 * found.ladder.front().stated.rmse, 4),
                       number_cell(1e3 * report.noise(), 4),
                       std::ranges::count_if(found.blind_spots, is_detectable),
                       found.blind_spots.size());
}

/// "quadratic_drag", "material damping (relaxation or hysteretic_damping)".
std::vector<std::string> named_families(const diagnose::Diagnosis& found) {
    std::vector<std::string> names;
    for (const diagnose::NamedFamily& named : found.families)
        names.push_back(named.members.size() == 1
                            ? named.members.front()
                            : fmt::format("{} ({})", physics::to_string(named.family),
                                          fmt::join(named.members, " or ")));
    return names;
}

std::string diagnosis_headline(const diagnose::Diagnosis& found) {
    switch (found.conclusion) {
    case Conclusion::Adequate:
        return fmt::format("ADEQUATE: {} explains the recording.", first_model(found));
    case Conclusion::Unknown:
        return found.ladder.back().finding == diagnose::Finding::Undecided
                   ? std::string("UNKNOWN: this recording cannot decide whether the model is "
                                 "adequate.")
                   : fmt::format("UNKNOWN: the model is inadequate, and none of the {} candidates "
                                 "explains the misfit.",
                                 found.ranking.size());
    case Conclusion::Effect:
    case Conclusion::Tie:
        break;
    }
    std::vector<std::string> missing = named_families(found);
    for (const diagnose::TieGroup& tie : found.ties)
        if (!tie.is_of_one_family)
            missing.push_back(fmt::format("either {}", fmt::join(tie.names, " or ")));
    return fmt::format(
        "{}: {} {} missing from {}.", found.conclusion == Conclusion::Tie ? "TIE" : "EFFECT",
        fmt::join(missing, " and "), missing.size() == 1 ? "is" : "are", first_model(found));
}

/// What stands below the headline and the sizes of the effects.
std::vector<std::string> explanations(const DiagnosisReport& report) {
    std::vector<std::string> sentences;
    switch (report.found.conclusion) {
    case Conclusion::Adequate:
        sentences = {adequate_sentence(report)};
        break;
    case Conclusion::Unknown:
        sentences = sentences_on_unknown(report.found);
        break;
    case Conclusion::Effect:
    case Conclusion::Tie:
        sentences = sentences_on_named(report);
        break;
    }
    if (!report.found.reason.empty())
        sentences.push_back(fmt::format("Why: {}.", report.found.reason));
    if (std::string said = contradiction_sentence(report.found.final_fit.parameters); !said.empty())
        sentences.push_back(std::move(said));
    return sentences;
}

/// The effects that are named, with their sizes.
std::string effect_lines(const DiagnosisReport& report) {
    std::string text;
    for (const std::string& effect : report.found.effects) {
        if (const std::string summary = report.summary_of(effect); !summary.empty())
            text += wrapped("  " + effect + ": ", summary, diagnosis_width - effect.size());
        text += strength_lines(report, effect);
    }
    return text;
}

constexpr std::size_t listed_candidates = 5;
constexpr std::size_t listed_experiments = 3;

/// Below 1e-12 the asymptotic distributions of the tests mean nothing.
std::string probability(double p_value) {
    return !std::isfinite(p_value) ? "-"
           : p_value < 1e-12       ? "<1e-12"
                                   : fmt::format("{:.1e}", p_value);
}

/// A change of BIC; empty where there is none.
std::string change_cell(double delta_bic) {
    return std::isfinite(delta_bic) ? fmt::format("{:+.0f}", delta_bic) : std::string();
}

/// Root mean square of residual over noise in all recordings.
double over_noise(const fit::Fit& fit) {
    double sum = 0.0;
    double readings = 0.0;
    for (const fit::RecordingFit& part : fit.parts) {
        sum += std::pow(fit::over_noise(part), 2) * static_cast<double>(part.readings);
        readings += static_cast<double>(part.readings);
    }
    return std::sqrt(sum / readings);
}

std::string model_lines(const std::vector<diagnose::SearchedModel>& ladder,
                        const TextStyle& style) {
    std::size_t width = 17;
    for (const diagnose::SearchedModel& model : ladder)
        width = std::max(width, model_name(model.fit.names).size());
    std::string text =
        fmt::format("{:<{}} {:>9} {:>7} {:>10} {:>10} {:>13}  {}\n", "residual by model", width,
                    "rms mm", "/noise", "red. chi2*", "BIC*", "held out*", "verdict*");
    for (const diagnose::SearchedModel& model : ladder) {
        const bool is_first = &model == &ladder.front();
        const bool has_held_out =
            !is_first && model.held_out > 0.0 && std::isfinite(model.held_out);
        text += fmt::format(
            "{:<{}} {:>9} {:>7} {:>10} {:>10} {:>13}  {}\n", model_name(model.fit.names), width,
            number_cell(1e3 * model.stated.rmse, 4), number_cell(over_noise(model.stated), 2),
            number_cell(model.fit.reduced_chi_squared, 3),
            is_first ? std::string() : change_cell(model.delta_bic),
            has_held_out ? fmt::format("{} > {}", number_cell(model.held_out_before, 2),
                                       number_cell(model.held_out, 2))
                         : std::string(),
            finding_text(model.finding, style));
    }
    return text + "* with the inputs free within their uncertainties; all else with every input as "
                  "stated\n\n";
}

std::string remark_of(const diagnose::RankedEffect& ranked) {
    if (!ranked.obstacle.empty())
        return ranked.obstacle;
    return ranked.looks_like.empty()
               ? std::string()
               : fmt::format("hard to distinguish from {}", fmt::join(ranked.looks_like, ", "));
}

std::string candidate_line(const diagnose::RankedEffect& ranked) {
    return fmt::format("{:<24} {:>10} {:>9}  {}\n", ranked.effect,
                       (ranked.is_refitted ? "" : "~") + change_cell(ranked.delta_bic),
                       probability(ranked.p_value), remark_of(ranked));
}

/// The best candidates; all of them are in the JSON.
std::string candidate_lines(const std::vector<diagnose::RankedEffect>& ranking) {
    std::string text = fmt::format("{:<24} {:>10} {:>9}\n", "candidates, best first", "BIC*", "p*");
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

/// Bias: what an effect at its detection limit does to the calibrated Y and β.
std::string blind_spot_lines(const std::vector<diagnose::EffectScore>& spots) {
    if (spots.empty())
        return {};
    std::string text = fmt::format("{:<24} {:<38} {:>9} {:>9}\n", "blind spots",
                                   "detection limit (3 sigma)", "bias of Y", "of beta");
    std::vector<std::string> hidden;
    std::string failed;
    for (const diagnose::EffectScore& spot : spots) {
        if (is_detectable(spot))
            text += blind_spot_line(spot);
        else if (!spot.failure.empty())
            failed += wrapped(fmt::format("detection limit unknown: {}: ", spot.effect),
                              spot.failure, diagnosis_width - 20);
        else
            hidden.push_back(spot.effect);
    }
    if (!hidden.empty())
        text += fmt::format("undetectable at any size: {}\n", fmt::join(hidden, ", "));
    return text + failed + '\n';
}

/// With the upper end of the 95 % interval: no false positive in 200 draws does not mean never.
std::string false_positive_line(const diagnose::FalseNaming& naming) {
    if (naming.draws == 0)
        return "false-positive rate: not estimated\n";
    return fmt::format(
        "false-positive rate: {:.0f} of {} recordings simulated from this fit without "
        "any other effect ({:.1f} %, 95 %: at most {:.1f} %)\n",
        naming.rate * naming.draws, naming.draws, 100.0 * naming.rate, 100.0 * naming.upper_bound);
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

/// "would distinguish viscous_drag from hysteretic_damping", "would reveal taper …".
std::string what_it_shows(const diagnose::Experiment& experiment) {
    std::vector<std::string> distinguished;
    std::vector<std::string> revealed;
    for (const auto& [model, rival] : experiment.separates) {
        const std::vector<std::string> one = only_in(model, rival);
        const std::vector<std::string> other = only_in(rival, model);
        if (one.empty() || other.empty())
            revealed.push_back(fmt::format("{}", fmt::join(one.empty() ? other : one, " with ")));
        else
            distinguished.push_back(
                fmt::format("{} from {}", fmt::join(one, " with "), fmt::join(other, " with ")));
    }
    std::string text;
    if (!distinguished.empty())
        text = fmt::format("would distinguish {}", fmt::join(distinguished, ", "));
    if (!revealed.empty())
        text += fmt::format("{}would reveal {} at today's detection limit",
                            distinguished.empty() ? "" : "; ", fmt::join(revealed, ", "));
    return text;
}

/// The expected gap is the square of the distance in standard deviations.
std::string experiment_lines(const std::vector<diagnose::Experiment>& experiments) {
    std::string text =
        experiments.empty() ? "" : "suggested experiments, most informative first:\n";
    for (std::size_t k = 0; k < std::min(listed_experiments, experiments.size()); ++k)
        text += wrapped("  - ",
                        fmt::format("{}: {} with {:.0f} sigma", experiments[k].what,
                                    what_it_shows(experiments[k]),
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

std::vector<std::string> diagnosis_sentences(const DiagnosisReport& report) {
    std::vector<std::string> sentences{diagnosis_headline(report.found)};
    for (std::string& sentence : explanations(report))
        sentences.push_back(std::move(sentence));
    return sentences;
}

std::string diagnosis_text(const DiagnosisReport& report, const TextStyle& style) {
    const diagnose::Diagnosis& found = report.found;
    std::string text = diagnosis_header(report) + style.headline(diagnosis_headline(found)) + '\n' +
                       effect_lines(report);
    for (const std::string& sentence : explanations(report))
        text += wrapped("  ", sentence, diagnosis_width);
    return trimmed_lines(text + '\n' + model_lines(found.ladder, style) +
                         candidate_lines(found.ranking) + blind_spot_lines(found.blind_spots) +
                         false_positive_line(found.false_naming) +
                         experiment_lines(found.next_experiments));
}

} // namespace culm::present
