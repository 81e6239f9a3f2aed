// SPDX-License-Identifier: BSD-3-Clause
#include "cli/calibrate_action.hpp"

#include "cli/calibration_json.hpp"
#include "cli/calibration_table.hpp"
#include "cli/fit_cost.hpp"
#include "cli/next_step.hpp"
#include "cli/progress_display.hpp"
#include "cli/run_provenance.hpp"
#include "cli/study_for_calibration.hpp"
#include "cli/text_output.hpp"
#include "cli/text_style.hpp"
#include "farm/item_map.hpp"
#include "measure/folder/measurement_folder.hpp"
#include "present/json.hpp"
#include "study/config/study_effects.hpp"
#include "study/execute/study_folder.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include <fmt/format.h>

namespace culm::cli {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// Everything that is read and checked before the first fit; the same on every rank.
struct CalibrationPlan {
    measure::MeasurementSet read;
    calibrate::CalibrationOptions options;
    std::optional<calibrate::StudyForCalibration> study;
};

CalibrationPlan make_plan(const CalibrateArguments& arguments) {
    CalibrationPlan plan;
    plan.read = measure::read_measurements(arguments.paths);
    plan.options.chain = {arguments.spheres, *physics::law_by_name(arguments.law)};
    plan.options.fit.window = arguments.window_s;
    plan.options.fit.is_robust = arguments.is_robust;
    if (!arguments.effects.empty())
        plan.options.effects = study::effects_from(arguments.effects);
    plan.options.with_profiles = arguments.with_profiles;
    plan.options.with_check = arguments.with_check;
    if (!arguments.via.empty())
        plan.study = study_for_calibration(arguments.via);
    for (const measure::Measurement& measurement : plan.read.measurements)
        static_cast<void>(fit::chain_of(measurement, plan.options.chain));
    return plan;
}

/// DIR/predictions/NNN.csv: of every frame and height the measured and the predicted deflection.
void write_prediction(const fs::path& file, const measure::Measurement& measurement,
                      const fit::RecordingFit& fit) {
    std::string text = "time_s";
    for (const double height : measurement.heights)
        text += fmt::format(",measured h={0:.10g}mm,predicted h={0:.10g}mm", 1e3 * height);
    text += '\n';
    const auto cell = [](double deflection) {
        return std::isnan(deflection) ? std::string(",") : fmt::format(",{:.6g}", 1e3 * deflection);
    };
    const std::size_t rows = measurement.heights.size();
    for (std::size_t i = 0; i < fit.times.size(); ++i) {
        text += fmt::format("{:.9g}", fit.times[i]);
        for (std::size_t j = 0; j < rows; ++j)
            text +=
                cell(measurement.deflection(i, j)) + cell(fit.prediction.readings[i * rows + j]);
        text += '\n';
    }
    write_text(file, text);
}

json failure_json(const measure::Measurement& measurement, const char* reason) {
    return {{"measurement", measurement.stem.id}, {"failure", reason}};
}

json calibrate_one(const CalibrationPlan& plan, std::size_t index,
                   const CalibrateArguments& arguments, const run::Heartbeat& heartbeat) {
    const measure::Measurement& measurement = plan.read.measurements[index];
    json stem;
    try {
        calibrate::CalibrationOptions options = plan.options;
        options.fit.heartbeat = heartbeat;
        const calibrate::Calibration found = calibrate::calibrate_stem(measurement, options);
        stem = calibration_json(found, arguments.law);
        if (!arguments.output.empty())
            write_prediction(fs::path(arguments.output) / "predictions" /
                                 fmt::format("{:03}.csv", index + 1),
                             measurement, found.fit);
    } catch (const core::InputError& error) {
        stem = failure_json(measurement, error.what());
    } catch (const core::NumericalError& error) {
        stem = failure_json(measurement, error.what());
    }
    if (plan.study) {
        try {
            stem["via"] = study_calibration_json(
                calibrate::calibrate_by_study(measurement, *plan.study), arguments.via);
        } catch (const core::NumericalError& error) {
            stem["via"] = {{"failure", error.what()}};
        }
    }
    stem["folder"] = plan.read.folders[index].string();
    return stem;
}

json make_document(const CalibrateArguments& arguments, const CalibrationPlan& plan, json stems,
                   const json& provenance) {
    json remarks = json::array();
    for (const measure::Measurement& measurement : plan.read.measurements)
        for (const std::string& remark : measurement.remarks)
            remarks.push_back(remark);
    json document{{"format", "culm-calibration"}, {"version", 1}};
    document["options"] = {{"law", arguments.law},
                           {"with", arguments.effects},
                           {"window_s", arguments.window_s ? json(*arguments.window_s) : json()},
                           {"robust", arguments.is_robust}};
    document["population"] = population_json(stems);
    document["stems"] = std::move(stems);
    document["remarks"] = std::move(remarks);
    document["provenance"] = provenance;
    return document;
}

std::vector<fs::path> input_files(const CalibrateArguments& arguments,
                                  const CalibrationPlan& plan) {
    std::vector<fs::path> files = measurement_files(plan.read.folders);
    for (const fs::path& file : effect_files(arguments.effects))
        files.push_back(file);
    if (!arguments.via.empty())
        files.push_back(study::StudyFolder(arguments.via).archive());
    return files;
}

/// What the user should type next: where, when and how the model fails.
std::string next_command(const CalibrateArguments& arguments, const CalibrationPlan& plan) {
    std::string command = "culm compare";
    if (plan.read.folders.size() > 1)
        command += " --table" + as_words(arguments.paths);
    else
        command += as_words({plan.read.folders.front().string()});
    if (!arguments.effects.empty())
        command += " --with" + as_words({arguments.effects});
    return command + model_words(arguments.law, arguments.spheres, arguments.window_s);
}

/// The JSON of a stem on its way between ranks.
struct StemAnswer {
    std::string document;
    bool has_failed = false;
};

template <class Wire>
void fields(Wire& wire, StemAnswer& answer) {
    wire(answer.document, answer.has_failed);
}

json stems_json(const CalibrationPlan& plan,
                const std::vector<core::ItemOutcome<StemAnswer>>& outcomes) {
    json stems = json::array();
    for (std::size_t i = 0; i < outcomes.size(); ++i)
        stems.push_back(outcomes[i].value ? json::parse(outcomes[i].value->document)
                                          : json{{"measurement", plan.read.measurements[i].stem.id},
                                                 {"folder", plan.read.folders[i].string()},
                                                 {"failure", outcomes[i].failure}});
    return stems;
}

/// Rank 0 writes and prints; the exit code.
core::ExitCode report(const CalibrateArguments& arguments, const CalibrationPlan& plan, json stems,
                      const json& provenance) {
    const bool any_failed =
        std::ranges::any_of(stems, [](const json& stem) { return stem.contains("failure"); });
    const json document = make_document(arguments, plan, std::move(stems), provenance);
    for (const json& remark : document["remarks"])
        print_note(remark.get<std::string>());
    if (!arguments.json.empty())
        present::write_json(arguments.json, document);
    if (!arguments.output.empty())
        present::write_json((fs::path(arguments.output) / "calibration.json").string(), document);
    if (arguments.json != "-")
        fmt::print("{}{}", calibration_table(document, TextStyle::of(stdout)),
                   next_step(next_command(arguments, plan)));
    return any_failed ? core::ExitCode::PointsFailed : core::ExitCode::Done;
}

} // namespace

