// SPDX-License-Identifier: BSD-3-Clause
#include "cli/diagnose_action.hpp"

#include "cli/diagnose_arrays.hpp"
#include "cli/diagnose_candidates.hpp"
#include "cli/diagnose_json.hpp"
#include "cli/diagnose_text.hpp"
#include "cli/fit_cost.hpp"
#include "cli/next_step.hpp"
#include "cli/run_provenance.hpp"
#include "cli/step_display.hpp"
#include "cli/text_output.hpp"
#include "cli/text_style.hpp"
#include "farm/item_map.hpp"
#include "measure/folder/measurement_folder.hpp"
#include "present/json.hpp"

#include <chrono>
#include <filesystem>
#include <functional>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace culm::cli {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr const char* force_file_name = "missing_force.toml";

/// Everything that is read and checked before the first fit; the same on every rank.
struct DiagnosisPlan {
    measure::MeasurementSet read;
    DiagnosisEffects effects;
};

DiagnosisPlan make_plan(const DiagnoseArguments& arguments) {
    DiagnosisPlan plan;
    plan.read = measure::read_measurements(arguments.paths);
    std::set<std::string> ids;
    for (const measure::Measurement& recording : plan.read.measurements) {
        if (!ids.insert(recording.stem.id).second)
            throw core::InputError(
                fmt::format("two recordings are called \"{}\"; give each its own stem.id in "
                            "stem.toml",
                            recording.stem.id));
        static_cast<void>(
            fit::chain_of(recording, {arguments.spheres, *physics::law_by_name(arguments.law)}));
    }
    plan.effects = effects_for_diagnosis(arguments.candidates, arguments.effect_files,
                                         arguments.known, plan.read.measurements);
    return plan;
}

diagnose::DiagnosisOptions options_of(const DiagnoseArguments& arguments,
                                      const DiagnosisPlan& plan) {
    diagnose::DiagnosisOptions options;
    options.candidate.chain = {arguments.spheres, *physics::law_by_name(arguments.law)};
    options.candidate.window = arguments.window_s;
    options.known = plan.effects.known;
    options.candidates = plan.effects.candidates;
    options.most_effects = arguments.most_effects;
    return options;
}

std::vector<fs::path> input_files(const DiagnosisPlan& plan) {
    std::vector<fs::path> files = measurement_files(plan.read.folders);
    for (const auto& [effect, file] : plan.effects.files)
        files.emplace_back(file);
    return files;
}

json names_of(const fit::SelectedEffects& effects) {
    json names = json::array();
    for (const physics::SelectedEffect& selected : effects)
        names.push_back(physics::to_string(selected));
    return names;
}

json document_of(const DiagnoseArguments& arguments, const DiagnosisPlan& plan,
                 const diagnose::Diagnosis& found, const json& provenance) {
    json document = diagnosis_json(found, plan.read.measurements, plan.effects.candidates);
    for (std::size_t k = 0; k < plan.read.folders.size(); ++k)
        document["recordings"][k]["folder"] = plan.read.folders[k].string();
    document["options"] = {{"law", arguments.law},
                           {"spheres", arguments.spheres ? json(*arguments.spheres) : json()},
                           {"window_s", arguments.window_s ? json(*arguments.window_s) : json()},
                           {"max_effects", arguments.most_effects},
                           {"candidates", names_of(plan.effects.candidates)},
                           {"known", names_of(plan.effects.known)}};
    document["provenance"] = provenance;
    return document;
}

/// "--with A,B" of what is known and `added`, and the chain's options.
std::string model_options(const DiagnoseArguments& arguments, const DiagnosisPlan& plan,
                          const std::vector<std::string>& added) {
    std::string effects;
    const auto add = [&effects](const std::string& effect) {
        if (!effects.empty())
            effects += ',';
        effects += effect;
    };
    for (const physics::SelectedEffect& known : plan.effects.known)
        add(as_option(known.effect->name(), plan.effects));
    for (const std::string& effect : added)
        add(effect);
    std::string text =
        effects.empty() ? "" : fmt::format(" --with {}", cluster::shell_word(effects));
    return text + model_words(arguments.law, arguments.spheres, arguments.window_s);
}

