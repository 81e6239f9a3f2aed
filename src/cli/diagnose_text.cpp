// SPDX-License-Identifier: BSD-3-Clause
#include "cli/diagnose_text.hpp"

#include "cli/diagnose_tables.hpp"
#include "cli/json_cell.hpp"
#include "cli/next_step.hpp"
#include "cli/parameter_text.hpp"
#include "present/text.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include <fmt/format.h>

namespace culm::cli {
namespace {

using nlohmann::json;

std::string sentence(const std::string& text) {
    return present::wrapped("  ", text, diagnosis_width);
}

std::string header(const json& found) {
    std::string text;
    for (const json& recording : found["recordings"])
        text += fmt::format(
            "{}: {} heights, {} frames, noise {}\n", recording["id"].get<std::string>(),
            recording["heights"].get<int>(), recording["frames"].get<int>(),
            recording["noise_known"].get<bool>()
                ? fmt::format("{} mm ({})", json_cell(recording["noise_mm"], 4),
                              recording["noise_source"].get<std::string>())
                : fmt::format("not known; {} mm is left", json_cell(recording["noise_mm"], 4)));
    return text + '\n';
}

/// "the published chain", with what is known to act.
std::string first_model(const json& found) {
    std::vector<std::string> known = found["ladder"].front()["model"];
    known.erase(known.begin());
    return known.empty() ? std::string("the published chain")
                         : fmt::format("the published chain with {}", fmt::join(known, " and "));
}

std::string summary_of(const json& found, const std::string& effect) {
    for (const json& ranked : found["ranking"])
        if (ranked["effect"] == effect)
            return ranked["summary"].get<std::string>();
    return {};
}

/// Strength of the effect, with its interval: its numbers in the final model.
std::string strength_lines(const json& found, const std::string& effect) {
    std::string text;
    for (const auto& [key, parameter] : found["parameters"].items())
        if (key.starts_with(effect + "."))
            text += fmt::format("    {:<40} {}  (95 %)\n", key, value_text(key, parameter));
    return text;
}

/// Where the model misses more than noise: what its numbers would be if that did not count.
std::string weighing_lines(const json& found) {
    if (found["correlated_misses"].is_null())
        return {};
    std::string text = "What the model misses is alike from frame to frame, and the numbers "
                       "above count it so.";
    std::vector<std::string> counted;
    for (const auto& [key, parameter] : found["correlated_misses"]["least_squares"].items())
        if (key.find('.') != std::string::npos)
            counted.push_back(fmt::format("{} = {}", key, json_cell(parameter["value"], 4)));
    if (!counted.empty())
        text += fmt::format(" Were every reading independent: {}.", joined(counted, ", "));
    return sentence(text);
}

/// What the missing effects did to the calibration, and what they explain.
std::string consequence(const json& found) {
    const json& first = found["ladder"].front();
    const json& last = found["ladder"].back();
    std::string text = fmt::format("The error falls from {} mm (rms) to {} mm; the noise is {} mm.",
                                   json_cell(first["rmse_mm"], 4), json_cell(last["rmse_mm"], 4),
                                   json_cell(found["noise_mm"], 4));
    if (first["model"].size() > 1) // the calibration with what is known is not among the results
        return sentence(text);
    const auto bias = [&found](const char* key) {
        const json& before = found["baseline"]["parameters"];
        const json& after = found["parameters"];
        return before.contains(key) && after.contains(key)
                   ? number_in_json(before[key]["value"]) / number_in_json(after[key]["value"]) -
                         1.0
                   : std::numeric_limits<double>::quiet_NaN();
    };
    const double modulus = bias("bond_youngs_modulus_pa");
    const double damping = bias("bond_damping");
    if (std::isfinite(modulus) && std::isfinite(damping))
        text += fmt::format(" Without {} the calibrated Y was off by {} and beta by {}.",
                            found["effects"].size() == 1U ? "it" : "them",
                            present::percent_text(modulus), present::percent_text(damping));
    return sentence(text);
}

std::string tie_lines(const json& found) {
    std::string text;
    for (std::size_t k = 0; k < found["ties"].size(); ++k) {
        text += sentence(
            fmt::format("This recording cannot tell {} apart.", joined(found["ties"][k], " and ")));
        if (const std::string by = found["ties_separate_by"][k]; !by.empty())
            text += present::wrapped("    to separate them: ", by, diagnosis_width - 20);
    }
    return text;
}

std::string named_lines(const json& found) {
    const bool is_tie = found["verdict"] == "tie";
    std::string text = fmt::format("{}: {} {} missing from {}.\n", is_tie ? "TIE" : "EFFECT",
                                   joined(found["effects"], " and "),
                                   is_tie                          ? "or a look-alike is"
                                   : found["effects"].size() == 1U ? "is"
                                                                   : "are",
                                   first_model(found));
    for (const std::string effect : found["effects"]) {
        if (const std::string summary = summary_of(found, effect); !summary.empty())
            text +=
                present::wrapped("  " + effect + ": ", summary, diagnosis_width - effect.size());
        text += strength_lines(found, effect);
    }
    return text + weighing_lines(found) + tie_lines(found) + consequence(found);
}

std::string unknown_lines(const json& found) {
    if (found["ladder"].back()["finding"] == "undecided")
        return "UNKNOWN: this recording cannot tell whether anything is missing.\n";
    std::string text = fmt::format("UNKNOWN: something is missing that none of the {} candidates "
                                   "explains.\n",
                                   found["ranking"].size());
    const json& force = found["missing_force"];
    if (force.is_null() || force["form"].get<std::string>().empty())
        return text + sentence("No simple force of position and speed explains it either.");
    const bool is_moment = force["kind"] == "bending_moment";
    const std::string character = force["character"];
    text += sentence(
        fmt::format("This {} explains {:.0f} % of the misfit{}; x is the deflection, v its "
                    "rate, kappa the curvature, in SI units:",
                    is_moment ? "bending moment" : "force per length",
                    100.0 * number_in_json(force["explained"]),
                    character.empty() ? "" : fmt::format(" ({})", character)));
    return text + fmt::format("    {}\n", force["form"].get<std::string>());
}

std::string adequate_lines(const json& found) {
    const json& first = found["ladder"].front();
    const auto visible = std::ranges::count_if(found["blind_spots"], is_visible);
    return fmt::format("ADEQUATE: {} explains the recording.\n", first_model(found)) +
           sentence(fmt::format("It leaves {} mm (rms), the noise is {} mm. Of {} other effects {} "
                                "would have shown from the sizes below on.",
                                json_cell(first["rmse_mm"], 4), json_cell(found["noise_mm"], 4),
                                found["blind_spots"].size(), visible));
}

std::string verdict_lines(const json& found, const TextStyle& style) {
    const std::string verdict = found["verdict"];
    std::string text = style.headline(verdict == "adequate"  ? adequate_lines(found)
                                      : verdict == "unknown" ? unknown_lines(found)
                                                             : named_lines(found));
    if (const std::string reason = found["reason"]; !reason.empty())
        text += present::wrapped("  why: ", reason, diagnosis_width - 5);
    return text + '\n';
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

std::string diagnosis_text(const json& diagnosis, const std::string& next_command,
                           const TextStyle& style) {
    return trimmed_lines(header(diagnosis) + verdict_lines(diagnosis, style) +
                         error_ladder_lines(diagnosis, style) + ranking_lines(diagnosis) +
                         blind_spot_lines(diagnosis) + false_naming_line(diagnosis) +
                         experiment_lines(diagnosis) + next_step(next_command));
}

} // namespace culm::cli
