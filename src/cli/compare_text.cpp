// SPDX-License-Identifier: BSD-3-Clause
#include "cli/compare_text.hpp"

#include "cli/json_cell.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace culm::cli {
namespace {

using nlohmann::json;

constexpr double explained = 1.10; ///< residual over noise, at most

std::string model_name(const json& rung) {
    std::string name;
    for (const json& part : rung["model"])
        name += (name.empty() ? "" : " + ") + part.get<std::string>();
    return name;
}

/// "fits", "something is missing", "cannot tell", "failed".
std::string finding(const json& rung) {
    if (rung.contains("failure"))
        return "failed";
    const std::string found = rung["verdict"]["finding"];
    return found == "adequate"     ? "fits"
           : found == "inadequate" ? "something is missing"
                                   : "cannot tell";
}

std::string held_out(const json& part) {
    return part.contains("failure") ? std::string("-") : json_cell(part["rms_over_noise"], 2);
}

std::string ladder_lines(const json& ladder) {
    std::size_t width = 8;
    for (const json& rung : ladder)
        width = std::max(width, model_name(rung).size());
    std::string text =
        fmt::format("{:<{}} {:>9} {:>7} {:>9} {:>10} {:>10} {:>10}  {}\n", "model", width, "rms mm",
                    "/noise", "red. chi2", "BIC", "last third", "one height", "verdict");
    for (const json& rung : ladder) {
        if (rung.contains("failure")) {
            text += fmt::format("{:<{}} failed: {}\n", model_name(rung), width,
                                rung["failure"].get<std::string>());
            continue;
        }
        text +=
            fmt::format("{:<{}} {:>9} {:>7} {:>9} {:>10} {:>10} {:>10}  {}\n", model_name(rung),
                        width, json_cell(rung["rmse_mm"], 4), json_cell(rung["rmse_over_noise"], 2),
                        json_cell(rung["reduced_chi2"], 3), json_cell(rung["bic"], 0),
                        held_out(rung["held_out"]["last_third"]),
                        held_out(rung["held_out"]["one_height"]), finding(rung));
    }
    return text;
}

std::string parameter_line(const std::string& key, const json& entry) {
    return fmt::format("    {:<40} {}\n", key, value_text(entry));
}

std::string step_lines(const json& rung, const json& ladder) {
    std::string added;
    for (const json& name : rung["added"])
        added += (added.empty() ? "" : " and ") + name.get<std::string>();
    if (rung.contains("failure"))
        return fmt::format("{} could not be fitted.\n", added);
    const json& compared_with = ladder[rung["compared_with"].get<std::size_t>()];
    std::string text = fmt::format("{} {} {} over {}: {}.\n", added,
                                   rung["added"].size() > 1 ? "together are" : "is",
                                   rung["gain"].get<bool>() ? "a gain" : "no gain",
                                   model_name(compared_with), rung["why"].get<std::string>());
    if (rung.contains("change") && number_in_json(rung["change"]["bond_youngs_modulus"]) != 0.0)
        text += fmt::format("    Y changes by {:+.2f} %, beta by {:+.2f} %\n",
                            100.0 * number_in_json(rung["change"]["bond_youngs_modulus"]),
                            100.0 * number_in_json(rung["change"]["bond_damping"]));
    return text;
}

} // namespace

std::string value_text(const json& parameter) {
    const double value = number_in_json(parameter["value"]);
    const double half = number_in_json(parameter["interval"][1]) - value;
    const int digits = std::clamp(
        static_cast<int>(std::ceil(std::log10(std::abs(value) / std::max(half, 1e-300)))) + 2, 3,
        7);
    const bool is_known = std::isfinite(half) && half > 0.0;
    return fmt::format("{:.{}g}{}{}", value, is_known ? digits : 5,
                       is_known ? fmt::format(" ± {:.2g}", half) : std::string(),
                       parameter["at_bound"].get<bool>() ? "  (at its bound)" : "");
}

std::string comparison_text(const json& comparison) {
    const json& ladder = comparison["ladder"];
    std::string text =
        fmt::format("{}: {} heights, {} frames, {}\n", comparison["measurement"].get<std::string>(),
                    comparison["heights"].get<int>(), comparison["frames"].get<int>(),
                    comparison.contains("noise_mm") && comparison["noise_known"].get<bool>()
                        ? fmt::format("noise {} mm ({})", json_cell(comparison["noise_mm"], 4),
                                      comparison["noise_source"].get<std::string>())
                        : std::string("noise not known"));
    text += ladder_lines(ladder) + "\n";
    for (const json& rung : ladder) {
        if (rung.contains("gain"))
            text += step_lines(rung, ladder);
        else
            text += "baseline:\n";
        if (rung.contains("parameters") && rung["moves"].get<bool>())
            for (const auto& [key, entry] : rung["parameters"].items())
                text += parameter_line(key, entry);
    }
    for (auto rung = ladder.rbegin(); rung != ladder.rend(); ++rung) {
        if (!rung->contains("sentences"))
            continue;
        text += fmt::format("\n{}:\n", model_name(*rung));
        for (const json& sentence : (*rung)["sentences"])
            text += fmt::format("  {}\n", sentence.get<std::string>());
        break;
    }
    return text;
}

std::string effect_table_text(const json& table) {
    std::size_t width = 8;
    for (const json& row : table["models"])
        width = std::max(width, row["name"].get<std::string>().size());
    std::string text = fmt::format("{:<{}}", "residual/noise", std::max<std::size_t>(width, 14));
    width = std::max<std::size_t>(width, 14);
    for (const json& measurement : table["measurements"])
        text += fmt::format(" {:>8}", measurement.get<std::string>().substr(0, 8));
    text += '\n';
    for (const json& row : table["models"]) {
        text += fmt::format("{:<{}}", row["name"].get<std::string>(), width);
        for (const json& found : row["cells"]) {
            if (found.contains("failure")) {
                text += fmt::format(" {:>8}", found["applies"].get<bool>() ? "failed" : "-");
                continue;
            }
            const double ratio = number_in_json(found["rmse_over_noise"]);
            text += fmt::format(" {:>7.2f}{}", ratio,
                                ratio <= explained              ? '*'
                                : found["at_bound"].get<bool>() ? 'b'
                                                                : ' ');
        }
        text += '\n';
    }
    return text + "* explained to 1.10 times the noise; b: a parameter stands at its bound; -: the "
                  "effect means nothing for this measurement\n";
}

} // namespace culm::cli
