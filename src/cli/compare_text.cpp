// SPDX-License-Identifier: BSD-3-Clause
#include "cli/compare_text.hpp"

#include "cli/json_cell.hpp"
#include "cli/parameter_text.hpp"

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

std::string ladder_lines(const json& ladder, const TextStyle& style) {
    std::size_t width = 8;
    for (const json& rung : ladder)
        width = std::max(width, model_name(rung).size());
    std::string text =
        fmt::format("{:<{}} {:>9} {:>7} {:>9} {:>10} {:>10} {:>10}  {}\n", "model", width, "rms mm",
                    "/noise", "red. chi2", "BIC", "last third", "one height", "verdict");
    for (const json& rung : ladder) {
        if (rung.contains("failure")) {
            text += fmt::format("{:<{}} {}: {}\n", model_name(rung), width, style.finding("failed"),
                                rung["failure"].get<std::string>());
            continue;
        }
        text +=
            fmt::format("{:<{}} {:>9} {:>7} {:>9} {:>10} {:>10} {:>10}  {}\n", model_name(rung),
                        width, json_cell(rung["rmse_mm"], 4), json_cell(rung["rmse_over_noise"], 2),
                        json_cell(rung["reduced_chi2"], 3), json_cell(rung["bic"], 0),
                        held_out(rung["held_out"]["last_third"]),
                        held_out(rung["held_out"]["one_height"]), style.finding(finding(rung)));
    }
    return text;
}

std::string parameter_line(const std::string& key, const json& entry) {
    return fmt::format("    {:<40} {}\n", readable(key, number_in_json(entry["value"])).name,
                       value_text(key, entry));
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

std::string comparison_text(const json& comparison, const TextStyle& style) {
    const json& ladder = comparison["ladder"];
    std::string text =
        fmt::format("{}: {} heights, {} frames, {}\n", comparison["measurement"].get<std::string>(),
                    comparison["heights"].get<int>(), comparison["frames"].get<int>(),
                    comparison.contains("noise_mm") && comparison["noise_known"].get<bool>()
                        ? fmt::format("noise {} mm ({})", json_cell(comparison["noise_mm"], 4),
                                      comparison["noise_source"].get<std::string>())
                        : std::string("noise not known"));
    text += ladder_lines(ladder, style) + "\n";
    for (const json& rung : ladder) {
        if (rung.contains("gain"))
            text += step_lines(rung, ladder);
        else
            text += "baseline (± is half of the 95 % interval):\n";
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

std::string effect_table_text(const json& table, const TextStyle& style) {
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
                text += found["applies"].get<bool>() ? "   " + style.failure("failed")
                                                     : fmt::format(" {:>8}", "-");
                continue;
            }
            const double ratio = number_in_json(found["rmse_over_noise"]);
            const std::string cell = fmt::format(" {:>7.2f}{}", ratio,
                                                 ratio <= explained              ? '*'
                                                 : found["at_bound"].get<bool>() ? 'b'
                                                                                 : ' ');
            text += ratio <= explained ? style.good(cell) : cell;
        }
        text += '\n';
    }
    return text + "* explained to 1.10 times the noise; b: a parameter stands at its bound; -: the "
                  "effect means nothing for this measurement\n";
}

} // namespace culm::cli
