// SPDX-License-Identifier: BSD-3-Clause
// culm diagnose MEASUREMENT...: finds the effect that the recordings require, on all ranks.
#include "cli/interruption.hpp"
#include "cli/options.hpp"
#include "cli/progress.hpp"
#include "cli/provenance.hpp"
#include "cli/recordings.hpp"
#include "core/user_files.hpp"
#include "diagnose/diagnosis.hpp"
#include "farm/item_map.hpp"
#include "measure/folder/measurement_folder.hpp"
#include "present/answer_json.hpp"
#include "present/diagnosis.hpp"
#include "present/files.hpp"
#include "present/parameters.hpp"
#include "present/text.hpp"
#include "study/config/study_effects.hpp"

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <map>
#include <regex>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace culm::cli {
namespace {

namespace fs = std::filesystem;

constexpr const char* force_file_name = "missing_force.toml";

struct DiagnoseArguments : RecordingArguments {
    std::string candidates; ///< separated by commas; empty: all that apply
    std::vector<std::string> effect_files;
    std::string known;
    std::size_t most_effects = 3;
    bool resumes = false;
    std::string walltime;
    farm::Clock::time_point start = farm::Clock::now();
};

/// The inputs, which are read and checked before the first fit; identical on every rank.
struct DiagnosisPlan {
    measure::MeasurementSet read;
    std::vector<diagnose::Specimen> specimens; ///< several: a laboratory
    diagnose::DiagnosisOptions options;
    bool has_added_weight = false;            ///< to the known effects of the user
    std::map<std::string, std::string> files; ///< of users' effects, by name
};

void add_once(const physics::SelectedEffect& added, fit::SelectedEffects& effects) {
    if (fit::contains(effects, added))
        throw core::InputError(fmt::format("candidate {} is named twice", added.effect->name));
    effects.push_back(added);
}

/// The weight moves a stem that is held straight: where its direction is stated, gravity is known.
void add_weight(DiagnosisPlan& plan) {
    const std::vector<measure::Measurement>& recordings = plan.read.measurements;
    fit::SelectedEffects& known = plan.options.known;
    const auto is_moved = [](const measure::Measurement& each) {
        return each.gravity_direction == measure::GravityDirection::Transverse &&
               each.release == measure::ReleaseKind::HeldStraight;
    };
    const physics::SelectedEffect gravity = physics::parse_effect("gravity", {});
    plan.has_added_weight = !fit::contains(known, gravity) &&
                            std::ranges::count(recordings, measure::GravityDirection::None,
                                               &measure::Measurement::gravity_direction) == 0 &&
                            std::ranges::any_of(recordings, is_moved);
    if (plan.has_added_weight)
        known.push_back(gravity);
}

/// The effects that the diagnosis may name and those that are known, from the command line.
/// Candidates may exclude each other; if none is named, all that apply to the recordings are used.
/// The files are candidates too, known effects are not. Throws core::InputError for an unknown name
/// or invalid file, for an effect that is named twice, or if no candidate remains.
void add_effects(const DiagnoseArguments& arguments, DiagnosisPlan& plan) {
    const physics::EffectFileReader read = [&plan](const std::string& file) {
        physics::EffectPointer effect = study::read_effect_file(file);
        plan.files[effect->name] = file;
        return effect;
    };
    fit::SelectedEffects& known = plan.options.known;
    known = physics::parse_effects(arguments.known, read);
    add_weight(plan);
    known = fit::in_library_order(std::move(known));
    fit::SelectedEffects named;
    std::string candidates = arguments.candidates; // may name a file's effect
    for (const std::string& file : arguments.effect_files) {
        const std::string path = physics::is_effect_file(file) ? file : "./" + file;
        const std::regex name("\\b" + read(path)->name + "(?= *(,|\\(|$))");
        candidates = std::regex_replace(candidates, name, path);
        if (candidates.find(path) == std::string::npos)
            add_once(physics::parse_effect(path, read), named);
    }
    for (const physics::SelectedEffect& candidate :
         candidates.empty() ? fit::candidate_effects(plan.read.measurements)
                            : physics::parse_alternatives(candidates, read))
        add_once(candidate, named);
    std::erase_if(named, [&](const auto& one) { return fit::contains(known, one); });
    if (named.empty())
        throw core::InputError("no candidate is left: all of them are --known");
    plan.options.candidates = fit::in_library_order(std::move(named));
}

/// The name of the effect for --with: users' effects are named by their file.
std::string as_option(const std::string& effect, const DiagnosisPlan& plan) {
    const auto file = plan.files.find(effect);
    std::string name = file == plan.files.end() ? effect : file->second;
    for (const fit::SelectedEffects* selection : {&plan.options.known, &plan.options.candidates})
        for (const physics::SelectedEffect& selected : *selection)
            if (selected.effect->name == effect)
                return name + physics::to_string(selected).substr(effect.size());
    return name;
}

DiagnosisPlan plan_of(const DiagnoseArguments& arguments) {
    DiagnosisPlan plan;
    plan.options.candidate.chain = chain_options(arguments);
    plan.options.candidate.window = arguments.window_s;
    plan.options.most_effects = arguments.most_effects;
    plan.read = measure::read_measurements(arguments.paths);
    std::set<std::string> ids;
    for (const measure::Measurement& recording : plan.read.measurements) {
        if (!ids.insert(recording.stem.id).second)
            throw core::InputError(
                fmt::format("two recordings are called \"{}\"; give each its own stem.id in "
                            "stem.toml",
                            recording.stem.id));
        static_cast<void>(fit::chain_of(recording, plan.options.candidate.chain));
    }
    plan.specimens = diagnose::specimens_of(plan.read.measurements);
    add_effects(arguments, plan);
    return plan;
}

std::vector<fs::path> diagnosis_inputs(const DiagnosisPlan& plan) {
    std::vector<fs::path> files = measurement_files(plan.read.folders);
    for (const auto& [effect, file] : plan.files)
        files.emplace_back(file);
    return files;
}

/// "--with A,B" of the known and the `added` effects, and the chain's options.
std::string model_options(const DiagnoseArguments& arguments, const DiagnosisPlan& plan,
                          const std::vector<std::string>& added) {
    std::vector<std::string> effects;
    for (const physics::SelectedEffect& known : plan.options.known)
        effects.push_back(as_option(known.effect->name, plan));
    effects.insert(effects.end(), added.begin(), added.end());
    return model_words(arguments, effects);
}

/// The options that determine a diagnosis.
std::string same_options(const DiagnoseArguments& arguments) {
    std::string text = chain_words(arguments);
    const auto add = [&text](const char* option, const std::string& value) {
        if (!value.empty())
            text += option + as_words({value});
    };
    add(" --candidates", arguments.candidates);
    for (const std::string& file : arguments.effect_files)
        add(" --effect-file", file);
    add(" --known", arguments.known);
    if (arguments.most_effects != DiagnoseArguments{}.most_effects)
        text += fmt::format(" --max-effects {}", arguments.most_effects);
    return text;
}

/// The suggested next command.
std::string next_command(const DiagnoseArguments& arguments, const DiagnosisPlan& plan,
                         const diagnose::Diagnosis& found) {
    const std::string folder = as_words({plan.read.folders.front().string()});
    const std::string all = as_words({plan.read.folders.begin(), plan.read.folders.end()});
    std::vector<std::string> effects;
    for (const std::string& effect : found.effects)
        effects.push_back(as_option(effect, plan));
    switch (found.conclusion) {
    case diagnose::Conclusion::Adequate:
        return "culm calibrate" + folder + model_options(arguments, plan, {}) + " --check";
    case diagnose::Conclusion::Effect:
        return "culm compare" + folder + model_options(arguments, plan, effects);
    case diagnose::Conclusion::Tie:
        return "culm diagnose" + all + " NEW_RECORDING" + same_options(arguments) +
               " (all with the same stem.specimen)";
    case diagnose::Conclusion::Unknown:
        break;
    }
    if (!found.missing_force || found.missing_force->as_effect_file.empty())
        return "culm compare" + folder + model_options(arguments, plan, {}) +
               " (where, when and how it fails)";
    if (arguments.output.empty())
        return "culm diagnose" + all + same_options(arguments) +
               " -o DIR (writes the force as DIR/" + force_file_name + ", an effect for --with)";
    return "culm compare" + folder +
           model_options(arguments, plan,
                         {(fs::path(arguments.output) / force_file_name).string()});
}

/// deflections.csv of the first recording, deflections_2.csv of the second, …: the motion of the
/// published chain and, if it is a different model, of the best one.
void write_deflections(const fs::path& folder, const diagnose::Diagnosis& found,
                       std::span<const measure::Measurement> recordings) {
    std::vector<const fit::Fit*> fits{&found.baseline};
    if (!found.final_fit.failed() && found.final_fit.names() != found.baseline.names())
        fits.push_back(&found.final_fit);
    for (std::size_t k = 0; k < recordings.size(); ++k) {
        std::vector<std::pair<std::string, const fit::RecordingFit*>> models;
        for (const fit::Fit* fit : fits)
            if (k < fit->parts.size())
                models.emplace_back(present::model_name(fit->names()), &fit->parts[k]);
        const std::string name =
            k == 0 ? "deflections.csv" : fmt::format("deflections_{}.csv", k + 1);
        core::write_text(folder / name, present::deflections_csv(recordings[k], models));
    }
}

core::ExitCode report(const DiagnoseArguments& arguments, const DiagnosisPlan& plan,
                      const diagnose::Diagnosis& found, const present::Provenance& provenance) {
    const bool is_one = plan.specimens.size() == 1;
    present::DiagnosisReport report{found, plan.read.measurements, plan.options};
    report.folders.assign(plan.read.folders.begin(), plan.read.folders.end());
    report.provenance = provenance;
    write_results(arguments, plan.read.measurements, is_one ? "diagnosis.json" : "laboratory.json",
                  present::diagnosis_json(report));
    if (is_one && !arguments.output.empty()) {
        const fs::path folder = arguments.output;
        write_deflections(folder, found, plan.read.measurements);
        if (found.missing_force && !found.missing_force->as_effect_file.empty())
            core::write_text(folder / force_file_name, found.missing_force->as_effect_file);
    }
    if (arguments.prints_text())
        fmt::print("{}{}", present::diagnosis_text(report, arguments.with_details),
                   is_one ? next_step(arguments, next_command(arguments, plan, found)) : "");
    const auto has_failed = [](const auto& each) { return !each.failure.empty(); };
    const bool any_failed = is_one ? std::ranges::any_of(found.posterior.models, has_failed)
                                   : std::ranges::any_of(found.stems, has_failed);
    return any_failed ? core::ExitCode::PointsFailed : core::ExitCode::Done;
}

/// The fits of an interrupted diagnosis, in the folder of --output; null without one and on other
/// ranks. Collective.
std::unique_ptr<KeptItems> kept_fits(const DiagnoseArguments& arguments, const DiagnosisPlan& plan,
                                     const RunProvenance& provenance,
                                     const farm::Communicator* communicator) {
    std::unique_ptr<KeptItems> kept;
    static_cast<void>(farm::on_root(communicator, [&] {
        if (arguments.output.empty())
            return core::ExitCode::Done;
        core::create_folder(arguments.output);
        const nlohmann::json identity = {{"program", version_text()},
                                         {"options", core::json_of(plan.options)},
                                         {"inputs", core::json_value(provenance.inputs(), 1.0)}};
        kept = std::make_unique<KeptItems>(arguments.output, identity.dump(1), arguments.resumes);
        if (kept->size() > 0 && !arguments.is_quiet)
            print_note(fmt::format("{} kept in {} are not computed again",
                                   present::counted(kept->size(), "fit"), arguments.output));
        return core::ExitCode::Done;
    }));
    return kept;
}

farm::ItemOptions item_options(const DiagnoseArguments& arguments, StepDisplay& display,
                               KeptItems* kept, const farm::Communicator* communicator) {
    farm::ItemOptions options;
    options.progress = [&display](const farm::Progress& progress) { display.show(progress); };
    options.progress_interval = std::chrono::milliseconds(200);
    if (arguments.output.empty())
        return options;
    options.stop_requested = stop_after_signal(communicator, "the fits", arguments.output);
    if (const auto deadline = run_deadline(arguments.walltime, arguments.start, communicator))
        options.deadline = deadline->time;
    options.store = kept == nullptr ? farm::ItemStore() : kept->store(); // called on rank 0 only
    return options;
}

core::ExitCode stopped_early(const DiagnoseArguments& arguments, bool prints) {
    if (prints)
        print_error(fmt::format("stopped early; the fits computed so far are kept in {}. Continue "
                                "with --resume.",
                                arguments.output));
    return core::ExitCode::StoppedEarly;
}

/// Recordings that state no specimen are different stems, which their user may not expect.
void remark_on_specimens(const DiagnosisPlan& plan) {
    std::vector<std::string> silent;
    for (const measure::Measurement& recording : plan.read.measurements)
        if (recording.specimen.empty())
            silent.push_back(recording.stem.id);
    if (silent.size() > 1)
        fmt::print(stderr,
                   "{} state no stem.specimen: each is taken as another stem. Recordings of one "
                   "stem need the same stem.specimen in stem.toml.\n",
                   fmt::join(silent, ", "));
}

core::ExitCode diagnose_measurements(const DiagnoseArguments& arguments,
                                     const farm::Communicator* communicator) {
    const DiagnosisPlan plan = plan_of(arguments);
    const RunProvenance provenance(diagnosis_inputs(plan), communicator);
    const std::unique_ptr<KeptItems> kept = kept_fits(arguments, plan, provenance, communicator);
    if (plan.has_added_weight && !arguments.is_silent(communicator))
        print_note("held_straight: the weight moves the stem, so gravity is part of every model");
    if (plan.specimens.size() > 1 && !arguments.is_silent(communicator))
        remark_on_specimens(plan);
    diagnose::DiagnosisOptions options = plan.options;
    diagnose::Diagnosis found;
    try {
        StepDisplay display(arguments.is_quiet || !is_root(communicator));
        options.progress = [&display](const std::string& step) { display.begin(step); };
        options.map = farm::over_ranks(communicator,
                                       item_options(arguments, display, kept.get(), communicator));
        found = diagnose::diagnose(plan.specimens, options);
    } catch (const core::StorageError& error) { // every rank meets it
        if (is_root(communicator))
            print_error(error.what());
        return stopped_early(arguments, is_root(communicator));
    } catch (const core::MapStopped&) {
        return stopped_early(arguments, is_root(communicator));
    } catch (const core::NumericalError& error) { // every rank meets it
        if (is_root(communicator))
            print_error(error.what());
        return core::ExitCode::PointsFailed;
    }
    const present::Provenance facts = provenance.document();
    return farm::on_root(communicator, [&] {
        const core::ExitCode code = report(arguments, plan, found, facts);
        if (kept)
            kept->remove();
        return code;
    });
}

void add_effect_options(CLI::App& command, DiagnoseArguments& arguments) {
    add_option(command, "--candidates", arguments.candidates, "EFFECT,...",
               "Try only these effects (default: all of `culm effects` that apply to the "
               "recording)");
    add_option(command, "--effect-file", arguments.effect_files, "FILE",
               "One more candidate, defined in a TOML file (docs/effects.md); may be repeated")
        ->allow_extra_args(false);
    add_option(command, "--known", arguments.known, "EFFECT,...",
               "Effects that are known to act, part of every model: gravity, "
               "relaxation(hold_time_s=3), ...; parameters without a value are fitted");
    add_option(command, "--max-effects", arguments.most_effects, "N",
               "Name at most N effects (default: 3)")
        ->check(CLI::Range(1, 6));
    CLI::Option* output = command.get_option("--output");
    command
        .add_flag("--resume", arguments.resumes,
                  "Continue an interrupted diagnosis in the folder of --output: compute only the "
                  "fits that it does not have; refuses changed inputs and options")
        ->needs(output);
    add_option(command, "--walltime", arguments.walltime, "TIME",
               "End within this time (90s, 45min, HH:MM:SS); exit code 75 if fits are missing "
               "(default: the time limit of the batch job)")
        ->needs(output);
}

} // namespace

void add_diagnose_command(CLI::App& app, core::ExitCode& exit_code, int& argc, char**& argv) {
    CLI::App* command = app.add_subcommand(
        "diagnose", "Find which effect is missing from the published chain, with its uncertainty, "
                    "and which effects the recording cannot detect");
    auto arguments = std::make_shared<DiagnoseArguments>();
    add_recording_options(*command, *arguments,
                          "Measurement folders, or folders that contain some. Recordings of one "
                          "stem.specimen are explained together; several specimens are a "
                          "laboratory, whose stems on one stem.rig share its clamp, air and camera",
                          "Folder for diagnosis.json or laboratory.json and, where no effect of "
                          "the library suffices, missing_force.toml",
                          "Use");
    add_effect_options(*command, *arguments);
    add_chain_options(*command, *arguments);
    command->parse_complete_callback([arguments] { // before MPI starts
        if (!arguments->output.empty())
            watch_stop_signals();
    });
    run_on_ranks(*command, arguments, exit_code, argc, argv, diagnose_measurements);
}

} // namespace culm::cli
