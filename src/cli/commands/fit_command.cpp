// SPDX-License-Identifier: BSD-3-Clause
// culm fit MEASUREMENT...
#include "cli/options.hpp"
#include "cli/provenance.hpp"
#include "cli/recordings.hpp"
#include "core/user_files.hpp"
#include "measure/folder/measurement_folder.hpp"
#include "present/files.hpp"
#include "present/ring_down_fits.hpp"
#include "residuals/swing.hpp"

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace culm::cli {
namespace {

namespace fs = std::filesystem;

struct FitArguments : RecordingArguments {
    std::string phase = "fixed";
    std::string offset = "auto";
    int modes = 1;
    bool has_backbone = false;
};

/// The paper's Fig. 3c: time in periods of the stem, deflection from the position of rest relative
/// to the stem's largest one.
std::string normalised_csv(const measure::Measurement& measurement,
                           const residuals::StemRingDowns& stem) {
    std::string text = "cycles";
    for (const double height : measurement.heights)
        text += fmt::format(",h={:.10g}mm", 1e3 * height);
    text += '\n';
    for (std::size_t i = 0; i < measurement.times.size(); ++i) {
        text += fmt::format("{:.8g}", measurement.times[i] * stem.frequency->value);
        for (std::size_t j = 0; j < measurement.heights.size(); ++j) {
            const double offset = stem.heights[j].fit ? stem.heights[j].fit->offset.value : 0.0;
            text += present::csv_cell((measurement.deflection(i, j) - offset) /
                                      stem.largest_deflection);
        }
        text += '\n';
    }
    return text;
}

void write_folder(const FitArguments& arguments, const present::FitReport& report,
                  const std::vector<measure::Measurement>& measurements) {
    const fs::path folder(arguments.output);
    core::create_folder(folder / "normalised");
    core::write_text(folder / "fits.csv", present::fit_csv(report));
    for (std::size_t i = 0; i < report.stems.size(); ++i)
        if (report.stems[i].ring_downs.frequency)
            core::write_text(folder / "normalised" / fmt::format("{:03}.csv", i + 1),
                             normalised_csv(measurements[i], report.stems[i].ring_downs));
}

/// Damped modes that were fitted together, and backbones.
void add_modes(const FitArguments& arguments, const measure::Measurement& measurement,
               present::FittedStem& stem) {
    reduce::BackboneInput input = residuals::backbone_input(measurement);
    input.last = arguments.window_s.value_or(0.0);
    if (arguments.has_backbone)
        stem.backbones = reduce::backbones(input);
    if (arguments.modes == 1)
        return;
    const reduce::HeightHistories free = reduce::free_part(input);
    stem.modes = reduce::fit_damped_modes(
        free, reduce::visible_modes(free, static_cast<std::size_t>(arguments.modes)));
}

void fit(const FitArguments& arguments, core::ExitCode& exit_code) {
    present::FitReport report;
    report.options.window = arguments.window_s;
    report.options.has_phase = arguments.phase == "free";
    report.has_backbones = arguments.has_backbone;
    report.has_modes = arguments.modes > 1;
    const auto [measurements, folders] = measure::read_measurements(arguments.paths);
    const RunProvenance provenance(measurement_files(folders), nullptr);
    std::vector<residuals::StemRingDowns> ring_downs;
    for (std::size_t i = 0; i < measurements.size(); ++i) {
        const measure::Measurement& measurement = measurements[i];
        std::ranges::copy(measurement.remarks, std::back_inserter(report.remarks));
        reduce::RingDownOptions options = report.options;
        options.has_offset = arguments.offset == "auto"
                                 ? measurement.release == measure::ReleaseKind::HeldStraight
                                 : arguments.offset == "free";
        // A record that begins during the vibration has a phase.
        options.has_phase =
            options.has_phase || measurement.release == measure::ReleaseKind::Moving;
        ring_downs.push_back(residuals::fit_stem(measurement, options));
        report.stems.push_back({{}, folders[i].string(), options.has_offset, {}, {}});
        add_modes(arguments, measurement, report.stems.back());
    }
    // For a single stem only the statistics within the stem are used.
    const residuals::PopulationSummary population = residuals::summarise_population(ring_downs);
    if (report.stems.size() > 1)
        report.population = population;
    for (std::size_t i = 0; i < ring_downs.size(); ++i)
        report.stems[i].ring_downs = std::move(ring_downs[i]);
    report.provenance = provenance.document();
    const nlohmann::json document = present::fit_json(report);
    write_results(arguments, measurements, "fit.json", document);
    if (!arguments.output.empty())
        write_folder(arguments, report, measurements);
    if (arguments.prints_text())
        fmt::print("{}{}", present::fit_table(report),
                   next_step(arguments, "culm calibrate" + as_words(arguments.paths)));
    if (std::ranges::any_of(report.stems,
                            [](const auto& stem) { return !stem.ring_downs.frequency; }))
        exit_code = core::ExitCode::PointsFailed;
}

} // namespace

void add_fit_command(CLI::App& app, core::ExitCode& exit_code) {
    CLI::App* command = app.add_subcommand(
        "fit", "Fit Eq. 1 at every height of measured stems; mean and spread of several stems");
    auto arguments = std::make_shared<FitArguments>();
    add_recording_options(*command, *arguments, "Measurement folders, or folders that contain some",
                          "Folder for fit.json, fits.csv and the normalised histories", "Fit");
    command
        ->add_option("--phase", arguments->phase,
                     "\"fixed\" at 0 as in Eq. 1, or \"free\" for a stem that starts at rest or an "
                     "uncertain release time (default: fixed)")
        ->check(CLI::IsMember({"fixed", "free"}));
    command
        ->add_option(
            "--offset", arguments->offset,
            "Position of rest: \"fixed\" at 0, \"free\", or \"auto\": free for a stem that "
            "was held straight (default: auto)")
        ->check(CLI::IsMember({"auto", "fixed", "free"}));
    command
        ->add_option("--modes", arguments->modes,
                     "Number of damped modes that are fitted together at all heights (default: 1, "
                     "Eq. 1 at each height)")
        ->check(CLI::Range(1, 3));
    command->add_flag("--backbone", arguments->has_backbone,
                      "Frequency and damping ratio of modes 1 and 2 against their amplitude, the "
                      "laws of both, and the effects that have such a signature");
    command->callback([arguments, &exit_code] { fit(*arguments, exit_code); });
}

} // namespace culm::cli
