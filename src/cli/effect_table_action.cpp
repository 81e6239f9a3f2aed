// SPDX-License-Identifier: BSD-3-Clause
#include "cli/effect_table_action.hpp"

#include "cli/compare_json.hpp"
#include "cli/compare_text.hpp"
#include "cli/fit_cost.hpp"
#include "cli/next_step.hpp"
#include "cli/progress_display.hpp"
#include "cli/run_provenance.hpp"
#include "cli/text_output.hpp"
#include "farm/item_map.hpp"
#include "measure/folder/measurement_folder.hpp"
#include "physics/effects/library.hpp"
#include "present/json.hpp"
#include "study/config/study_effects.hpp"

#include <algorithm>
#include <filesystem>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace culm::cli {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// One row of the table.
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

std::vector<fit::SelectedEffects> selections_of(const std::vector<TableModel>& models) {
    std::vector<fit::SelectedEffects> selections;
    for (const TableModel& model : models)
        selections.push_back(model.effects);
    return selections;
}

json table_document(const std::vector<TableModel>& models,
                    const std::vector<measure::Measurement>& measurements,
                    const std::vector<core::ItemOutcome<std::string>>& cells,
                    const json& provenance) {
    json names = json::array();
    for (const measure::Measurement& measurement : measurements)
        names.push_back(measurement.stem.id);
    json rows = json::array();
    for (std::size_t k = 0; k < models.size(); ++k) {
        json row{{"name", models[k].name}, {"cells", json::array()}};
        for (std::size_t i = 0; i < measurements.size(); ++i) {
            const core::ItemOutcome<std::string>& cell = cells[i * models.size() + k];
            row["cells"].push_back(cell.value ? json::parse(*cell.value)
                                              : json{{"applies", true}, {"failure", cell.failure}});
        }
        rows.push_back(std::move(row));
    }
    return {{"format", "culm-effect-table"},
            {"version", 1},
            {"measurements", names},
            {"models", rows},
            {"provenance", provenance}};
}

} // namespace

core::ExitCode effect_table(const CompareArguments& arguments,
                            const farm::Communicator* communicator) {
    const std::vector<TableModel> models = table_models(arguments);
    const auto [measurements, folders] = measure::read_measurements(arguments.paths);
    std::vector<fs::path> inputs = measurement_files(folders);
    for (const std::string& effects : arguments.with)
        for (const fs::path& file : effect_files(effects))
            inputs.push_back(file);
    const RunProvenance provenance(inputs, communicator);
    fit::FitOptions options;
    options.chain = {arguments.spheres, *physics::law_by_name(arguments.law)};
    options.window = arguments.window_s;
    diagnose::EffectTable table(measurements, options);
    std::vector<double> costs;
    for (std::size_t k = 0; k < measurements.size() * models.size(); ++k) {
        // Spatial chains cost some three times as much as planar ones.
        const bool is_spatial =
            std::ranges::any_of(models[k % models.size()].effects, [](const auto& selected) {
                return selected.effect->dimensions() > 2;
            });
        costs.push_back(is_spatial ? 3.0 : 1.0);
    }
    const auto work = [&](std::size_t place, const run::Heartbeat& heartbeat) {
        return cell_json(table.cell(place / models.size(), models[place % models.size()].effects,
                                    heartbeat))
            .dump();
    };
    const bool is_quiet = arguments.is_quiet || arguments.json == "-" ||
                          (communicator != nullptr && communicator->rank() != 0);
    if (!is_quiet)
        fmt::print(stderr, "{}",
                   cost_of_table(measurements, selections_of(models), options,
                                 communicator == nullptr ? 1 : communicator->size()));
    ProgressDisplay display(is_quiet, "fits");
    const std::vector<core::ItemOutcome<std::string>> cells = farm::map(
        communicator, costs, work,
        {.progress = [&display](const farm::Progress& progress) { display.show(progress); }});
    display.finish();
    const json facts = provenance.document();
    return farm::on_root(communicator, [&] {
        const json document = table_document(models, measurements, cells, facts);
        if (!arguments.json.empty())
            present::write_json(arguments.json, document);
        if (!arguments.output.empty()) {
            make_folder(arguments.output);
            present::write_json((fs::path(arguments.output) / "effect_table.json").string(),
                                document);
        }
        if (arguments.json != "-")
            fmt::print(
                "{}{}", effect_table_text(document, TextStyle::of(stdout)),
                next_step("culm diagnose" + as_words({folders.front().string()}) +
                          model_words(arguments.law, arguments.spheres, arguments.window_s)));
        return core::ExitCode::Done;
    });
}

} // namespace culm::cli
