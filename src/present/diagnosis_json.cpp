// SPDX-License-Identifier: BSD-3-Clause
#include "fit/solve/residual_statistics.hpp"
#include "present/answer_json.hpp"
#include "present/diagnosis.hpp"
#include "present/laboratory.hpp"
#include "present/parameters.hpp"
#include "present/text.hpp"
#include "present/where.hpp"

#include <optional>
#include <ranges>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace culm::present {
namespace {

using nlohmann::json;

/// The noise is that of the fit's weights: stated, measured, or estimated from the residuals.
template <class To>
void describe_recording(To& to, const DiagnosisReport& report, std::size_t k) {
    static const measure::Measurement no_recording{};
    static const fit::RecordingFit no_part{};
    const auto& recording = k < report.recordings.size() ? report.recordings[k] : no_recording;
    const std::vector<fit::RecordingFit>& parts = report.best_fit().parts;
    const fit::RecordingFit& part = k < parts.size() ? parts[k] : no_part;
    to("id", recording.stem.id);
    to("folder", [&] { return report.folders[k]; });
    to("frames", [&] { return recording.times.size(); });
    to("heights", [&] { return recording.heights.size(); });
    to.when(k < parts.size(), [&] {
        to("noise_mm", [&] { return fit::typical_noise(part); });
        to("noise_source", part.noise_source);
        to("noise_known", part.is_noise_known);
    });
}

/// The residuals of one recording of a joint fit, as `culm compare` reports them.
template <class To>
void describe_where_of(To& to, const diagnose::Diagnosis& found, std::size_t k) {
    static const diagnose::Comparison no_comparison{};
    static const fit::RecordingFit no_part{};
    const bool exists = k < found.comparisons.size();
    describe_where(to, exists ? found.comparisons[k] : no_comparison,
                   exists ? found.final_fit.parts[k] : no_part);
}

template <class To>
void describe_recordings(To& to, const DiagnosisReport& report) {
    const auto recordings = [&] {
        return std::views::iota(std::size_t{0}, report.recordings.size());
    };
    const auto ids = [&] {
        std::vector<std::string> names;
        for (const measure::Measurement& recording : report.recordings)
            names.push_back(recording.stem.id);
        return names;
    };
    to("measurement", [&] { return fmt::format("{}", fmt::join(ids(), "+")); });
    to.list("recordings", recordings, [&](std::size_t k) { describe_recording(to, report, k); });
    to("noise_mm", [&] { return report.noise(); });
    to("remarks", [&] {
        std::vector<std::string> remarks;
        for (const measure::Measurement& recording : report.recordings)
            remarks.insert(remarks.end(), recording.remarks.begin(), recording.remarks.end());
        return remarks;
    });
    to.object(
        "where", [&] { describe_where_of(to, *report.found, 0); }, "of the first recording");
    to.when(report.recordings.size() > 1, [&] {
        to("measurements", ids);
        to.list("where_by_recording", recordings,
                [&](std::size_t k) { describe_where_of(to, *report.found, k); });
    });
}

template <class To>
void describe_models(To& to, const diagnose::Diagnosis& found) {
    to.object("baseline", [&] {
        to("rmse_mm", found.baseline.rmse);
        to("reduced_chi2", found.baseline.reduced_chi_squared);
        to("adequate", [&] {
            return !found.ladder.empty() &&
                   found.ladder.front().verdict.finding == diagnose::Finding::Adequate;
        });
        to("parameters", [&] { return shown_parameters(found.baseline.parameters); });
    });
    to.list("ladder", found.ladder, [&](const diagnose::SearchedModel& model) {
        to("model", [&] { return model.fit.names(); });
        to("rmse_mm", model.fit.rmse);
        to("reduced_chi2", model.fit.reduced_chi_squared);
        to("contradicted_inputs", [&] { return contradictions_of(model.fit.pulls); });
        to("finding", [&] { return diagnose::to_string(model.verdict.finding); });
        to("p_value", model.verdict.p_value);
        to("tests", model.verdict.reason);
        to("parameters", [&] { return shown_parameters(model.fit.parameters); });
        const bool is_first = found.ladder.empty() || &model == &found.ladder.front();
        to.when(!is_first, [&] { to("log_evidence", model.log_evidence); });
    });
    const auto failed = [&] {
        std::vector<diagnose::ModelProbability> models = found.posterior.models;
        std::erase_if(models, [](const auto& model) { return model.failure.empty(); });
        return models;
    };
    to.list("failed", failed, [&](const diagnose::ModelProbability& model) {
        to("effects", [&] { return effect_names(model.effects); });
        to("reason", model.failure);
    });
    to.maybe("largest_unvisited", found.largest_unvisited.has_value(), [&] {
        to("effects",
           [&] { return effect_names(diagnose::added_names(found.largest_unvisited->effects)); });
        to("log_evidence", [&] { return found.largest_unvisited->log_evidence; });
    });
}

template <class To>
void describe_blind_spots(To& to, const std::vector<diagnose::DetectionLimit>& limits) {
    to.list("blind_spots", limits, [&](const diagnose::DetectionLimit& limit) {
        to("effect", limit.effect);
        to.when(!limit.failure.empty(), [&] { to("failure", limit.failure); });
        to.when(limit.failure.empty(), [&] {
            to.object("smallest_visible", [&] {
                to("parameter", limit.parameter);
                to("value", limit.value);
                to("unit", limit.unit);
            });
            to("beyond_bounds", limit.is_beyond_bounds);
            to("bias_if_present", [&] {
                return fmt::format(
                    "at that size the calibrated Y would be off by {} and beta by {}",
                    percent_text(limit.youngs_modulus_bias), percent_text(limit.damping_bias));
            });
            to.object("bias", [&] {
                to("bond_youngs_modulus", limit.youngs_modulus_bias);
                to("bond_damping", limit.damping_bias);
            });
        });
    });
}

template <class To>
void describe_missing_force(To& to, const diagnose::MissingForce& force) {
    const bool is_moment = force.kind == "bending_moment";
    const auto samples = [&](const char* key, const std::vector<diagnose::ForceSample>& at) {
        to.list(key, at, [&](const diagnose::ForceSample& sample) {
            to("displacement_mm", sample.displacement);
            to("velocity_m_s", sample.velocity);
            to.when(is_moment, [&] { to("moment_n_m", sample.force); });
            to.when(!is_moment, [&] { to("force_n_per_m", sample.force); });
        });
    };
    to("kind", force.kind, "force_per_length or bending_moment");
    to("form", force.form);
    to("character", force.character);
    to.list("terms", force.terms, [&](const diagnose::ForceTerm& term) {
        to("term", term.term);
        to("coefficient", term.coefficient);
        to("stderr", term.standard_error);
        to("probability", term.probability);
    });
    to("explained", force.explained, "share of the misfit above the noise that it removes");
    to("rmse_mm",
       [&] { return force.fit.is_fitted() ? std::optional(force.fit.rmse) : std::nullopt; });
    samples("against_displacement", force.against_displacement);
    samples("against_velocity", force.against_velocity);
    to("effect_file", force.as_effect_file, "TOML of an effect with this force");
}

} // namespace

