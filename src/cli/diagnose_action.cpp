// SPDX-License-Identifier: BSD-3-Clause
#include "cli/diagnose_action.hpp"

#include "cli/diagnose_candidates.hpp"
#include "cli/diagnose_json.hpp"
#include "cli/diagnose_text.hpp"
#include "cli/item_farm.hpp"
#include "cli/json_output.hpp"
#include "cli/step_display.hpp"
#include "cli/text_output.hpp"
#include "cli/work_over_ranks.hpp"
#include "measure/measurement_folder.hpp"

#include <filesystem>
#include <set>
#include <string_view>

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
        static_cast<void>(calibrate::chain_of(
            recording, {arguments.spheres, *physics::law_by_name(arguments.law)}));
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

json names_of(const diagnose::SelectedEffects& effects) {
    json names = json::array();
    for (const physics::SelectedEffect& selected : effects)
        names.push_back(physics::to_string(selected));
    return names;
}

json document_of(const DiagnoseArguments& arguments, const DiagnosisPlan& plan,
                 const diagnose::Diagnosis& found) {
    json document = diagnosis_json(found, plan.read.measurements, plan.effects.candidates);
    for (std::size_t k = 0; k < plan.read.folders.size(); ++k)
        document["recordings"][k]["folder"] = plan.read.folders[k].string();
    document["options"] = {{"law", arguments.law},
                           {"spheres", arguments.spheres ? json(*arguments.spheres) : json()},
                           {"window_s", arguments.window_s ? json(*arguments.window_s) : json()},
                           {"max_effects", arguments.most_effects},
                           {"candidates", names_of(plan.effects.candidates)},
                           {"known", names_of(plan.effects.known)}};
    return document;
}

/// As a shell reads it back.
std::string shell_word(const std::string& word) {
    constexpr std::string_view plain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ"
                                       "0123456789_-+=./,:@%";
    if (!word.empty() && word.find_first_not_of(plain) == std::string::npos)
        return word;
    std::string out = "'";
    for (const char letter : word)
        out += letter == '\'' ? std::string("'\\''") : std::string(1, letter);
    return out + "'";
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
    std::string text = effects.empty() ? "" : fmt::format(" --with {}", shell_word(effects));
    if (arguments.law != DiagnoseArguments{}.law)
        text += " --law " + arguments.law;
    if (arguments.spheres)
        text += fmt::format(" --spheres {}", *arguments.spheres);
    if (arguments.window_s)
        text += fmt::format(" --window {}", *arguments.window_s);
    return text;
}

/// What the user should type next.
std::string next_command(const DiagnoseArguments& arguments, const DiagnosisPlan& plan,
                         const diagnose::Diagnosis& found) {
    const std::string folder = shell_word(plan.read.folders.front().string());
    std::vector<std::string> effects;
    for (const std::string& effect : found.effects)
        effects.push_back(as_option(effect, plan.effects));
    std::string all;
    for (const fs::path& each : plan.read.folders)
        all += fmt::format(" {}", shell_word(each.string()));
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
                      const diagnose::Diagnosis& found) {
    const json document = document_of(arguments, plan, found);
    for (const measure::Measurement& recording : plan.read.measurements)
        for (const std::string& remark : recording.remarks)
            fmt::print(stderr, "culm: note: {}\n", remark);
    if (!arguments.json.empty())
        write_json(arguments.json, document);
    if (!arguments.output.empty()) {
        const fs::path folder = arguments.output;
        write_json((folder / "diagnosis.json").string(), document);
        if (found.missing_force && !found.missing_force->as_effect_file.empty())
            write_text(folder / force_file_name, found.missing_force->as_effect_file);
    }
    if (arguments.json != "-")
        fmt::print("{}", diagnosis_text(document, next_command(arguments, plan, found)));
    return document["failed"].empty() ? core::ExitCode::Done : core::ExitCode::PointsFailed;
}

} // namespace

core::ExitCode diagnose_measurements(const DiagnoseArguments& arguments,
                                     const farm::Communicator* communicator) {
    const DiagnosisPlan plan = make_plan(arguments);
    const bool is_root = communicator == nullptr || communicator->rank() == 0;
    static_cast<void>(report_on_root(communicator, [&arguments] {
        if (!arguments.output.empty())
            make_folder(arguments.output);
        return core::ExitCode::Done;
    }));
    diagnose::DiagnosisOptions options = options_of(arguments, plan);
    diagnose::Diagnosis found;
    try {
        StepDisplay display(arguments.is_quiet || !is_root);
        options.progress = [&display](const std::string& step) { display.begin(step); };
        options.map = work_over_ranks(
            communicator, [&display](const farm::Progress& progress) { display.show(progress); });
        found = diagnose::diagnose(plan.read.measurements, options);
    } catch (const core::NumericalError& error) { // every rank meets it
        if (is_root)
            fmt::print(stderr, "culm: {}\n", error.what());
        return core::ExitCode::PointsFailed;
    }
    return report_on_root(communicator, [&] { return report(arguments, plan, found); });
}

} // namespace culm::cli
