// SPDX-License-Identifier: BSD-3-Clause
// culm compare MEASUREMENT: one measurement against growing models, or with --table many against
// every effect.
#include "cli/chain_fits.hpp"
#include "cli/command_line.hpp"
#include "cli/commands.hpp"
#include "cli/progress.hpp"
#include "cli/provenance.hpp"
#include "farm/item_map.hpp"
#include "measure/folder/measurement_folder.hpp"
#include "physics/effects/library.hpp"
#include "present/comparison.hpp"
#include "present/files.hpp"
#include "present/motion_arrays.hpp"
#include "study/config/study_effects.hpp"

#include <algorithm>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace culm::cli {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

struct CompareArguments {
    std::vector<std::string> paths;
    std::vector<std::string> with; ///< effects of one model each, with commas between them
    std::string ladder;
    std::string json;
    std::string output;
    ChainArguments chain;
    bool is_table = false;
    bool is_quiet = false;
};

fit::FitOptions fit_options(const CompareArguments& arguments) {
    fit::FitOptions options;
    options.chain = chain_options(arguments.chain);
    options.window = arguments.chain.window_s;
    return options;
}

std::vector<fs::path> comparison_inputs(const std::vector<fs::path>& folders,
                                        const CompareArguments& arguments) {
    std::vector<fs::path> inputs = measurement_files(folders);
    for (const std::string& effects : arguments.with)
        for (const fs::path& file : effect_files(effects))
            inputs.push_back(file);
    for (const fs::path& file : effect_files(arguments.ladder))
        inputs.push_back(file);
    return inputs;
}

/// What --with and --ladder ask for: every model contains the one before it.
std::vector<fit::SelectedEffects> growing_models(const CompareArguments& arguments) {
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
    const std::size_t rows = measurement.heights.size();
    for (std::size_t i = 0; !fits.empty() && i < fits.front()->times.size(); ++i) {
        text += fmt::format("{:.9g}", measurement.times[i]);
        for (std::size_t j = 0; j < rows; ++j) {
            text += present::csv_cell(1e3 * measurement.deflection(i, j));
            for (const fit::RecordingFit* fit : fits)
                text += present::csv_cell(1e3 * fit->prediction.readings[i * rows + j]);
        }
        text += '\n';
    }
    present::write_text(file, text);
}

/// What the user should type next: search if something is missing, calibrate if nothing is.
std::string next_command(const CompareArguments& arguments, const fs::path& folder,
                         const diagnose::Ladder& ladder) {
    const std::string place = as_words({folder.string()});
    const std::optional<std::size_t> last = ladder.comparison.back();
    if (!last || ladder.comparisons[*last].verdict.finding != diagnose::Finding::Adequate)
        return "culm diagnose" + place + chain_words(arguments.chain);
    std::vector<std::string> effects = arguments.with;
    if (!arguments.ladder.empty())
        effects.push_back(arguments.ladder);
    return "culm calibrate" + place +
           (effects.empty() ? std::string()
                            : " --with" + as_words({fmt::format("{}", fmt::join(effects, ","))})) +
           chain_words(arguments.chain) + " --check";
}

json ladder_document(const CompareArguments& arguments, const fs::path& folder,
                     const diagnose::Ladder& ladder, const measure::Measurement& measurement,
                     const RunProvenance& provenance) {
    json document = present::comparison_json(ladder, measurement);
    document["folder"] = folder.string();
    document["options"] = {
        {"law", arguments.chain.law},
        {"with", arguments.with.empty() ? std::string() : arguments.with.front()},
        {"ladder", arguments.ladder},
        {"window_s", present::number(arguments.chain.window_s)}};
    document["provenance"] = provenance.document();
    return document;
}

