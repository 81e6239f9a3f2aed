// SPDX-License-Identifier: BSD-3-Clause
#include "study/execute/plan.hpp"

#include "core/error.hpp"
#include "physics/effects/stem_scales.hpp"
#include "run/explicit_steps.hpp"
#include "run/simulate.hpp"
#include "study/execute/point_results.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include <fmt/core.h>
#include <fmt/format.h>

namespace culm::study {

namespace {

std::optional<std::string> fault_of(const run::CaseSpec& spec, const CaseCheck& further) {
    for (const Violation& violation : violations_of(spec))
        return fmt::format("{} = {}: {}", violation.key, violation.value, violation.allowed);
    return further ? further(spec) : std::nullopt;
}

/// Time per bond and step of all lanes together, s, and the factor for a spatial chain: measured
/// by bench_cost_estimates on the reference machine (docs/performance.md).
constexpr double explicit_bond_step_seconds = 9.2e-9;
constexpr double explicit_spatial_factor = 3.1;
constexpr double implicit_bond_step_seconds = 1.3e-6;
constexpr double implicit_spatial_factor = 5.2;
/// Time of a load step of the static start per bond, s; one stem at a time.
constexpr double static_bond_step_seconds = 6e-7;
constexpr double static_spatial_factor = 11.0;

/// Costs of ARKODE: steps for one of RODAS5 with the same accuracy, time per bond and step (s), and
/// the factor for a spatial chain.
constexpr double arkode_steps = 1.2;
constexpr double arkode_bond_step_seconds = 1.0e-6;
constexpr double arkode_spatial_factor = 4.0;

/// Steps of the implicit integrator at its default tolerance over `periods` periods of the first
/// mode. Lightly damped stems need more of them, because their higher modes ring longer; the modes
/// that the release excites decay in the first periods (docs/performance.md).
double implicit_steps(double periods, double bond_damping) {
    return periods * (45.0 / (1.0 + bond_damping / 20.0) + 150.0 / (periods + 2.0));
}

/// Seconds of a point of this study in one lane of its batch.
double seconds_of_point(const StudyConfig& config, const run::CaseSpec& spec) {
    if (config.kind != StudyKind::Timestep)
        return estimated_seconds(spec);
    const double dimensions = spec.dimensions == 2 ? 1.0 : explicit_spatial_factor;
    return dimensions * (spec.stem.sphere_count - 1) * explicit_steps_of_point(config, spec) *
           explicit_bond_step_seconds / static_cast<double>(run::lanes_per_batch());
}

/// `points` and their expected times, s, in the order in which they fill lanes. Explicit points all
/// take the same steps. Implicit points choose their own steps, and a batch ends with its longest
/// point: they are sorted by descending time, and equal ones keep their order.
std::vector<std::pair<std::int64_t, double>>
in_lane_order(const Study& study, const std::vector<std::int64_t>& points) {
    std::vector<std::pair<std::int64_t, double>> timed;
    timed.reserve(points.size());
    for (const std::int64_t point : points)
        timed.emplace_back(
            point,
            seconds_of_point(study.config, case_of_point(study.config, study.design, point)));
    if (study.config.base.integrator.method != run::IntegrationMethod::Explicit)
        std::ranges::stable_sort(timed, std::greater{}, &std::pair<std::int64_t, double>::second);
    return timed;
}

/// Rounded down to three digits, so that the printed limit is itself allowed.
double rounded_down(double limit) {
    const double unit = std::pow(10.0, std::floor(std::log10(limit)) - 2.0);
    return std::floor(limit / unit) * unit;
}

/// The stable step depends on the stem alone; points with the same stem share the result.
class StabilityCheck {
  public:
    std::optional<std::string> operator()(const run::CaseSpec& spec) {
        if (spec.integrator.method != run::IntegrationMethod::Explicit)
            return std::nullopt;
        const double limit = limit_of(spec);
        smallest_limit_ = std::min(smallest_limit_, limit);
        if (spec.integrator.timestep <= limit)
            return std::nullopt;
        return fmt::format("integrator.timestep_s = {:.6g} is above the largest stable step of the "
                           "linearised chain, {:.3g} s",
                           spec.integrator.timestep, rounded_down(limit));
    }

