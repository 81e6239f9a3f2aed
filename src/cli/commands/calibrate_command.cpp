// SPDX-License-Identifier: BSD-3-Clause
// culm calibrate MEASUREMENT...: many stems spread over the ranks of a launcher.
#include "calibrate/calibration.hpp"
#include "calibrate/shared_effects.hpp"
#include "calibrate/study_calibration.hpp"
#include "cli/options.hpp"
#include "cli/progress.hpp"
#include "cli/provenance.hpp"
#include "cli/recordings.hpp"
#include "core/order_statistics.hpp"
#include "core/user_files.hpp"
#include "farm/item_map.hpp"
#include "measure/folder/measurement_folder.hpp"
#include "present/calibration.hpp"
#include "present/files.hpp"
#include "present/laboratory.hpp"
#include "present/text.hpp"
#include "study/config/study_effects.hpp"
#include "study/execute/study_folder.hpp"
#include "study/summary/summary.hpp"

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>

namespace culm::cli {
namespace {

namespace fs = std::filesystem;

struct CalibrateArguments : RecordingArguments {
    std::string via;
    std::string effects;
    bool is_each_alone = false;
};

/// The inputs, which are read and checked before the first fit; identical on every rank.
struct CalibrationPlan {
    measure::MeasurementSet read;
    calibrate::CalibrationOptions options;
    std::optional<calibrate::StudyForCalibration> study;
    calibrate::SharedEffects shared; ///< fitted to all recordings first
};

/// Throws core::InputError if the folder holds no complete study of free vibrations.
calibrate::StudyForCalibration study_for_calibration(const std::string& folder) {
    const study::ArchivedStudy archived = study::open_archive(study::StudyFolder(folder));
    study::StudySummary summary = study::reduce_study(archived, std::nullopt);
    calibrate::StudyForCalibration found;
    found.name = folder;
    found.base = archived.study.config.base;
    for (const study::Factor& factor : archived.study.design.factors)
        if (const std::string key(factor.parameter->key);
            !key.starts_with("bond_youngs_modulus") && key != "bond_damping")
            found.factors.push_back(key);
    found.window = summary.reduce.window;
    found.bond_youngs_modulus = core::range_of(summary.youngs_modulus);
    found.bond_damping = core::range_of(summary.bond_damping);
    found.regression = std::move(summary.regression);
    return found;
}

CalibrationPlan plan_of(const CalibrateArguments& arguments) {
    CalibrationPlan plan;
    plan.read = measure::read_measurements(arguments.paths);
    plan.options.fit.chain = chain_options(arguments);
    plan.options.fit.window = arguments.window_s;
    if (!arguments.effects.empty())
        plan.options.effects = study::effects_from(arguments.effects);
    if (!arguments.via.empty())
        plan.study = study_for_calibration(arguments.via);
    for (const measure::Measurement& measurement : plan.read.measurements)
        static_cast<void>(fit::chain_of(measurement, plan.options.fit.chain));
    return plan;
}

std::vector<fs::path> calibration_inputs(const CalibrateArguments& arguments,
                                         const CalibrationPlan& plan) {
    std::vector<fs::path> files = measurement_files(plan.read.folders);
    std::ranges::copy(effect_files(arguments.effects), std::back_inserter(files));
    if (!arguments.via.empty())
        files.push_back(study::StudyFolder(arguments.via).archive());
    return files;
}

/// The results of a stem, as they are sent between ranks.
struct StemAnswer {
    std::string document;                          ///< JSON
    std::string text;                              ///< of one stem alone
    std::string line;                              ///< of the table
    std::string by_study;                          ///< of --via
    std::optional<calibrate::StemNumbers> numbers; ///< nothing: it could not be calibrated
};

/// A stem that could not be calibrated: its failure and its texts in the answer.
void refuse(std::string reason, present::CalibratedStem& stem, StemAnswer& answer) {
    const std::string& id = stem.id;
    if (reason.starts_with(id + ": "))
        reason.erase(0, id.size() + 2);
    answer.text = fmt::format("{}: FAILED: {}\n", id, reason);
    answer.line = fmt::format("{:<14} failed: {}\n", id, reason);
    stem.failure = reason;
}

void calibrate_chain(const CalibrationPlan& plan, std::size_t index,
                     const CalibrateArguments& arguments, const run::Heartbeat& heartbeat,
                     present::CalibratedStem& stem, StemAnswer& answer) {
    const measure::Measurement& measurement = plan.read.measurements[index];
    const std::string& law = arguments.law;
    try {
        calibrate::CalibrationOptions options =
            calibrate::with_shared_values(plan.options, plan.shared, measurement);
        options.fit.heartbeat = heartbeat;
        calibrate::Calibration found = calibrate::calibrate_stem(measurement, options);
        calibrate::add_shared_uncertainty(plan.shared, measurement, found);
        answer.text = present::calibration_text(found, law, arguments.with_details);
        answer.line = present::calibration_table_line(found);
        answer.numbers = calibrate::numbers_of(found);
        if (!arguments.output.empty())
            core::write_text(fs::path(arguments.output) / "predictions" /
                                 fmt::format("{:03}.csv", index + 1),
                             present::deflections_csv(measurement, {{"predicted", &found.part()}}));
        stem.calibration = std::move(found);
    } catch (const core::InputError& error) {
        refuse(error.what(), stem, answer);
    } catch (const core::NumericalError& error) {
        refuse(error.what(), stem, answer);
    }
}

/// The stem's Y and β by the study's regressions.
void calibrate_by_study(const CalibrationPlan& plan, std::size_t index,
                        const CalibrateArguments& arguments, present::CalibratedStem& stem,
                        StemAnswer& answer) {
    stem.study = arguments.via;
    const std::string law = physics::law_name(plan.study->base.law);
    try {
        calibrate::StudyCalibration found =
            calibrate::calibrate_by_study(plan.read.measurements[index], *plan.study);
        if (law != arguments.law)
            found.warnings.push_back(
                fmt::format("the study has the law {}, the chain above {}: the two beta differ. "
                            "--law {} calibrates the chain with the law of the study",
                            law, arguments.law, law));
        answer.by_study = present::study_calibration_text(found, arguments.via, law);
        stem.by_study = std::move(found);
    } catch (const core::NumericalError& error) {
        answer.by_study = fmt::format("  by the study: not possible: {}\n", error.what());
        stem.study_failure = error.what();
    }
}

present::CalibratedStem stem_of(const CalibrationPlan& plan, std::size_t index,
                                const CalibrateArguments& arguments) {
    present::CalibratedStem stem;
    stem.id = plan.read.measurements[index].stem.id;
    stem.folder = plan.read.folders[index].string();
    stem.law = arguments.law;
    return stem;
}

StemAnswer answer_of(const CalibrationPlan& plan, std::size_t index,
                     const CalibrateArguments& arguments, const run::Heartbeat& heartbeat) {
    StemAnswer answer;
    present::CalibratedStem stem = stem_of(plan, index, arguments);
    calibrate_chain(plan, index, arguments, heartbeat, stem, answer);
    if (plan.study)
        calibrate_by_study(plan, index, arguments, stem, answer);
    answer.document = present::stem_document(stem);
    return answer;
}

/// The answers of all stems, including those whose calibration threw.
std::vector<StemAnswer> all_answers(const CalibrationPlan& plan,
                                    const CalibrateArguments& arguments,
                                    std::vector<core::ItemOutcome<StemAnswer>> outcomes) {
    std::vector<StemAnswer> answers;
    for (std::size_t i = 0; i < outcomes.size(); ++i) {
        StemAnswer answer = std::move(outcomes[i].value).value_or(StemAnswer());
        if (!outcomes[i].value) {
            present::CalibratedStem stem = stem_of(plan, i, arguments);
            refuse(outcomes[i].failure, stem, answer);
            answer.document = present::stem_document(stem);
        }
        answers.push_back(std::move(answer));
    }
    return answers;
}

std::optional<calibrate::Population> population_of(const std::vector<StemAnswer>& answers) {
    std::vector<calibrate::StemNumbers> calibrated;
    for (const StemAnswer& answer : answers)
        if (answer.numbers)
            calibrated.push_back(*answer.numbers);
    return calibrate::population_of(calibrated, answers.size() - calibrated.size());
}

present::CalibrationDocument document_of(const CalibrateArguments& arguments,
                                         const CalibrationPlan& plan,
                                         const std::vector<StemAnswer>& answers,
                                         const std::optional<calibrate::Population>& population,
                                         const present::Provenance& provenance) {
    present::CalibrationDocument document{arguments.law,
                                          arguments.effects,
                                          arguments.window_s,
                                          plan.shared.effects,
                                          population,
                                          {},
                                          {},
                                          provenance};
    for (const StemAnswer& answer : answers)
        document.stems.push_back(answer.document);
    for (const measure::Measurement& measurement : plan.read.measurements)
        std::ranges::copy(measurement.remarks, std::back_inserter(document.remarks));
    return document;
}

/// One stem as some lines; several as a table, followed by the population.
std::string calibrations_text(const CalibrationPlan& plan, const std::vector<StemAnswer>& answers,
                              const std::optional<calibrate::Population>& population) {
    if (answers.size() == 1)
        return answers.front().text + (answers.front().numbers ? answers.front().by_study : "");
    std::string text =
        present::rig_effects_text(plan.shared.effects) + present::calibration_table_head();
    for (const StemAnswer& answer : answers)
        text += answer.line;
    text += "(± is half of the 95 % interval; still air: its bias of Y, which --with still_air "
            "removes)\n";
    if (population)
        text += present::population_text(*population);
    for (std::size_t i = 0; i < answers.size(); ++i)
        if (!answers[i].by_study.empty())
            text += plan.read.measurements[i].stem.id + '\n' + answers[i].by_study;
    return text;
}

/// "culm COMMAND" for the same recordings with the same model.
std::string same_model(const std::string& command, const std::vector<std::string>& paths,
                       const CalibrateArguments& arguments) {
    return "culm " + command + as_words(paths) + model_words(arguments, {arguments.effects});
}

/// The suggested next command, empty after a failure: export what is adequate, else show for the
/// first inadequate recording where the model fails or which effect is missing.
std::string next_command(const CalibrateArguments& arguments, const CalibrationPlan& plan,
                         const std::vector<StemAnswer>& answers) {
    const auto failed = std::ranges::find_if_not(answers, [](const StemAnswer& answer) {
        return answer.numbers && answer.numbers->is_adequate;
    });
    if (failed != answers.end() && !failed->numbers)
        return {}; // nothing follows from a failure
    if (failed != answers.end()) {
        const auto place = static_cast<std::size_t>(failed - answers.begin());
        return same_model(arguments.effects.empty() ? "diagnose" : "compare",
                          {plan.read.folders[place].string()}, arguments);
    }
    const std::string code = arguments.law == "consistent" ? "lammps" : "liggghts";
    if (!arguments.json.empty() || !arguments.output.empty())
        return "culm export " + code +
               as_words({arguments.json.empty()
                             ? (fs::path(arguments.output) / "calibration.json").string()
                             : arguments.json});
    return same_model("calibrate", arguments.paths, arguments) +
           " --json calibration.json && culm export " + code + " calibration.json";
}

/// Rank 0 writes and prints; the exit code.
core::ExitCode report(const CalibrateArguments& arguments, const CalibrationPlan& plan,
                      const std::vector<StemAnswer>& answers,
                      const present::Provenance& provenance) {
    const std::optional<calibrate::Population> population = population_of(answers);
    const nlohmann::json document =
        present::calibration_json(document_of(arguments, plan, answers, population, provenance));
    write_results(arguments, plan.read.measurements, "calibration.json", document);
    if (arguments.prints_text())
        fmt::print("{}{}", calibrations_text(plan, answers, population),
                   next_step(arguments, next_command(arguments, plan, answers)));
    const bool all_calibrated =
        std::ranges::all_of(answers, [](const auto& answer) { return answer.numbers.has_value(); });
    return all_calibrated ? core::ExitCode::Done : core::ExitCode::PointsFailed;
}

core::ExitCode calibrate_measurements(const CalibrateArguments& arguments,
                                      const farm::Communicator* communicator) {
    CalibrationPlan plan = plan_of(arguments);
    const RunProvenance provenance(calibration_inputs(arguments, plan), communicator);
    const bool is_quiet = arguments.is_silent(communicator);
    if (!arguments.output.empty())
        core::create_folder(fs::path(arguments.output) / "predictions");
    try {
        StepDisplay display(is_quiet);
        if (!arguments.is_each_alone)
            plan.shared = calibrate::fit_shared_effects(
                plan.read.measurements, plan.options, farm::over_ranks(communicator),
                [&display](const std::string& step) { display.begin(step); });
    } catch (const core::NumericalError& error) { // every rank meets it
        if (is_root(communicator))
            print_error(error.what());
        return core::ExitCode::PointsFailed;
    }
    std::vector<double> costs;
    for (const measure::Measurement& measurement : plan.read.measurements)
        costs.push_back(double(measurement.deflections.size()));
    StepDisplay step(is_quiet || costs.size() > 1);
    ProgressDisplay display(is_quiet || costs.size() < 2, "stems");
    const farm::ItemOptions options{
        .progress = [&display](const farm::Progress& progress) { display.show(progress); }};
    std::vector<core::ItemOutcome<StemAnswer>> outcomes =
        farm::over_ranks(communicator, options)
            .outcomes(
                costs,
                [&](std::size_t index, const run::Heartbeat& heartbeat) {
                    return answer_of(plan, index, arguments, [&] {
                        step.keep_alive();
                        return !heartbeat || heartbeat();
                    });
                },
                [](const StemAnswer& answer) { return !answer.numbers; });
    display.finish();
    step.finish();
    const present::Provenance facts = provenance.document();
    const std::vector<StemAnswer> answers = all_answers(plan, arguments, std::move(outcomes));
    return farm::on_root(communicator, [&] { return report(arguments, plan, answers, facts); });
}

void add_calibration_options(CLI::App& command, CalibrateArguments& arguments) {
    add_option(command, "--via", arguments.via, "STUDY_DIR",
               "Also calibrate by this study's regressions (Eqs. 12-13 and F-test terms)");
    command
        .add_option(
            "--with", arguments.effects,
            "Effects that are known to act, added to the published chain (`culm effects`): "
            "gravity, quadratic_drag(drag_coefficient=1.2), ...; parameters without a value "
            "are fitted, those of clamp, air and camera with one value for all recordings of one "
            "stem.rig")
        ->type_name("EFFECT,...");
    command.add_flag("--each-alone", arguments.is_each_alone,
                     "Fit every parameter of --with to each recording alone");
}

} // namespace

void add_calibrate_command(CLI::App& app, core::ExitCode& exit_code, int& argc, char**& argv) {
    CLI::App* command = app.add_subcommand(
        "calibrate", "Fit the chain to measured stems: Y and beta with their uncertainty");
    auto arguments = std::make_shared<CalibrateArguments>();
    add_recording_options(*command, *arguments,
                          "Measurement folders, or folders that contain some; shared among the "
                          "ranks of mpirun",
                          "Folder for calibration.json and the measured and predicted deflections",
                          "Fit");
    add_calibration_options(*command, *arguments);
    add_chain_options(*command, *arguments);
    run_on_ranks(*command, arguments, exit_code, argc, argv, calibrate_measurements);
}

} // namespace culm::cli