/// One measurement, on one rank.
core::ExitCode compare_one(const CompareArguments& arguments, const fs::path& folder,
                           const std::vector<fit::SelectedEffects>& models) {
    const measure::Measurement measurement = measure::read_measurement(folder);
    const RunProvenance provenance(comparison_inputs({folder}, arguments), nullptr);
    const fit::FitOptions options = fit_options(arguments);
    if (!arguments.output.empty())
        present::make_folder(arguments.output);
    if (!arguments.is_quiet && arguments.json != "-")
        fmt::print(stderr, "{}", cost_of_ladder(measurement, models, options));
    const diagnose::Ladder ladder = diagnose::climb(measurement, models, options);
    const json document = ladder_document(arguments, folder, ladder, measurement, provenance);
    for (const std::string& remark : measurement.remarks)
        print_note(remark);
    if (!arguments.json.empty())
        present::write_json(arguments.json, document);
    if (!arguments.output.empty()) {
        const fs::path output = arguments.output;
        present::write_json((output / "comparison.json").string(), document);
        write_deflections(output / "deflections.csv", measurement, ladder);
        present::write_comparison_arrays(output / "comparison.h5", ladder, measurement);
    }
    if (arguments.json != "-")
        fmt::print("{}{}", present::comparison_text(ladder, measurement, style_of(stdout)),
                   next_step(next_command(arguments, folder, ladder)));
    return std::ranges::any_of(ladder.rungs, [](const auto& rung) { return rung.fit.failed(); })
               ? core::ExitCode::PointsFailed
               : core::ExitCode::Done;
}

/// One row of the table of effects.
struct TableModel {
    std::string name;
    fit::SelectedEffects effects;
};

/// The baseline, every effect alone (as --with fixes it, if it stands there alone), and what else
/// --with names.
std::vector<TableModel> table_models(const CompareArguments& arguments) {
    std::vector<TableModel> models{{"baseline", {}}};
    for (const physics::EffectPointer& effect : physics::all_effects())
        if (effect->is_default_candidate())
            models.push_back(
                {effect->name(),
                 {{effect, std::vector<std::optional<double>>(effect->parameters().size())}}});
    for (const std::string& text : arguments.with) {
        const fit::SelectedEffects effects = fit::in_library_order(study::effects_from(text));
        std::vector<std::string> names = fit::model_names(effects);
        names.erase(names.begin()); // the baseline
        const std::string name = fmt::format("{}", fmt::join(names, ","));
        const auto same = std::ranges::find(models, name, &TableModel::name);
        if (same != models.end())
            same->effects = effects;
        else
            models.push_back({name, effects});
    }
    return models;
}

/// Relative efforts of the cells: spatial chains cost some three times as much as planar ones.
std::vector<double> cell_costs(const std::vector<TableModel>& models, std::size_t measurements) {
    std::vector<double> costs;
    for (std::size_t i = 0; i < measurements; ++i)
        for (const TableModel& model : models) {
            const bool is_spatial =
                std::ranges::any_of(model.effects, [](const physics::SelectedEffect& selected) {
                    return selected.effect->dimensions() > 2;
                });
            costs.push_back(is_spatial ? 3.0 : 1.0);
        }
    return costs;
}

present::EffectTableReport
table_report(const std::vector<TableModel>& models,
             const std::vector<measure::Measurement>& measurements,
             std::vector<core::ItemOutcome<diagnose::EffectCell>> outcomes) {
    present::EffectTableReport report;
    for (const TableModel& model : models)
        report.models.push_back(model.name);
    for (const measure::Measurement& measurement : measurements)
        report.measurements.push_back(measurement.stem.id);
    for (core::ItemOutcome<diagnose::EffectCell>& outcome : outcomes) {
        diagnose::EffectCell lost;
        lost.failure = outcome.failure.empty() ? "not computed" : outcome.failure;
        report.cells.push_back(std::move(outcome.value).value_or(std::move(lost)));
    }
    return report;
}