    /// Smallest limit of the cases checked so far, s; infinite before the first explicit one.
    [[nodiscard]] double smallest_limit() const { return smallest_limit_; }

  private:
    double limit_of(const run::CaseSpec& spec) {
        // The limit scales with √(1/Y), unless there are effects. Without Y in the key a study that
        // varies stiffness alone solves one eigenvalue problem.
        const bool scales = spec.effects.empty();
        run::CaseSpec solved = spec;
        if (scales)
            solved.stem.bond_youngs_modulus = 1e9;
        const auto& stem = solved.stem;
        std::vector<double> key{
            double(stem.sphere_count), stem.sphere_diameter,     stem.bond_length,
            stem.bond_outer_diameter,  stem.bond_inner_diameter, stem.density,
            stem.poissons_ratio,       stem.bond_damping,        stem.bond_youngs_modulus};
        for (const physics::ActiveEffect& active : spec.effects)
            key.insert(key.end(), active.values.begin(), active.values.end());
        const auto [entry, is_new] = limits_.try_emplace(std::move(key), 0.0);
        if (is_new)
            entry->second = run::largest_stable_timestep(solved);
        return scales ? entry->second * std::sqrt(1e9 / spec.stem.bond_youngs_modulus)
                      : entry->second;
    }

    std::map<std::vector<double>, double> limits_; ///< by what distinguishes chains
    double smallest_limit_ = std::numeric_limits<double>::infinity();
};

Study checked(StudyConfig config) {
    Study study{std::move(config), {}};
    study.design = make_design(study.config);
    StabilityCheck stability;
    try {
        check_points(study.config, study.design, std::ref(stability));
    } catch (const core::InputError& error) {
        // The step is not the cause of the fault; advice about it would mislead.
        if (study.config.base.integrator.timestep <= stability.smallest_limit())
            throw;
        throw core::InputError(
            fmt::format("{}\n  every point is stable with integrator.timestep_s = {:.3g} or less",
                        error.what(), rounded_down(stability.smallest_limit())));
    }
    return study;
}

/// Time of the vibration per bond by an implicit method, s.
double implicit_seconds_per_bond(const run::CaseSpec& spec) {
    const run::Integrator& integrator = spec.integrator;
    const bool is_planar = spec.dimensions == 2;
    const double periods = spec.duration * physics::first_frequency(spec.stem);
    const double usual_steps = implicit_steps(periods, spec.stem.bond_damping);
    const double accuracy = run::Integrator{}.relative_tolerance / integrator.relative_tolerance;
    // A method of order p that controls the error of a step takes 10^(1/p) times the steps for ten
    // times the accuracy; the estimates of RODAS5 and ARKODE are of order 5 and 4.
    if (integrator.method == run::IntegrationMethod::Implicit)
        return (is_planar ? 1.0 : implicit_spatial_factor) * std::pow(accuracy, 1.0 / 5.0) *
               usual_steps * implicit_bond_step_seconds /
               static_cast<double>(run::lanes_per_batch());
    return (is_planar ? 1.0 : arkode_spatial_factor) * std::pow(accuracy, 1.0 / 4.0) *
           arkode_steps * usual_steps * arkode_bond_step_seconds;
}

} // namespace

std::string factors_text(const Design& design, std::int64_t point) {
    std::string text;
    for (std::size_t column = 0; column < design.factors.size(); ++column) {
        const Parameter& parameter = *design.factors[column].parameter;
        text += fmt::format("{}{} = {:.6g}", text.empty() ? "" : ", ", parameter.key,
                            parameter.unit.from_si(design.row(point)[column]));
    }
    return text.empty() ? text : " (" + text + ")";
}

void check_points(const StudyConfig& config, const Design& design, const CaseCheck& further) {
    constexpr std::int64_t most_listed = 10;
    std::int64_t bad = 0;
    std::string list;
    for (std::int64_t point = 0; point < design.point_count(); ++point) {
        const auto fault = fault_of(case_of_point(config, design, point), further);
        if (!fault)
            continue;
        ++bad;
        if (bad <= most_listed)
            list += fmt::format("\n  point {}: {}{}", point, *fault, factors_text(design, point));
    }
    if (bad == 0)
        return;
    if (bad > most_listed)
        list += fmt::format("\n  and {} more", bad - most_listed);
    throw core::InputError(fmt::format("{}: {} of {} points are impossible:{}", config.file, bad,
                                       design.point_count(), list));
}

Study load_study(const std::filesystem::path& file) {
    return checked(load_config(file));
}

Study parse_study(std::string_view text, const std::string& file, const StudyFiles& files) {
    return checked(parse_config(text, file, files));
}

double estimated_seconds(const run::CaseSpec& spec) {
    const double bonds = spec.stem.sphere_count - 1;
    const bool is_planar = spec.dimensions == 2;
    const auto lanes = static_cast<double>(run::lanes_per_batch());
    if (spec.integrator.method == run::IntegrationMethod::Explicit)
        return (is_planar ? 1.0 : explicit_spatial_factor) * bonds * spec.duration /
               spec.integrator.timestep * explicit_bond_step_seconds / lanes;
    const double vibration = bonds * implicit_seconds_per_bond(spec);
    const double load_steps =
        10.0 + 200.0 * std::abs(spec.tip_deflection) / spec.stem.free_length();
    return vibration + (is_planar ? 1.0 : static_spatial_factor) * bonds * load_steps *
                           static_bond_step_seconds;
}

std::vector<farm::Batch> make_batches(const Study& study, const std::vector<std::int64_t>& points,
                                      const std::vector<std::int64_t>& alone) {
    std::vector<farm::Batch> batches;
    std::vector<farm::Batch> lone;
    std::optional<run::CaseSpec> first;
    const std::size_t most = run::lanes_per_batch(study.config.base.integrator.method);
    const auto lanes = static_cast<double>(most);
    for (const auto& [point, seconds] : in_lane_order(study, points)) {
        // A point during which a process died before gets its own batch, so that another death does
        // not affect other points.
        if (std::ranges::binary_search(alone, point)) {
            lone.push_back({{point}, lanes * seconds});
            continue;
        }
        run::CaseSpec spec = case_of_point(study.config, study.design, point);
        // A point of a time-step study fills the lanes with its own steps.
        if (first && study.config.kind == StudyKind::Vibration &&
            batches.back().points.size() < most && run::can_share_lanes(*first, spec)) {
            batches.back().points.push_back(point);
            continue;
        }
        // Lanes step together: the cost of a batch is that of its longest lane, the first one, for
        // any number of used lanes.
        batches.push_back({{point}, lanes * seconds});
        first = std::move(spec);
    }
    batches.insert(batches.end(), lone.begin(), lone.end());
    return batches;
}

Estimate estimate(const Study& study, const std::vector<farm::Batch>& batches) {
    Estimate result;
    result.batches = static_cast<std::int64_t>(batches.size());
    for (const farm::Batch& batch : batches) {
        result.points += static_cast<std::int64_t>(batch.points.size());
        result.lanes = std::max(result.lanes, batch.points.size());
        result.core_seconds += batch.cost;
    }
    const run::CaseSpec& base = study.config.base;
    const auto samples = static_cast<double>(base.sample_count());
    double numbers_per_point = static_cast<double>(result_columns(study.config).size());
    if (base.store >= run::StoreLevel::Tip)
        numbers_per_point += samples;
    if (base.store >= run::StoreLevel::Heights)
        numbers_per_point += samples * static_cast<double>(base.heights.size());
    if (base.store == run::StoreLevel::Full)
        numbers_per_point += samples * 3.0 * base.stem.sphere_count;
    result.archive_bytes = 8.0 * numbers_per_point * static_cast<double>(result.points);
    // A rank holds the histories of its batch, once as results and once as a journal record, and
    // the design.
    constexpr double program_bytes = 40e6;
    result.memory_bytes_per_rank = program_bytes +
                                   16.0 * numbers_per_point * static_cast<double>(result.lanes) +
                                   8.0 * static_cast<double>(study.design.values.size());
    return result;
}

} // namespace culm::study
