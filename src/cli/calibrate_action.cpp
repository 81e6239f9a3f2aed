// SPDX-License-Identifier: BSD-3-Clause
#include "cli/calibrate_action.hpp"

#include "cli/calibration_json.hpp"
#include "cli/calibration_table.hpp"
#include "cli/json_output.hpp"
#include "cli/study_for_calibration.hpp"
#include "cli/text_output.hpp"
#include "farm/farm.hpp"
#include "measure/measurement_folder.hpp"
#include "study/effect_file.hpp"

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
    std::vector<measure::Measurement> measurements;
    std::vector<std::string> folders;
    calibrate::CalibrationOptions options;
    std::optional<calibrate::StudyForCalibration> study;
};

CalibrationPlan make_plan(const CalibrateArguments& arguments) {
    CalibrationPlan plan;
    std::string faults;
    for (const std::string& path : arguments.paths)
        for (const fs::path& folder : measure::find_measurements(path)) {
            try {
                plan.measurements.push_back(measure::read_measurement(folder));
                plan.folders.push_back(folder.string());
            } catch (const core::InputError& error) {
                faults += (faults.empty() ? "" : "\n") + std::string(error.what());
            }
        }
    if (!faults.empty())
        throw core::InputError(faults);
    plan.options.chain = {arguments.spheres, *physics::law_by_name(arguments.law)};
    plan.options.fit.window = arguments.window_s;
    plan.options.fit.is_robust = arguments.is_robust;
    if (!arguments.effects.empty())
        plan.options.effects = study::effects_from(arguments.effects);
    plan.options.with_profiles = arguments.with_profiles;
    plan.options.with_check = arguments.with_check;
    if (!arguments.via.empty())
        plan.study = study_for_calibration(arguments.via);
    for (const measure::Measurement& measurement : plan.measurements)
        static_cast<void>(calibrate::chain_of(measurement, plan.options.chain));
    return plan;
}

/// DIR/predictions/NNN.csv: of every frame and height the measured and the predicted deflection.
void write_prediction(const fs::path& file, const measure::Measurement& measurement,
                      const calibrate::ChainFit& fit) {
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
    const measure::Measurement& measurement = plan.measurements[index];
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
    stem["folder"] = plan.folders[index];
    return stem;
}

/// Every rank's stems, in the order of the measurements, on rank 0. What no rank has done is null.
json gather(const std::vector<json>& own, const farm::Communicator* communicator) {
    json all = json::array();
    for (const json& stem : own) {
        all.push_back(stem);
        if (communicator == nullptr)
            continue;
        for (const std::string& told : communicator->gather(stem.dump()))
            if (told != "null")
                all.back() = json::parse(told);
    }
    return all;
}

json make_document(const CalibrateArguments& arguments, const CalibrationPlan& plan, json stems) {
    json remarks = json::array();
    for (const measure::Measurement& measurement : plan.measurements)
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
    return document;
}

/// Rank 0 writes and prints; the exit code.
core::ExitCode report(const CalibrateArguments& arguments, const CalibrationPlan& plan,
                      json stems) {
    for (std::size_t i = 0; i < stems.size(); ++i)
        if (stems[i].is_null()) // its rank was lost
            stems[i] = {{"measurement", plan.measurements[i].stem.id},
                        {"folder", plan.folders[i]},
                        {"failure", "the rank that computed it was lost"}};
    const bool any_failed =
        std::ranges::any_of(stems, [](const json& stem) { return stem.contains("failure"); });
    const json document = make_document(arguments, plan, std::move(stems));
    for (const json& remark : document["remarks"])
        fmt::print(stderr, "culm: note: {}\n", remark.get<std::string>());
    if (!arguments.json.empty())
        write_json(arguments.json, document);
    if (!arguments.output.empty())
        write_json((fs::path(arguments.output) / "calibration.json").string(), document);
    if (arguments.json != "-")
        fmt::print("{}", calibration_table(document));
    return any_failed ? core::ExitCode::PointsFailed : core::ExitCode::Done;
}

} // namespace

core::ExitCode calibrate_measurements(const CalibrateArguments& arguments,
                                      const farm::Communicator* communicator) {
    const CalibrationPlan plan = make_plan(arguments);
    if (!arguments.output.empty())
        make_folder(fs::path(arguments.output) / "predictions");
    std::vector<json> stems(plan.measurements.size());
    std::vector<farm::Batch> batches(plan.measurements.size());
    for (std::size_t i = 0; i < batches.size(); ++i) {
        batches[i].points = {static_cast<std::int64_t>(i)};
        batches[i].cost = std::max(plan.measurements[i].times.back(), 1e-3);
    }
    const auto work = [&](const farm::Batch& batch, farm::Heartbeat& heartbeat) {
        const auto index = static_cast<std::size_t>(batch.points.front());
        stems[index] = calibrate_one(plan, index, arguments, [&heartbeat] {
            heartbeat.beat();
            return !heartbeat.stop_requested();
        });
        farm::BatchReport done;
        ++(stems[index].contains("failure") ? done.failed : done.completed);
        return done;
    };
    farm::FarmOptions options;
    options.chunk_seconds = 0.0; // a stem is never short
    const farm::Summary summary = communicator == nullptr
                                      ? farm::Farm().map(batches, work, options)
                                      : farm::Farm(*communicator).map(batches, work, options);
    if (!summary.failure.empty())
        throw core::StorageError(summary.failure);
    json all = gather(stems, communicator);
    core::ExitCode code = core::ExitCode::Done;
    if (communicator == nullptr || communicator->rank() == 0)
        code = report(arguments, plan, std::move(all));
    if (communicator != nullptr)
        code = static_cast<core::ExitCode>(
            std::stoi(communicator->broadcast(std::to_string(static_cast<int>(code)))));
    return code;
}

} // namespace culm::cli