core::ExitCode report(const CompareArguments& arguments, const present::EffectTableReport& table,
                      const fs::path& first_folder, const json& provenance) {
    json document = present::effect_table_json(table);
    document["provenance"] = provenance;
    if (!arguments.json.empty())
        present::write_json(arguments.json, document);
    if (!arguments.output.empty()) {
        present::make_folder(arguments.output);
        present::write_json((fs::path(arguments.output) / "effect_table.json").string(), document);
    }
    if (arguments.json != "-")
        fmt::print("{}{}", present::effect_table_text(table, style_of(stdout)),
                   next_step("culm diagnose" + as_words({first_folder.string()}) +
                             chain_words(arguments.chain)));
    return core::ExitCode::Done;
}

/// Fits the baseline, every effect of the library alone and the models of --with to every
/// measurement.
core::ExitCode compare_all(const CompareArguments& arguments,
                           const farm::Communicator* communicator) {
    const std::vector<TableModel> models = table_models(arguments);
    const auto [measurements, folders] = measure::read_measurements(arguments.paths);
    const RunProvenance provenance(comparison_inputs(folders, arguments), communicator);
    const fit::FitOptions options = fit_options(arguments);
    const bool is_quiet = arguments.is_quiet || arguments.json == "-" || !is_root(communicator);
    if (!is_quiet) {
        std::vector<fit::SelectedEffects> effects;
        for (const TableModel& model : models)
            effects.push_back(model.effects);
        fmt::print(stderr, "{}",
                   cost_of_table(measurements, effects, options, rank_count(communicator)));
    }
    diagnose::EffectTable table(measurements, options);
    ProgressDisplay display(is_quiet, "fits");
    std::vector<core::ItemOutcome<diagnose::EffectCell>> cells = farm::map(
        communicator, cell_costs(models, measurements.size()),
        [&](std::size_t place, const run::Heartbeat& heartbeat) {
            return table.cell(place / models.size(), models[place % models.size()].effects,
                              heartbeat);
        },
        {.progress = [&display](const farm::Progress& progress) { display.show(progress); }});
    display.finish();
    const json facts = provenance.document();
    const present::EffectTableReport found = table_report(models, measurements, std::move(cells));
    return farm::on_root(communicator,
                         [&] { return report(arguments, found, folders.front(), facts); });
}

core::ExitCode compare_measurements(const CompareArguments& arguments,
                                    const farm::Communicator* communicator) {
    if (arguments.is_table)
        return compare_all(arguments, communicator);
    const std::vector<fit::SelectedEffects> models = growing_models(arguments);
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

} // namespace

void add_compare_command(CLI::App& app, CommandResult& result, int& argc, char**& argv) {
    CLI::App* command = app.add_subcommand(
        "compare", "Model against measurement: where, when and how it fails, and what an effect "
                   "added by hand makes of that");
    auto arguments = std::make_shared<CompareArguments>();
    command
        ->add_option("measurement", arguments->paths,
                     "A measurement folder; with --table many, or folders that hold some")
        ->required()
        ->type_name("MEASUREMENT");
    command
        ->add_option("--with", arguments->with,
                     "Add these effects (`culm effects`) to the published chain: "
                     "quadratic_drag,relaxation(hold_time_s=3); what is not fixed is fitted")
        ->type_name("EFFECT,...")
        ->allow_extra_args(false);
    command
        ->add_option("--ladder", arguments->ladder,
                     "Add these effects one after the other and judge every step")
        ->type_name("EFFECT,...");
    command->add_flag("--table", arguments->is_table,
                      "Every effect of the library alone (and each --with) against every "
                      "measurement, spread over the ranks of mpirun");
    command->add_option("--json", arguments->json, "Write all results to this file (- for stdout)")
        ->type_name("FILE");
    command
        ->add_option("-o,--output", arguments->output,
                     "Folder for comparison.json, comparison.h5 and deflections.csv")
        ->type_name("DIR");
    add_chain_options(*command, arguments->chain, "Compare");
    command->add_flag("-q,--quiet", arguments->is_quiet, "No estimate of the cost, no progress");
    command->callback([arguments, &result, &argc, &argv] {
        result.exit_code = alone_or_under_launcher(
            argc, argv, [&arguments](const farm::Communicator* communicator) {
                return compare_measurements(*arguments, communicator);
            });
    });
}

} // namespace culm::cli