core::ExitCode calibrate_measurements(const CalibrateArguments& arguments,
                                      const farm::Communicator* communicator) {
    const CalibrationPlan plan = make_plan(arguments);
    const RunProvenance provenance(input_files(arguments, plan), communicator);
    const bool is_quiet = arguments.is_quiet || arguments.json == "-" ||
                          (communicator != nullptr && communicator->rank() != 0);
    if (!is_quiet)
        fmt::print(stderr, "{}",
                   cost_of_calibration(plan.read.measurements, plan.options,
                                       communicator == nullptr ? 1 : communicator->size()));
    if (!arguments.output.empty())
        make_folder(fs::path(arguments.output) / "predictions");
    std::vector<double> costs;
    for (const measure::Measurement& measurement : plan.read.measurements)
        costs.push_back(std::max(measurement.times.back(), 1e-3));
    const auto work = [&](std::size_t index, const run::Heartbeat& heartbeat) {
        const json stem = calibrate_one(plan, index, arguments, heartbeat);
        return StemAnswer{stem.dump(), stem.contains("failure")};
    };
    ProgressDisplay display(is_quiet || costs.size() < 2, "stems");
    const farm::ItemOptions options{
        .progress = [&display](const farm::Progress& progress) { display.show(progress); }};
    const std::vector<core::ItemOutcome<StemAnswer>> outcomes =
        farm::over_ranks(communicator, options).outcomes(costs, work, [](const StemAnswer& answer) {
            return answer.has_failed;
        });
    display.finish();
    const json facts = provenance.document();
    return farm::on_root(
        communicator, [&] { return report(arguments, plan, stems_json(plan, outcomes), facts); });
}

} // namespace culm::cli
