// SPDX-License-Identifier: BSD-3-Clause
#include "fit/solve/residual_statistics.hpp"
#include "physics/bond_law_options.hpp"
#include "present/diagnosis.hpp"
#include "present/laboratory.hpp"
#include "present/parameters.hpp"
#include "present/text.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <ranges>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace culm::present {
namespace {

using diagnose::Conclusion;

/// Does the effect have a detection limit?
bool is_detectable(const diagnose::DetectionLimit& limit) {
    return limit.failure.empty() && !limit.is_beyond_bounds && std::isfinite(limit.value);
}

std::string diagnosis_header(const DiagnosisReport& report) {
    std::string text;
    for (std::size_t k = 0; k < report.recordings.size(); ++k) {
        const measure::Measurement& recording = report.recordings[k];
        const fit::RecordingFit& part = report.best_fit().parts[k];
        const std::string noise =
            measure::reading_unit(recording.sensors).text(fit::typical_noise(part));
        text += result_lines(
            "", fmt::format("{}: {}, {} frames, noise {}", recording.stem.id,
                            counted(recording.heights.size(), "height"), recording.times.size(),
                            part.is_noise_known ? fmt::format("{} ({})", noise, part.noise_source)
                                                : fmt::format("not stated; residual {}", noise)));
    }
    return text + '\n';
}

/// The effect's parameters in the final model, with their intervals.
std::string strength_lines(const DiagnosisReport& report, const std::string& effect) {
    std::string text;
    for (const auto& [key, parameter] : by_key(report.best_fit().parameters))
        if (parameter->id.effect == effect)
            text += fmt::format("    {:<40} {}  (95 %)\n", key, value_text(*parameter));
    return text;
}

/// "1.901 ± 0.013 GPa before, 1.900 ± 0.013 GPa after, a change of -0.039 %".
std::string before_and_after(const physics::ParameterId& id, const fit::Fit& before,
                             const fit::Fit& after) {
    const auto first = std::ranges::find(before.parameters, id, &fit::FittedParameter::id);
    const auto last = std::ranges::find(after.parameters, id, &fit::FittedParameter::id);
    if (before.names() == after.names())
        return value_text(*first);
    return fmt::format("{} before, {} after, a change of {}", value_text(*first), value_text(*last),
                       percent_text(last->value / first->value - 1.0));
}

/// The residual, Y and β before and after, and the unexplained part.
std::vector<std::string> consequence_sentences(const DiagnosisReport& report) {
    const diagnose::Diagnosis& found = *report.found;
    const fit::Fit& first = found.ladder.front().fit;
    const fit::Fit& last = report.best_fit();
    const measure::ReadingUnit unit = report.unit();
    std::string residual = unit.text(first.rmse);
    if (found.ladder.size() > 1)
        residual += fmt::format(" before, {} after", unit.text(last.rmse));
    std::vector<std::string> sentences{
        fmt::format("Residual (rms): {}; the noise is {}.", residual, unit.text(report.noise()))};
    if (first.moves()) {
        sentences.push_back("Y: " + before_and_after(physics::bond_youngs_modulus, first, last));
        sentences.push_back(fmt::format("beta (law {}): {}",
                                        physics::law_name(report.options->candidate.chain.law),
                                        before_and_after(physics::bond_damping, first, last)));
    }
    if (last.has_moved_inputs)
        sentences.emplace_back("All numbers are those with the inputs free within their "
                               "uncertainties: they contradict exact inputs.");
    sentences.push_back(fmt::format("Not explained: {}, {:.2g} % of the swing.",
                                    unit.text(found.unexplained, 2),
                                    100.0 * found.unexplained_share));
    for (const diagnose::ImmaterialEffect& effect : found.posterior.immaterial)
        sentences.push_back(fmt::format("Detectable, immaterial: {} explains {:.2g} times the "
                                        "noise.",
                                        effect.effect.first, effect.over_noise));
    return sentences;
}

std::vector<std::string> sentences_on_unknown(const diagnose::Diagnosis& found) {
    if (found.ladder.back().verdict.finding == diagnose::Finding::Undecided)
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

/// The sentences below the headline and the sizes of the effects.
std::vector<std::string> explanations(const DiagnosisReport& report) {
    const diagnose::Diagnosis& found = *report.found;
    std::vector<std::string> sentences;
    if (std::string far_off = far_off_sentence(over_noise(report.best_fit())); !far_off.empty())
        sentences.push_back(std::move(far_off));
    std::ranges::copy(explanation_sentences(found), std::back_inserter(sentences));
    if (found.conclusion == Conclusion::Unknown && found.ladder.size() > 1)
        sentences.push_back(fmt::format(
            "The best explanation, {}, accounts for {:.0f} % of the misfit.",
            explanation_name(found, found.alternatives.front().families), 100.0 * found.explained));
    std::ranges::copy(consequence_sentences(report), std::back_inserter(sentences));
    if (found.conclusion == Conclusion::Unknown) {
        sentences.push_back(fmt::format("Why: {}.", found.reason));
        std::ranges::copy(sentences_on_unknown(found), std::back_inserter(sentences));
    }
    if (!found.is_complete)
        sentences.push_back(
            fmt::format("The search ended after {} models; likelier ones may exist.",
                        found.posterior.models.size()));
    for (const fit::RecordingFit& part : report.best_fit().parts)
        std::ranges::copy(remarks_on(part), std::back_inserter(sentences));
    if (std::string said =
            contradiction_sentence(found.final_fit.pulls, found.conclusion != Conclusion::Unknown);
        !said.empty())
        sentences.push_back(std::move(said));
    return sentences;
}

/// The effects that are named, with their sizes.
std::string effect_lines(const DiagnosisReport& report) {
    std::string text;
    for (const std::string& effect : report.found->effects) {
        const auto answer =
            std::ranges::find(report.found->answers, effect, &diagnose::EffectAnswer::effect);
        const bool is_likeliest_law = std::ranges::any_of(
            report.found->alternatives.front().families, [&](const auto& named) {
                return named.is_open &&
                       std::ranges::find(named.members, effect) != named.members.end();
            });
        text += result_lines("  ", fmt::format("{}{}, probability {:.2f}: {}", effect,
                                               is_likeliest_law ? ", the likeliest law" : "",
                                               answer->probability, report.summary_of(effect)));
        text += strength_lines(report, effect);
    }
    return text;
}

std::string model_lines(const std::vector<diagnose::SearchedModel>& ladder,
                        const measure::ReadingUnit& unit) {
    std::size_t width = 17;
    for (const diagnose::SearchedModel& model : ladder)
        width = std::max(width, model_name(model.fit.names()).size());
    std::string text = fmt::format("{:<{}} {:>9} {:>7} {:>10} {:>13}  {}\n", "residual by model",
                                   width, fmt::format("rms {}", unit.name), "/noise", "red. chi2*",
                                   "log evidence*", "verdict*");
    for (const diagnose::SearchedModel& model : ladder)
        text += fmt::format(
            "{:<{}} {:>9} {:>7} {:>10} {:>13}  {}\n", model_name(model.fit.names()), width,
            number_cell(unit.factor * model.fit.rmse, 4), number_cell(over_noise(model.fit), 2),
            number_cell(model.fit.reduced_chi_squared, 3),
            &model == &ladder.front() ? std::string() : fmt::format("{:+.0f}", model.log_evidence),
            diagnose::to_string(model.verdict.finding));
    return text + "* with the inputs free within their uncertainties; all else with every input as "
                  "stated\n";
}

constexpr std::size_t listed_limits = 4;

/// Detection limits of the effects that are not in the answer, for those that bias Y or β most.
std::string detection_lines(const std::vector<diagnose::DetectionLimit>& limits) {
    std::vector<const diagnose::DetectionLimit*> detectable;
    std::vector<std::string> unknown;
    for (const diagnose::DetectionLimit& limit : limits)
        if (is_detectable(limit))
            detectable.push_back(&limit);
        else
            unknown.push_back(limit.effect);
    std::ranges::stable_sort(detectable, std::greater{}, [](const auto* limit) {
        return std::max(std::abs(limit->youngs_modulus_bias), std::abs(limit->damping_bias));
    });
    std::vector<std::string> sizes;
    for (const auto* limit : detectable | std::views::take(listed_limits))
        sizes.push_back(fmt::format("{} {:.2g}{}{} (Y {}, beta {})", limit->effect, limit->value,
                                    limit->unit.empty() ? "" : " ", limit->unit,
                                    percent_text(limit->youngs_modulus_bias),
                                    percent_text(limit->damping_bias)));
    std::string text;
    if (!sizes.empty())
        text += wrapped("detection limits (3 sigma): ", fmt::format("{}", fmt::join(sizes, ", ")),
                        result_width - 28);
    if (!unknown.empty())
        text += wrapped("not detectable: ", fmt::format("{}", fmt::join(unknown, ", ")),
                        result_width - 16);
    return text;
}

/// Models whose fit failed.
std::string failure_lines(const std::vector<diagnose::ModelProbability>& models) {
    std::string text;
    for (const diagnose::ModelProbability& model : models)
        if (!model.failure.empty())
            text +=
                wrapped(fmt::format("failed: {}: ", fmt::join(effect_names(model.effects), ", ")),
                        model.failure, result_width - 20);
    return text;
}

/// Effects of one model that the other does not have.
std::vector<std::string> only_in(std::vector<std::string> names,
                                 const std::vector<std::string>& others) {
    std::erase_if(names, [&others](const std::string& name) {
        return std::ranges::find(others, name) != others.end();
    });
    return names;
}

/// "would distinguish viscous_drag from hysteretic_damping", "would reveal taper …".
std::string what_it_shows(const diagnose::Experiment& experiment) {
    const std::vector<std::string> one = only_in(experiment.first_model, experiment.second_model);
    const std::vector<std::string> other = only_in(experiment.second_model, experiment.first_model);
    if (one.empty() || other.empty())
        return fmt::format("would reveal {} at today's detection limit",
                           fmt::join(one.empty() ? other : one, " with "));
    return fmt::format("would distinguish {} from {}", fmt::join(one, " with "),
                       fmt::join(other, " with "));
}

/// The most informative one. Its expected gap is the square of a distance in standard deviations.
std::string experiment_lines(const std::vector<diagnose::Experiment>& experiments) {
    if (experiments.empty() || experiments.front().expected_gap < 1.0)
        return {};
    constexpr double most_sigma = 10.0; // errors of the models count from there on
    const diagnose::Experiment& best = experiments.front();
    const double sigma = std::sqrt(best.expected_gap);
    return wrapped("next experiment: ",
                   fmt::format("{}: {} with {} sigma", best.what, what_it_shows(best),
                               sigma > most_sigma ? fmt::format("more than {:.0f}", most_sigma)
                                                  : fmt::format("{:.0f}", sigma)),
                   result_width - 17);
}

/// Removes blanks at the ends of lines.
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

measure::ReadingUnit DiagnosisReport::unit() const {
    std::vector<measure::Sensor> sensors;
    for (const measure::Measurement& recording : recordings) {
        if (recording.sensors.empty())
            sensors.emplace_back();
        sensors.insert(sensors.end(), recording.sensors.begin(), recording.sensors.end());
    }
    return measure::reading_unit(sensors);
}

double DiagnosisReport::noise() const {
    double sum = 0.0;
    for (const fit::RecordingFit& part : best_fit().parts)
        sum += std::pow(fit::typical_noise(part), 2);
    return std::sqrt(sum / static_cast<double>(best_fit().parts.size()));
}

std::string DiagnosisReport::summary_of(const std::string& effect) const {
    const std::size_t place = options->place_of(effect);
    return place < options->candidates.size() ? options->candidates[place].effect->summary : "";
}

std::vector<std::string> diagnosis_sentences(const DiagnosisReport& report) {
    std::vector<std::string> sentences{diagnosis_headline(*report.found)};
    std::ranges::copy(explanations(report), std::back_inserter(sentences));
    return sentences;
}

std::string diagnosis_text(const DiagnosisReport& report, bool with_details) {
    const diagnose::Diagnosis& found = *report.found;
    if (found.stems.size() > 1)
        return laboratory_text(found, with_details);
    std::string text =
        diagnosis_header(report) + diagnosis_headline(found) + '\n' + effect_lines(report);
    for (const std::string& sentence : explanations(report))
        text += result_lines("  ", sentence);
    text += '\n';
    if (with_details)
        text += model_lines(found.ladder, report.unit());
    // Without an effect the question is which effects could be there unseen.
    if (with_details || found.effects.empty())
        text += detection_lines(found.detection_limits);
    return trimmed_lines(text + failure_lines(found.posterior.models) +
                         experiment_lines(found.next_experiments));
}

} // namespace culm::present
