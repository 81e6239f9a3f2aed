// SPDX-License-Identifier: BSD-3-Clause
#include "present/comparison.hpp"
#include "present/parameters.hpp"
#include "present/where.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace culm::present {
namespace {

using diagnose::LadderModel;

template <class To>
void describe_verdict(To& to, const diagnose::Verdict& verdict) {
    to("finding", [&] { return diagnose::to_string(verdict.finding); });
    to("adequate", [&] { return verdict.finding == diagnose::Finding::Adequate; });
    to("p_value", verdict.p_value);
    to("reason", verdict.reason);
    to("tests", verdict.tests);
}

/// The members that exist only for a model that could be fitted.
template <class To>
void describe_fitted_model(To& to, const LadderModel& model, std::size_t index) {
    static const diagnose::Comparison no_comparison;
    static const fit::RecordingFit no_part;
    const diagnose::Comparison& comparison = model.comparison ? *model.comparison : no_comparison;
    const fit::RecordingFit& part = model.fit.parts.empty() ? no_part : model.fit.parts.front();
    to("rmse_mm", part.rmse);
    to("rmse_over_noise", comparison.over_noise);
    to("reduced_chi2", model.fit.reduced_chi_squared);
    to("contradicted_inputs", [&] { return contradictions_of(model.fit.pulls); });
    to("degrees_of_freedom", part.degrees_of_freedom);
    to("effective_degrees_of_freedom", comparison.verdict.effective_degrees_of_freedom);
    to("parameters", [&] { return shown_parameters(part.parameters); });
    to.object("verdict", [&] { describe_verdict(to, comparison.verdict); });
    to("sentences", [&] { return comparison_sentences(comparison); });
    to.object("where", [&] { describe_where(to, comparison, part); });
    to("remarks", [&] { return remarks_on(part); });
    to(
        "moves", [&] { return model.fit.moves(); }, "false: nothing in it moves the stem");
    to("log_evidence", model.log_evidence);
    to.when(index > 0, [&] {
        to("log_evidence_gain", model.log_evidence_gain);
        to.object("change", [&] {
            to("bond_youngs_modulus", model.modulus_change);
            to("bond_damping", model.damping_change);
        });
    });
}

template <class To>
void describe_model(To& to, const diagnose::Ladder& ladder, std::size_t index) {
    static const LadderModel no_model;
    const LadderModel& model = ladder.models.empty() ? no_model : ladder.models[index];
    to("model", [&] { return model.fit.names(); });
    to("added", model.added);
    to("runs", model.fit.batches);
    to.when(index > 0, [&] {
        to("compared_with", model.compared_with, "index of that model on the ladder");
        to("gain", model.is_gain);
        to("why", model.why);
        to("step",
           [&] { return fmt::format("{}", fmt::join(step_sentences(ladder, index), " ")); });
    });
    to.when(model.fit.failed(), [&] { to("failure", model.fit.reason); });
    to.when(!model.fit.failed(), [&] { describe_fitted_model(to, model, index); });
}

template <class To>
void describe_noise(To& to, const diagnose::Ladder& ladder) {
    const LadderModel* last = last_fitted(ladder);
    to.when(last != nullptr, [&] {
        to("noise_mm", [&] { return fit::typical_noise(last->fit.parts.front()); });
        to("noise_source", [&] { return last->fit.parts.front().noise_source; });
        to("noise_known", [&] { return last->fit.parts.front().is_noise_known; });
    });
}

} // namespace

template <class To>
void describe(To& to, const ComparisonDocument& document) {
    const diagnose::Ladder& ladder = *document.ladder;
    const measure::Measurement& measurement = *document.measurement;
    const auto rungs = [&] { return std::views::iota(std::size_t{0}, ladder.models.size()); };
    to.constant("format", "culm-comparison");
    to.constant("version", 1);
    to("measurement", measurement.stem.id);
    to("folder", document.folder);
    to("frames", [&] { return measurement.times.size(); });
    to("heights", [&] { return measurement.heights.size(); });
    to.list("ladder", rungs, [&](std::size_t index) { describe_model(to, ladder, index); });
    to("headline", [&] { return comparison_headline(ladder, measurement.stem.id); });
    to(
        "best", [&] { return best_model(ladder); },
        "index of the last model that improves on the one that it is compared with");
    to("remarks", measurement.remarks);
    to.object("options", [&] {
        to("law", document.options.law);
        to("with", document.options.with);
        to("ladder", document.options.ladder);
        to("window_s", document.options.window);
    });
    to("provenance", document.provenance);
    describe_noise(to, ladder);
}

nlohmann::json comparison_json(const ComparisonDocument& document) {
    return core::json_of(document);
}

nlohmann::json comparison_schema() {
    return core::schema_of<ComparisonDocument>();
}

} // namespace culm::present