/// What the user should type next.
std::string next_command(const DiagnoseArguments& arguments, const DiagnosisPlan& plan,
                         const diagnose::Diagnosis& found) {
    const std::string folder = cluster::shell_word(plan.read.folders.front().string());
    std::vector<std::string> effects;
    for (const std::string& effect : found.effects)
        effects.push_back(as_option(effect, plan.effects));
    std::string all;
    for (const fs::path& each : plan.read.folders)
        all += fmt::format(" {}", cluster::shell_word(each.string()));
    switch (found.conclusion) {
    case diagnose::Conclusion::Adequate:
        return "culm calibrate " + folder + model_options(arguments, plan, {}) + " --check";
    case diagnose::Conclusion::Effect:
        return "culm compare " + folder + model_options(arguments, plan, effects);
    case diagnose::Conclusion::Tie:
        return "culm diagnose" + all + " NEW_RECORDING";
    case diagnose::Conclusion::Unknown:
        break;
    }
    if (!found.missing_force || found.missing_force->as_effect_file.empty())
        return "culm compare " + folder + model_options(arguments, plan, {}) +
               " (where, when and how it fails)";
    if (arguments.output.empty())
        return "culm diagnose" + all + " -o DIR (writes the force as DIR/" + force_file_name +
               ", an effect for --with)";
    return "culm compare " + folder +
           model_options(arguments, plan,
                         {(fs::path(arguments.output) / force_file_name).string()});
}

core::ExitCode report(const DiagnoseArguments& arguments, const DiagnosisPlan& plan,
                      const diagnose::Diagnosis& found, const json& provenance) {
    const json document = document_of(arguments, plan, found, provenance);
    for (const measure::Measurement& recording : plan.read.measurements)
        for (const std::string& remark : recording.remarks)
            print_note(remark);
    if (!arguments.json.empty())
        present::write_json(arguments.json, document);
    if (!arguments.output.empty()) {
        const fs::path folder = arguments.output;
        present::write_json((folder / "diagnosis.json").string(), document);
        write_diagnosis_arrays(folder / "diagnosis.h5", found, plan.read.measurements);
        if (found.missing_force && !found.missing_force->as_effect_file.empty())
            write_text(folder / force_file_name, found.missing_force->as_effect_file);
    }
    if (arguments.json != "-")
        fmt::print("{}", diagnosis_text(document, next_command(arguments, plan, found),
                                        TextStyle::of(stdout)));
    return document["failed"].empty() ? core::ExitCode::Done : core::ExitCode::PointsFailed;
}

/// A WorkMap over the communicator's ranks; null: this process alone, through the same farm.
fit::WorkMap work_over_ranks(const farm::Communicator* communicator,
                             std::function<void(const farm::Progress&)> progress) {
    constexpr std::chrono::milliseconds progress_interval{200};
    const core::ItemMap items = farm::over_ranks(
        communicator, {.progress = std::move(progress), .progress_interval = progress_interval});
    return [items](const std::vector<double>& costs, const fit::ItemWork& work) {
        std::vector<std::string> answers;
        for (std::optional<std::string>& answer : items.values(costs, work))
            answers.push_back(std::move(answer).value_or(std::string()));
        return answers;
    };
}

} // namespace

core::ExitCode diagnose_measurements(const DiagnoseArguments& arguments,
                                     const farm::Communicator* communicator) {
    const DiagnosisPlan plan = make_plan(arguments);
    const bool is_root = communicator == nullptr || communicator->rank() == 0;
    const RunProvenance provenance(input_files(plan), communicator);
    static_cast<void>(farm::on_root(communicator, [&arguments] {
        if (!arguments.output.empty())
            make_folder(arguments.output);
        return core::ExitCode::Done;
    }));
    diagnose::DiagnosisOptions options = options_of(arguments, plan);
    if (is_root && !arguments.is_quiet && arguments.json != "-")
        fmt::print(stderr, "{}",
                   cost_of_diagnosis(plan.read.measurements, options,
                                     communicator == nullptr ? 1 : communicator->size()));
    diagnose::Diagnosis found;
    try {
        StepDisplay display(arguments.is_quiet || !is_root);
        options.progress = [&display](const std::string& step) { display.begin(step); };
        options.map = work_over_ranks(
            communicator, [&display](const farm::Progress& progress) { display.show(progress); });
        found = diagnose::diagnose(plan.read.measurements, options);
    } catch (const core::NumericalError& error) { // every rank meets it
        if (is_root)
            print_error(error.what());
        return core::ExitCode::PointsFailed;
    }
    const json facts = provenance.document();
    return farm::on_root(communicator, [&] { return report(arguments, plan, found, facts); });
}

} // namespace culm::cli
