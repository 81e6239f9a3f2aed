// SPDX-License-Identifier: BSD-3-Clause
// culm compare MEASUREMENT: compares one measurement with growing models.
#include "cli/options.hpp"
#include "cli/provenance.hpp"
#include "cli/recordings.hpp"
#include "core/user_files.hpp"
#include "measure/folder/measurement_folder.hpp"
#include "present/comparison.hpp"
#include "present/files.hpp"
#include "present/parameters.hpp"
#include "study/config/study_effects.hpp"

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace culm::cli {
namespace {

namespace fs = std::filesystem;

struct CompareArguments : RecordingArguments {
    std::vector<std::string> with; ///< as it was given; more than one is refused
    std::string ladder;
};

std::vector<fs::path> comparison_inputs(const fs::path& folder, const CompareArguments& arguments) {
    std::vector<fs::path> inputs = measurement_files({folder});
    for (const std::string& effects : arguments.with)
        std::ranges::copy(effect_files(effects), std::back_inserter(inputs));
    std::ranges::copy(effect_files(arguments.ladder), std::back_inserter(inputs));
    return inputs;
}

/// The models of --with and --ladder: every model contains the preceding one.
std::vector<fit::SelectedEffects> growing_models(const CompareArguments& arguments) {
    if (arguments.with.size() > 1)
        throw core::InputError("--with may be given only once; separate the effects by "
                               "commas, --with A,B");
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

/// The measured deflections, and those predicted by every model that could be fitted.
std::string deflections_csv(const measure::Measurement& measurement,
                            const diagnose::Ladder& ladder) {
    std::vector<std::pair<std::string, const fit::RecordingFit*>> models;
    for (const diagnose::LadderModel& model : ladder.models)
        if (!model.fit.failed())
            models.emplace_back(present::model_name(model.fit.names()), &model.fit.parts.front());
    return present::deflections_csv(measurement, models);
}

/// The suggested next command: diagnose if the model lacks something, else calibrate.
std::string next_command(const CompareArguments& arguments, const fs::path& folder,
                         const diagnose::Ladder& ladder) {
    const std::string place = as_words({folder.string()});
    const std::optional<diagnose::Comparison>& last = ladder.models.back().comparison;
    if (!last || last->verdict.finding != diagnose::Finding::Adequate)
        return "culm diagnose" + place + chain_words(arguments);
    std::vector<std::string> effects = arguments.with;
    if (!arguments.ladder.empty())
        effects.push_back(arguments.ladder);
    return "culm calibrate" + place + model_words(arguments, effects);
}

/// One measurement, on one rank.
core::ExitCode compare_one(const CompareArguments& arguments, const fs::path& folder,
                           const std::vector<fit::SelectedEffects>& models) {
    const measure::Measurement measurement = measure::read_measurement(folder);
    const RunProvenance provenance(comparison_inputs(folder, arguments), nullptr);
    fit::FitOptions options;
    options.chain = chain_options(arguments);
    options.window = arguments.window_s;
    const diagnose::Ladder ladder = diagnose::climb(measurement, models, options);
    const nlohmann::json document = present::comparison_json(
        {ladder,
         measurement,
         folder.string(),
         {arguments.law, arguments.with.empty() ? std::string() : arguments.with.front(),
          arguments.ladder, arguments.window_s},
         provenance.document()});
    write_results(arguments, {&measurement, 1}, "comparison.json", document);
    if (!arguments.output.empty()) {
        const fs::path output = arguments.output;
        core::write_text(output / "deflections.csv", deflections_csv(measurement, ladder));
    }
    if (arguments.prints_text())
        fmt::print(
            "{}{}",
            present::comparison_text(ladder, measurement, arguments.law, arguments.with_details),
            next_step(arguments, next_command(arguments, folder, ladder)));
    return std::ranges::any_of(ladder.models, [](const auto& model) { return model.fit.failed(); })
               ? core::ExitCode::PointsFailed
               : core::ExitCode::Done;
}

core::ExitCode compare_measurements(const CompareArguments& arguments,
                                    const farm::Communicator* communicator) {
    const std::vector<fit::SelectedEffects> models = growing_models(arguments);
    std::vector<fs::path> folders;
    for (const std::string& path : arguments.paths)
        for (const fs::path& folder : measure::find_measurements(path))
            folders.push_back(folder);
    if (folders.size() != 1)
        throw core::InputError(fmt::format("{} measurements; compare takes one", folders.size()));
    return farm::on_root(communicator,
                         [&] { return compare_one(arguments, folders.front(), models); });
}

} // namespace

void add_compare_command(CLI::App& app, core::ExitCode& exit_code, int& argc, char**& argv) {
    CLI::App* command = app.add_subcommand(
        "compare", "Compare a model with a measurement: where, when and how it fails, and whether "
                   "added effects improve it");
    auto arguments = std::make_shared<CompareArguments>();
    add_recording_options(*command, *arguments, "A measurement folder",
                          "Folder for comparison.json and deflections.csv", "Compare");
    add_option(*command, "--with", arguments->with, "EFFECT,...",
               "Add these effects (`culm effects`) to the published chain: "
               "quadratic_drag,relaxation(hold_time_s=3); parameters without a value are fitted")
        ->allow_extra_args(false);
    add_option(*command, "--ladder", arguments->ladder, "EFFECT,...",
               "Add these effects one by one and judge each step");
    add_chain_options(*command, *arguments);
    run_on_ranks(*command, arguments, exit_code, argc, argv, compare_measurements);
}

} // namespace culm::cli
