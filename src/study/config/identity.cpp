// SPDX-License-Identifier: BSD-3-Clause
// Identity of a study: every setting that influences its results as sorted lines, and the texts
// of its files as one text.
#include "core/error.hpp"
#include "study/config/keys.hpp"
#include "study/config/study_config.hpp"

#include <algorithm>
#include <map>
#include <ranges>
#include <set>
#include <string>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

namespace culm::study {

namespace {

using Lines = std::map<std::string, std::string, std::less<>>;

bool is_factor(const StudyConfig& config, std::string_view key) {
    return std::ranges::any_of(config.factors,
                               [&](const Factor& f) { return f.parameter->key == key; });
}

/// Does the stem's geometry or mass vary? Then the rules of ParameterValues::apply_to define each
/// case, and not the base alone.
bool is_geometry_varied(const StudyConfig& config) {
    return std::ranges::any_of(config.factors, [](const Factor& factor) {
        const std::string_view key = factor.parameter->key;
        return factor.parameter->section == "stem" &&
               (factor.parameter->unit.dimension == core::Dimension::Length || key == "spheres" ||
                key == "density_kg_m3" || key == "wall_density_kg_m3");
    });
}

void add_parameters(const StudyConfig& config, Lines& lines) {
    const bool by_rule = is_geometry_varied(config);
    const auto is_present = [&](std::string_view key) {
        return config.given.has(key) || is_factor(config, key);
    };
    // If two keys define the same quantity, only the one in force is included.
    std::set<std::string_view> left_out;
    for (const ExclusiveKeys& pair : exclusive_keys)
        left_out.insert(by_rule && is_present(pair.first) ? pair.second : pair.first);
    for (const Parameter& p : parameters()) {
        if (left_out.contains(p.key) || is_factor(config, p.key))
            continue;
        const auto given = config.given.get(p);
        std::string value = config_text(p, p.get(config.base));
        // The base case is one of many here, and its derived numbers do not describe the others.
        // The values of the file and the rules do.
        if (by_rule && p.section == "stem")
            value = given ? config_text(p, *given) : std::string(p.default_text);
        lines[fmt::format("{}.{}", p.section, p.key)] = value;
    }
}

/// The level and the scatter within a stem, where they are not the defaults.
std::string scatter_text(const Factor& factor) {
    std::string text = factor.is_per_test ? ", level test" : "";
    if (factor.within_stem)
        text +=
            fmt::format(", within_sd {}", config_text(*factor.parameter, factor.within_stem->sd));
    return text;
}

/// The values by their check sum: a table may be long.
std::string measured_text(const Factor& factor) {
    const auto values = std::get<Distribution>(factor.values).values();
    std::string all;
    // The values and not the bytes of the file: another order of columns or another spelling of a
    // number is the same study.
    for (const double value : values)
        all += config_text(*factor.parameter, value) + "\n";
    return fmt::format("empirical, file {}, column {}, {} values, FNV-1a {:016x}, rows {}",
                       factor.measured->file, factor.measured->column, values.size(),
                       factor_id(all), factor.measured->keeps_rows ? "together" : "independent");
}

std::string values_text(const Factor& factor) {
    const auto text = [&](double si) { return config_text(*factor.parameter, si); };
    if (const auto* levels = std::get_if<Levels>(&factor.values))
        return fmt::format("[{}]", fmt::join(*levels | std::views::transform(text), ", "));
    const auto& d = std::get<Distribution>(factor.values);
    if (factor.measured)
        return measured_text(factor) + scatter_text(factor);
    const char* role = factor.is_redrawn ? "" : "range, ";
    const bool has_mean =
        d.kind() == DistributionKind::Normal || d.kind() == DistributionKind::Lognormal;
    const std::string moments =
        has_mean ? fmt::format("mean {}, sd {}, ", text(d.mean()), text(d.sd())) : "";
    return fmt::format("{}{}, {}min {}, max {}{}", role, to_string(d.kind()), moments,
                       text(d.min()), text(d.max()), scatter_text(factor));
}

void add_factors_and_design(const StudyConfig& config, Lines& lines) {
    std::vector<std::string_view> order;
    for (const Factor& factor : config.factors) {
        order.push_back(factor.parameter->key);
        lines[fmt::format("factors.{}", factor.parameter->key)] = values_text(factor);
    }
    // The order of the columns counts: a factorial numbers its points by it.
    lines["factors"] = fmt::format("{}", fmt::join(order, ", "));
    if (config.design.type != DesignType::Factorial)
        lines["design.points"] = fmt::format("{}", config.design.points);
}

void add_effects(const StudyConfig& config, Lines& lines) {
    // With the law, because a user's formula may change under the same name.
    for (const physics::SelectedEffect& selected : config.effects.selected())
        lines[fmt::format("effects.{}", selected.effect->name)] = selected.effect->law;
    for (const auto& row : config.effects.rows()) {
        const EffectPlace place = *row->parameter.effect;
        if (!is_factor(config, row->key))
            lines["effects." + row->key] =
                fmt::format("{}", config.base.effects[place.effect].values[place.value]);
    }
}

Lines lines_of(std::string_view identity) {
    Lines lines;
    while (!identity.empty()) {
        const std::string_view line = identity.substr(0, identity.find('\n'));
        identity.remove_prefix(std::min(identity.size(), line.size() + 1));
        const std::size_t equals = line.find(" = ");
        if (equals != std::string_view::npos)
            lines[std::string(line.substr(0, equals))] = line.substr(equals + 3);
    }
    return lines;
}

} // namespace

std::string StudyConfig::identity() const {
    Lines lines;
    for (const auto& table : study_tables())
        table.add_identity(*this, lines);
    add_parameters(*this, lines);
    add_factors_and_design(*this, lines);
    add_effects(*this, lines);
    // Sorted by key (a map), with one text for each number: two files that mean the same study have
    // the same identity, however they are written.
    std::string canonical;
    for (const auto& [key, value] : lines)
        canonical += fmt::format("{} = {}\n", key, value);
    return canonical;
}

std::string difference(const std::string& stored, const std::string& now) {
    const Lines before = lines_of(stored);
    const Lines after = lines_of(now);
    std::set<std::string> keys;
    for (const Lines* lines : {&before, &after})
        for (const auto& [key, value] : *lines)
            keys.insert(key);
    std::string text;
    for (const std::string& key : keys) {
        const auto old = before.find(key);
        const auto current = after.find(key);
        if (old == before.end())
            text += fmt::format("{}: not in the stored study, now {}\n", key, current->second);
        else if (current == after.end())
            text += fmt::format("{}: stored {}, not in the study now\n", key, old->second);
        else if (old->second != current->second)
            text += fmt::format("{}: stored {}, now {}\n", key, old->second, current->second);
    }
    return text;
}

std::string to_text(const StudyFiles& files) {
    // A file that is not UTF-8 cannot be repeated from the archive, but must not stop the study.
    return nlohmann::json(files).dump(1, ' ', false, nlohmann::json::error_handler_t::replace);
}

StudyFiles files_from_text(const std::string& text) {
    if (text.empty())
        return {};
    try {
        return nlohmann::json::parse(text).get<StudyFiles>();
    } catch (const nlohmann::json::exception& error) {
        throw core::InputError(std::string("the archived texts of the study's files: ") +
                               error.what());
    }
}

std::string integrator_text(const StudyConfig& config) {
    const run::CaseSpec& base = config.base;
    if (config.kind == StudyKind::Timestep)
        return fmt::format("explicit, the limit bisected to {:.3g}, b1 and b2 at {} steps below it",
                           config.timestep.limit_tolerance, config.timestep.fractions.size());
    if (base.integrator.method == run::IntegrationMethod::Explicit)
        return fmt::format("explicit, time step {:.4g} s, {:.4g} steps a point",
                           base.integrator.timestep, base.duration / base.integrator.timestep);
    const bool is_sundials = base.integrator.method == run::IntegrationMethod::Sundials;
    const char* method = is_sundials ? "SUNDIALS arkode" : "implicit";
    return fmt::format("{}, relative tolerance {:.3g}", method, base.integrator.relative_tolerance);
}

} // namespace culm::study