/// The answer on one stem with its recordings.
template <class To>
void describe(To& to, const DiagnosisReport& report) {
    const diagnose::Diagnosis& found = *report.found;
    to.constant("format", "culm-diagnosis");
    to.constant("version", 2);
    describe_answer(to, found);
    to(
        "verdict", [&] { return diagnose::to_string(found.conclusion); },
        "adequate, effect, tie or unknown");
    to("sentences", [&] { return diagnosis_sentences(report); });
    to("effects", found.effects, "of the likeliest explanation; empty if adequate");
    to("explained", found.explained, "share of the baseline's chi-squared above the noise");
    to("unexplained_mm", found.unexplained, "rms of the residual above the noise");
    to("unexplained_share_of_swing", found.unexplained_share);
    to("parameters", [&] { return shown_parameters(report.best_fit().parameters); });
    describe_models(to, found);
    describe_blind_spots(to, found.detection_limits);
    to.list("next_experiment", found.next_experiments, [&](const diagnose::Experiment& each) {
        to("what", each.what);
        to("separates", [&] { return std::vector{each.first_model, each.second_model}; });
        to("expected_gap", each.expected_gap, "squared distance in standard deviations");
    });
    to.maybe("missing_force", found.missing_force,
             [&](const auto& force) { describe_missing_force(to, force); });
    to("runs", found.batches);
    describe_recordings(to, report);
    to("options", *report.options);
    to("provenance", report.provenance);
}

json diagnosis_json(const DiagnosisReport& report) {
    if (report.found->stems.size() > 1)
        return laboratory_json(report);
    return core::json_of(report);
}

json diagnosis_schema() {
    return core::schema_of<DiagnosisReport>();
}

} // namespace culm::present
