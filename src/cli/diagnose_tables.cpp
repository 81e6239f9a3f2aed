// SPDX-License-Identifier: BSD-3-Clause
#include "cli/diagnose_tables.hpp"

#include "cli/json_cell.hpp"
#include "present/text.hpp"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <vector>

namespace culm::cli {
namespace {

using nlohmann::json;

constexpr std::size_t listed_candidates = 5;
constexpr std::size_t listed_experiments = 3;

std::string probability(const json& value) {
    const double p_value = number_in_json(value);
    return std::isnan(p_value) ? "-" : p_value < 1e-12 ? "<1e-12" : fmt::format("{:.1e}", p_value);
}

std::string remark_of(const json& ranked) {
    if (const std::string obstacle = ranked["obstacle"]; !obstacle.empty())
        return obstacle;
    return ranked["looks_like"].empty() ? std::string()
                                        : "looks like " + joined(ranked["looks_like"], ", ");
}

std::string blind_spot_line(const json& spot) {
    const json& size = spot["smallest_visible"];
    const std::string unit = size["unit"];
    return fmt::format("{:<24} {:<38} {:>9} {:>9}\n", spot["effect"].get<std::string>(),
                       fmt::format("{} {:.2g}{}{}", size["parameter"].get<std::string>(),
                                   number_in_json(size["value"]), unit.empty() ? "" : " ", unit),
                       present::percent_text(number_in_json(spot["bias"]["bond_youngs_modulus"])),
                       present::percent_text(number_in_json(spot["bias"]["bond_damping"])));
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
std::string what_it_tells(const json& pairs) {
    std::vector<std::string> told;
    std::vector<std::string> shown;
    for (const json& pair : pairs) {
        const std::vector<std::string> one = only_in(pair[0], pair[1]);
        const std::vector<std::string> other = only_in(pair[1], pair[0]);
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

} // namespace

bool is_visible(const json& spot) {
    return spot.contains("smallest_visible") && !spot["beyond_bounds"].get<bool>() &&
           spot["smallest_visible"]["value"].is_number();
}

std::string error_ladder_lines(const json& found, const TextStyle& style) {
    std::size_t width = 8;
    for (const json& rung : found["ladder"])
        width = std::max(width, joined(rung["model"], " + ").size());
    std::string text =
        fmt::format("{:<{}} {:>9} {:>10} {:>10} {:>11}  {}\n", "the error falls",
                    std::max<std::size_t>(width, 15), "rms mm", "red. chi2", "BIC", "held out", "");
    width = std::max<std::size_t>(width, 15);
    for (const json& rung : found["ladder"]) {
        const bool is_first = !rung.contains("delta_bic");
        const std::string finding = rung["finding"];
        text += fmt::format(
            "{:<{}} {:>9} {:>10} {:>10} {:>11}  {}\n", joined(rung["model"], " + "), width,
            json_cell(rung["rmse_mm"], 4), json_cell(rung["reduced_chi2"], 3),
            is_first ? "" : fmt::format("{:+.0f}", number_in_json(rung["delta_bic"])),
            is_first || rung["held_out_over_noise"].is_null()
                ? ""
                : fmt::format("{} > {}", json_cell(rung["held_out_before_over_noise"], 2),
                              json_cell(rung["held_out_over_noise"], 2)),
            style.finding(finding == "adequate"     ? "fits"
                          : finding == "inadequate" ? "something is missing"
                                                    : "cannot tell"));
    }
    return text + '\n';
}

std::string ranking_lines(const json& found) {
    std::string text =
        fmt::format("{:<24} {:>9} {:>10} {:>9}\n", "candidates, best first", "rms mm", "BIC", "p");
    std::size_t listed = 0;
    std::size_t fitted = 0;
    for (const json& ranked : found["ranking"]) {
        if (ranked.contains("failure"))
            continue;
        ++fitted;
        if (listed == listed_candidates)
            continue;
        ++listed;
        text += fmt::format("{:<24} {:>9} {:>10} {:>9}  {}\n", ranked["effect"].get<std::string>(),
                            fmt::format("{}{}", ranked["refitted"].get<bool>() ? "" : "~",
                                        json_cell(ranked["rmse_mm"], 4)),
                            ranked["delta_bic"].is_null()
                                ? ""
                                : fmt::format("{:+.0f}", number_in_json(ranked["delta_bic"])),
                            probability(ranked["p_value"]), remark_of(ranked));
    }
    if (fitted > listed)
        text += fmt::format("and {} more\n", fitted - listed);
    for (const json& failed : found["failed"])
        text += present::wrapped(fmt::format("failed: {}: ", failed["effect"].get<std::string>()),
                                 failed["reason"].get<std::string>(), diagnosis_width - 20);
    return text + '\n';
}

std::string blind_spot_lines(const json& found) {
    if (found["blind_spots"].empty())
        return {};
    std::string text = fmt::format("{:<24} {:<38} {:>9} {:>9}\n", "blind spots",
                                   "visible at (3 sigma)", "bias of Y", "of beta");
    std::vector<std::string> hidden;
    std::string failed;
    for (const json& spot : found["blind_spots"]) {
        const std::string effect = spot["effect"];
        if (is_visible(spot))
            text += blind_spot_line(spot);
        else if (spot.contains("failure"))
            failed += present::wrapped(fmt::format("not known: {}: ", effect),
                                       spot["failure"].get<std::string>(), diagnosis_width - 20);
        else
            hidden.push_back(effect);
    }
    if (!hidden.empty())
        text += fmt::format("at no possible size: {}\n", fmt::join(hidden, ", "));
    return text + failed + '\n';
}

std::string false_naming_line(const json& found) {
    const json& naming = found["false_naming"];
    const int draws = naming["draws"];
    if (draws == 0)
        return "false naming: not estimated\n";
    return fmt::format("false naming: {:.0f} of {} recordings simulated from this fit without any "
                       "other effect ({:.1f} %, 95 %: at most {:.1f} %)\n",
                       number_in_json(naming["rate"]) * draws, draws,
                       100.0 * number_in_json(naming["rate"]),
                       100.0 * number_in_json(naming["upper_bound"]));
}

std::string experiment_lines(const json& found) {
    const json& experiments = found["next_experiment"];
    std::string text = experiments.empty() ? "" : "next experiments, the most telling first:\n";
    for (std::size_t k = 0; k < std::min(listed_experiments, experiments.size()); ++k)
        text += present::wrapped(
            "  - ",
            fmt::format("{}: {} ({:.0f} sigma)", experiments[k]["what"].get<std::string>(),
                        what_it_tells(experiments[k]["separates"]),
                        std::sqrt(number_in_json(experiments[k]["expected_gap"]))),
            diagnosis_width);
    return text;
}

} // namespace culm::cli
