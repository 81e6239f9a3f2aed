// SPDX-License-Identifier: BSD-3-Clause
// culm export liggghts|lammps CALIBRATION
#include "calibrate/bulk_export.hpp"
#include "cli/options.hpp"
#include "core/error.hpp"
#include "core/nearest_name.hpp"
#include "core/user_files.hpp"

#include <map>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace culm::cli {
namespace {

using nlohmann::json;

struct BulkExportArguments {
    std::string code;
    std::string calibration;
    std::string stem;
    std::string output;
    std::vector<std::string> without;
    std::string lammps_version = "4Jul2026";
};

/// A stem as docs/calibration-format.md describes it.
calibrate::BulkStem bulk_stem(const json& stem) {
    calibrate::BulkStem bulk;
    const json& chain = stem.at("chain");
    bulk.id = stem.at("measurement").get<std::string>();
    bulk.law = chain.at("law").get<std::string>();
    bulk.stem.sphere_count = chain.at("spheres").get<int>();
    bulk.stem.bond_length = chain.at("bond_length_m").get<double>();
    bulk.stem.sphere_diameter = chain.at("sphere_diameter_m").get<double>();
    bulk.stem.density = chain.at("sphere_density_kg_m3").get<double>();
    bulk.stem.tip_mass_share = chain.at("tip_mass_share").get<double>();
    bulk.stem.bond_outer_diameter = chain.at("bond_outer_diameter_m").get<double>();
    bulk.stem.bond_inner_diameter = chain.at("bond_inner_diameter_m").get<double>();
    bulk.stem.poissons_ratio = chain.at("poissons_ratio").get<double>();
    // Y and β of the chain with the stated length and section. In `parameters` the fit may have
    // changed these inputs within their uncertainty, and Y with them.
    bulk.stem.bond_youngs_modulus = chain.at("bond_youngs_modulus_pa").get<double>();
    bulk.stem.bond_damping = chain.at("bond_damping").get<double>();
    for (const json& mass : chain.at("added_masses"))
        bulk.added_masses.push_back(
            {mass.at("height_m").get<double>(), mass.at("mass_kg").get<double>()});
    for (const json& effect : chain.at("effects"))
        bulk.effects.push_back({effect.at("name").get<std::string>(),
                                effect.at("values").get<std::map<std::string, double>>()});
    bulk.reduced_chi_squared = stem.at("fit").at("reduced_chi2").get<double>();
    bulk.is_adequate = stem.at("fit").at("adequate").get<bool>();
    return bulk;
}

/// The calibrated stems of a file, or only the one with the id (empty: all). Throws
/// core::InputError if the file is not a calibration or has no such stem.
std::vector<calibrate::BulkStem> bulk_stems(const std::string& file, const std::string& id) {
    std::vector<calibrate::BulkStem> stems;
    std::vector<std::string> names;
    try {
        const json document = json::parse(core::file_text(file));
        if (document.at("format") != "culm-calibration")
            throw core::InputError(
                fmt::format("{}: format = {}; `culm calibrate --json` writes \"culm-calibration\"",
                            file, document.at("format").dump()));
        for (const json& stem : document.at("stems")) {
            names.push_back(stem.at("measurement").get<std::string>());
            if (stem.contains("failure") || !(id.empty() || names.back() == id))
                continue;
            if (!stem.at("chain").contains("added_masses"))
                throw core::InputError(
                    fmt::format("{}: {}: written before calibrations stored added masses; "
                                "calibrate the stem again",
                                file, names.back()));
            stems.push_back(bulk_stem(stem));
        }
    } catch (const json::exception& error) {
        throw core::InputError(
            fmt::format("{}: not what `culm calibrate --json` writes: {}", file, error.what()));
    }
    if (stems.empty()) {
        std::erase(names, id); // it could not be calibrated
        throw core::InputError(fmt::format("{}: no calibrated stem{}{}", file,
                                           id.empty() ? "" : fmt::format(" \"{}\"", id),
                                           core::did_you_mean(id, names)));
    }
    return stems;
}

void export_lines(const BulkExportArguments& arguments) {
    std::vector<calibrate::BulkStem> stems = bulk_stems(arguments.calibration, arguments.stem);
    calibrate::leave_out(stems, arguments.without);
    std::string lines;
    calibrate::TypeNumbers next;
    const auto version = arguments.lammps_version == "4Jul2026"
                             ? calibrate::LammpsVersion::From4July2026
                             : calibrate::LammpsVersion::UpTo30March2026;
    for (const calibrate::BulkStem& stem : stems)
        lines += (lines.empty() ? "" : "\n") + (arguments.code == "liggghts"
                                                    ? calibrate::liggghts_lines(stem, next)
                                                    : calibrate::lammps_lines(stem, version, next));
    if (arguments.output.empty())
        fmt::print("{}", lines);
    else
        core::write_text(arguments.output, lines);
}

} // namespace

void add_export_command(CLI::App& app) {
    CLI::App* command = app.add_subcommand(
        "export", "Write the input lines of a bulk simulation from a calibration");
    auto arguments = std::make_shared<BulkExportArguments>();
    add_option(*command, "code", arguments->code, "CODE",
               "\"liggghts\" (the authors' flexible fibres; law schramm2019) or \"lammps\" "
               "(bond style bpm/rotational; law consistent)")
        ->required()
        ->check(CLI::IsMember({"liggghts", "lammps"}));
    add_option(*command, "calibration", arguments->calibration, "CALIBRATION.json",
               "File written by culm calibrate --json")
        ->required();
    add_option(*command, "--stem", arguments->stem, "ID",
               "Only the stem of this id (default: all)");
    add_option(*command, "--without", arguments->without, "EFFECT,...",
               "Leave these effects of the calibration out; \"added_mass\" means the "
               "known masses. Without it an effect that CODE cannot express is refused")
        ->delimiter(',');
    add_option(*command, "--lammps-version", arguments->lammps_version, "VERSION",
               "4Jul2026 for this and later versions of LAMMPS (default), 30Mar2026 for "
               "earlier ones: bond_style bpm/rotational changed in between")
        ->check(CLI::IsMember({"4Jul2026", "30Mar2026"}));
    add_option(*command, "-o,--output", arguments->output, "FILE",
               "File to write (default: the screen)");
    command->callback([arguments] { export_lines(*arguments); });
}

} // namespace culm::cli
