// SPDX-License-Identifier: BSD-3-Clause
#include "cli/calibration_table.hpp"

#include "cli/parameter_text.hpp"

#include <cmath>
#include <limits>

#include <fmt/format.h>

namespace culm::cli {
namespace {

using nlohmann::json;

double number(const json& value) {
    return value.is_number() ? value.get<double>() : std::numeric_limits<double>::quiet_NaN();
}

/// "value ± half of the 95 % interval".
std::string plus_minus(const json& estimate, double scale, int decimals) {
    const double value = scale * number(estimate["value"]);
    const double half = scale * number(estimate["interval"][1]) - value;
    return fmt::format("{:.{}f} ± {:.{}f}", value, decimals, half, decimals);
}

std::string parameter_lines(const json& stem) {
    std::string text;
    for (const auto& [key, entry] : stem["parameters"].items()) {
        const ReadableParameter shown = readable(key, number(entry["value"]));
        text += fmt::format("    {:<24} ", shown.name);
        if (!shown.unit.empty())
            text += fmt::format("{} {}", plus_minus(entry, shown.scale, shown.scale < 1.0 ? 5 : 4),
                                shown.unit);
        else if (key == "bond_damping")
            text += plus_minus(entry, 1.0, 3);
        else
            text += fmt::format("{:.5g} ± {:.2g}", number(entry["value"]),
                                number(entry["interval"][1]) - number(entry["value"]));
        if (entry.contains("profile_interval"))
            text += fmt::format("   profile {:.6g} … {:.6g}",
                                shown.scale * number(entry["profile_interval"][0]),
                                shown.scale * number(entry["profile_interval"][1]));
        text += '\n';
    }
    return text;
}

std::string check_lines(const json& check) {
    if (check.contains("failure"))
        return fmt::format("  check: not possible: {}\n", check["failure"].get<std::string>());
    return fmt::format(
        "  check: Eq. 1 read from the simulated stem against the measured one\n"
        "    b1 per cycle  {:.4f} against {:.4f}, error {:+.2f} % (the reading is good to {:.2f} "
        "%)\n"
        "    b2            {:.3f} Hz against {:.3f} Hz, error {:+.3f} % (good to {:.3f} %)\n",
        number(check["simulated_b1_per_cycle"]), number(check["measured_b1_per_cycle"]),
        number(check["b1_error_percent"]), number(check["b1_resolution_percent"]),
        number(check["simulated_b2_hz"]), number(check["measured_b2_hz"]),
        number(check["b2_error_percent"]), number(check["b2_resolution_percent"]));
}

std::string law_text(const json& modulus, const json& damping) {
    const auto one = [](const json& found, double scale, int decimals) {
        return found.is_null() ? std::string("none")
                               : fmt::format("{:.{}f} (95 %: {:.{}f} … {:.{}f})",
                                             scale * number(found["value"]), decimals,
                                             scale * number(found["interval"][0]), decimals,
                                             scale * number(found["interval"][1]), decimals);
    };
    return fmt::format("Y = {} GPa, beta = {}", one(modulus, 1e-9, 4), one(damping, 1.0, 2));
}

std::string via_lines(const json& via, const TextStyle& style) {
    if (via.contains("failure"))
        return fmt::format("  by the study: not possible: {}\n", via["failure"].get<std::string>());
    const json& modulus = via["bond_youngs_modulus_pa"];
    const json& damping = via["bond_damping"];
    std::string text = fmt::format(
        "  by the study {}: h = {:.4g} mm, window {:.4g} s, b1 per cycle {}, b2 {} Hz\n"
        "    Eqs. 12-13    {}\n    F-test terms  {}\n",
        via["study"].get<std::string>(), number(via["height_mm"]), number(via["window_s"]),
        plus_minus(via["b1_per_cycle"], 1.0, 4), plus_minus(via["b2_hz"], 1.0, 3),
        law_text(modulus["single_law"], damping["single_law"]),
        law_text(modulus["f_test_terms"], damping["f_test_terms"]));
    for (const json& warning : via["warnings"])
        text += fmt::format("    {} {}\n", style.warning("WARNING:"), warning.get<std::string>());
    return text;
}

std::string stem_text(const json& stem, const TextStyle& style) {
    const std::string id = stem["measurement"].get<std::string>();
    if (stem.contains("failure"))
        return fmt::format("{}: {}: {}\n", id, style.failure("FAILED"),
                           stem["failure"].get<std::string>());
    const json& fit = stem["fit"];
    const json& mode = stem["mode"];
    std::string text = fmt::format(
        "{}: chain of {} spheres, law {}, fitted to {} readings (intervals 95 %)\n{}", id,
        stem["chain"]["spheres"].get<int>(), stem["chain"]["law"].get<std::string>(),
        fit["readings"].get<std::size_t>(), parameter_lines(stem));
    text += fmt::format("  first mode: b2 {} Hz, b1 per cycle {}, damping ratio {:.5f}\n",
                        plus_minus(mode["b2_hz"], 1.0, 3), plus_minus(mode["b1_per_cycle"], 1.0, 5),
                        number(mode["damping_ratio"]));
    text += fmt::format("  leaves {:.4f} mm rms; noise {:.4f} mm ({}); reduced chi2 {:.4f}: {}\n",
                        number(fit["rmse_mm"]), number(fit["noise_mm"]),
                        fit["noise_source"].get<std::string>(), number(fit["reduced_chi2"]),
                        fit["adequate"].get<bool>()
                            ? style.good("nothing is missing that this record could show")
                            : style.warning("SOMETHING IS MISSING: ") +
                                  fit["reason"].get<std::string>());
    if (stem.contains("check"))
        text += check_lines(stem["check"]);
    if (stem.contains("via"))
        text += via_lines(stem["via"], style);
    return text;
}

std::string stem_line(const json& stem, bool is_checked, const TextStyle& style) {
    const std::string id = stem["measurement"].get<std::string>();
    if (stem.contains("failure"))
        return fmt::format("{:<14} {}: {}\n", id, style.finding("failed"),
                           stem["failure"].get<std::string>());
    const json& fit = stem["fit"];
    std::string check;
    if (is_checked)
        check =
            !stem.contains("check") || stem["check"].contains("failure")
                ? fmt::format("{:>9} {:>9}  ", "-", "-")
                : fmt::format("{:>+8.2f}% {:>+8.3f}%  ", number(stem["check"]["b1_error_percent"]),
                              number(stem["check"]["b2_error_percent"]));
    return fmt::format(
        "{:<14} {:>18} {:>16} {:>18} {:>17} {:>8.4f}  {}{}\n", id,
        plus_minus(stem["parameters"]["bond_youngs_modulus_pa"], 1e-9, 4),
        plus_minus(stem["parameters"]["bond_damping"], 1.0, 2),
        plus_minus(stem["mode"]["b1_per_cycle"], 1.0, 4), plus_minus(stem["mode"]["b2_hz"], 1.0, 3),
        number(fit["reduced_chi2"]), check,
        fit["adequate"].get<bool>() ? std::string("-")
                                    : style.warning(fit["reason"].get<std::string>()));
}

std::string range_line(const char* name, const json& range, double scale, const char* unit) {
    const json& bounds = range["central_90_percent"];
    const json& lower = range["central_90_percent_lower_interval"];
    const json& upper = range["central_90_percent_upper_interval"];
    return fmt::format("    {:<14} {:.4g} … {:.4g} {} (ends, 95 % by bootstrap: {:.4g} … {:.4g} "
                       "and {:.4g} … {:.4g}); mean {:.4g}, sd {:.3g}\n",
                       name, scale * number(bounds[0]), scale * number(bounds[1]), unit,
                       scale * number(lower[0]), scale * number(lower[1]), scale * number(upper[0]),
                       scale * number(upper[1]), scale * number(range["mean"]),
                       scale * number(range["standard_deviation"]));
}

std::string population_text(const json& population) {
    std::string text = fmt::format(
        "{} stems calibrated, {} failed; something is missing in {}\n90 % of the stems lie in\n",
        population["stems"].get<std::size_t>(), population["failed"].get<std::size_t>(),
        population["something_missing"].get<std::size_t>());
    text += range_line("Y", population["bond_youngs_modulus_pa"], 1e-9, "GPa");
    text += range_line("beta", population["bond_damping"], 1.0, "");
    text += range_line("b1 per cycle", population["b1_per_cycle"], 1.0, "");
    text += range_line("b2", population["b2_hz"], 1.0, "Hz");
    return text;
}

} // namespace

std::string calibration_table(const json& document, const TextStyle& style) {
    const json& stems = document["stems"];
    std::string text;
    if (stems.size() == 1)
        return stem_text(stems.front(), style);
    bool is_checked = false;
    for (const json& stem : stems)
        is_checked = is_checked || stem.contains("check");
    text = fmt::format("{:<14} {:>18} {:>16} {:>18} {:>17} {:>8}  {}{}\n", "stem", "Y GPa", "beta",
                       "b1 per cycle", "b2 Hz", "chi2/dof",
                       is_checked ? fmt::format("{:>9} {:>9}  ", "b1 error", "b2 error") : "",
                       "what shows that something is missing");
    for (const json& stem : stems)
        text += stem_line(stem, is_checked, style);
    text += "(± is half of the 95 % interval)\n";
    if (document["population"].is_object())
        text += population_text(document["population"]);
    for (const json& stem : stems)
        if (stem.contains("via"))
            text += stem["measurement"].get<std::string>() + '\n' + via_lines(stem["via"], style);
    return text;
}

} // namespace culm::cli
