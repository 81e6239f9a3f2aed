// SPDX-License-Identifier: BSD-3-Clause
#include "cli/compare_action.hpp"

#include "cli/compare_arrays.hpp"
#include "cli/compare_json.hpp"
#include "cli/compare_text.hpp"
#include "cli/effect_table_action.hpp"
#include "cli/fit_cost.hpp"
#include "cli/next_step.hpp"
#include "cli/run_provenance.hpp"
#include "cli/text_output.hpp"
#include "cli/text_style.hpp"
#include "measure/folder/measurement_folder.hpp"
#include "present/json.hpp"
#include "study/config/study_effects.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include <fmt/format.h>

namespace culm::cli {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

std::string with_of(const CompareArguments& arguments) {
    return arguments.with.empty() ? std::string() : arguments.with.front();
}

/// What --with and --ladder ask for: every model contains the one before it.
std::vector<fit::SelectedEffects> models_of(const CompareArguments& arguments) {
    if (arguments.with.size() > 1)
        throw core::InputError("--with may stand several times only with --table; write the "
                               "effects of one model with commas, --with A,B");
    std::vector<fit::SelectedEffects> models;
    fit::SelectedEffects effects;
    if (!arguments.with.empty()) {
        effects = study::effects_from(arguments.with.front());
        models.push_back(effects);
    }
    if (!arguments.ladder.empty())
        for (const physics::SelectedEffect& added : study::effects_from(arguments.ladder)) {
            effects.push_back(added);
            models.push_back(effects);
        }
    return models;
}

/// DIR/deflections.csv: measured, and of every model the predicted deflections.
void write_deflections(const fs::path& file, const measure::Measurement& measurement,
                       const diagnose::Ladder& ladder) {
    std::string text = "time_s";
    std::vector<const fit::RecordingFit*> fits;
    for (const diagnose::Rung& rung : ladder.rungs)
        if (!rung.fit.failed())
            fits.push_back(&rung.fit.parts.front());
    for (const double height : measurement.heights) {
        text += fmt::format(",measured h={:.10g}mm", 1e3 * height);
        for (std::size_t k = 0; k < fits.size(); ++k)
            text += fmt::format(",model {} h={:.10g}mm", k + 1, 1e3 * height);
    }
    text += '\n';
    const auto cell = [](double deflection) {
        return std::isnan(deflection) ? std::string(",") : fmt::format(",{:.6g}", 1e3 * deflection);
    };
    const std::size_t rows = measurement.heights.size();
    for (std::size_t i = 0; !fits.empty() && i < fits.front()->times.size(); ++i) {
        text += fmt::format("{:.9g}", measurement.times[i]);
        for (std::size_t j = 0; j < rows; ++j) {
            text += cell(measurement.deflection(i, j));
            for (const fit::RecordingFit* fit : fits)
                text += cell(fit->prediction.readings[i * rows + j]);
        }
        text += '\n';
    }
    write_text(file, text);
}

/// One measurement, on one rank.
/// What the user should type next: search if something is missing, calibrate if nothing is.
std::string next_command(const CompareArguments& arguments, const fs::path& folder,
                         const json& comparison) {
    const std::string model = model_words(arguments.law, arguments.spheres, arguments.window_s);
    const json& last = comparison["ladder"].back();
    const bool fits = last.contains("verdict") && last["verdict"]["adequate"].get<bool>();
    if (!fits)
        return "culm diagnose" + as_words({folder.string()}) + model;
    std::string effects;
    for (const std::string& added : {with_of(arguments), arguments.ladder})
        if (!added.empty()) {
            effects += effects.empty() ? "" : ",";
            effects += added;
        }
    return "culm calibrate" + as_words({folder.string()}) +
           (effects.empty() ? std::string() : " --with" + as_words({effects})) + model + " --check";
}

core::ExitCode compare_one(const CompareArguments& arguments, const fs::path& folder,
                           const std::vector<fit::SelectedEffects>& models) {
    const measure::Measurement measurement = measure::read_measurement(folder);
    std::vector<fs::path> inputs = measurement_files({folder});
    for (const std::string& effects : {with_of(arguments), arguments.ladder})
        for (const fs::path& file : effect_files(effects))
            inputs.push_back(file);
    const RunProvenance provenance(inputs, nullptr); // the other ranks have nothing to do
    fit::FitOptions options;
    options.chain = {arguments.spheres, *physics::law_by_name(arguments.law)};
    options.window = arguments.window_s;
    if (!arguments.output.empty())
        make_folder(arguments.output);
    if (!arguments.is_quiet && arguments.json != "-")
        fmt::print(stderr, "{}", cost_of_ladder(measurement, models, options));
    const diagnose::Ladder ladder = diagnose::climb(measurement, models, options);
    json document = ladder_json(ladder, measurement);
    document["folder"] = folder.string();
    document["options"] = {{"law", arguments.law},
                           {"with", with_of(arguments)},
                           {"ladder", arguments.ladder},
                           {"window_s", arguments.window_s ? json(*arguments.window_s) : json()}};
    document["provenance"] = provenance.document();
    for (const std::string& remark : measurement.remarks)
        print_note(remark);
    if (!arguments.json.empty())
        present::write_json(arguments.json, document);
    if (!arguments.output.empty()) {
        present::write_json((fs::path(arguments.output) / "comparison.json").string(), document);
        write_deflections(fs::path(arguments.output) / "deflections.csv", measurement, ladder);
        write_comparison_arrays(fs::path(arguments.output) / "comparison.h5", ladder, measurement);
    }
    if (arguments.json != "-")
        fmt::print("{}{}", comparison_text(document, TextStyle::of(stdout)),
                   next_step(next_command(arguments, folder, document)));
    return std::ranges::any_of(ladder.rungs, [](const auto& rung) { return rung.fit.failed(); })
               ? core::ExitCode::PointsFailed
               : core::ExitCode::Done;
}

} // namespace

core::ExitCode compare_measurements(const CompareArguments& arguments,
                                    const farm::Communicator* communicator) {
    if (arguments.is_table)
        return effect_table(arguments, communicator);
    const std::vector<fit::SelectedEffects> models = models_of(arguments);
    std::vector<fs::path> folders;
    for (const std::string& path : arguments.paths)
        for (const fs::path& folder : measure::find_measurements(path))
            folders.push_back(folder);
    if (folders.size() != 1)
        throw core::InputError(
            fmt::format("{} measurements; compare takes one, --table takes many", folders.size()));
    return farm::on_root(communicator,
                         [&] { return compare_one(arguments, folders.front(), models); });
}

} // namespace culm::cli
