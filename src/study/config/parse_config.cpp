// SPDX-License-Identifier: BSD-3-Clause
// Reads a whole study file: section by section, then the constraints between sections.
#include "core/user_files.hpp"
#include "study/config/case_constraints.hpp"
#include "study/config/keys.hpp"
#include "study/config/reader.hpp"
#include "study/config/sections.hpp"
#include "study/config/study_config.hpp"

#include <algorithm>

#include <fmt/format.h>

namespace culm::study {

namespace {

void check_sections(const ConfigContext& context) {
    const auto& sections = config_sections();
    for (const core::TomlEntry& entry : entries_in_order(context.root)) {
        const bool is_section = std::ranges::find(sections, entry.key) != sections.end();
        if (is_section && !entry.node->is_table())
            context.errors.add(entry.line, entry.key, value_text(*entry.node),
                               fmt::format("must be a table [{}]", entry.key));
        else if (!is_section && entry.node->is_table())
            context.errors.add(entry.line, fmt::format("[{}]: unknown section{}", entry.key,
                                                       did_you_mean(entry.key, sections)));
        else if (!is_section)
            context.errors.add(
                entry.line, entry.key, value_text(*entry.node),
                unknown_key_hint({"", entry.key, entry.node->value<double>()}, sections));
    }
}

/// Records an error for every pair of which both are given; true if there is none.
bool check_exclusive_keys(const ConfigContext& context) {
    const std::size_t errors_before = context.errors.count();
    for (const ExclusiveKeys& pair : exclusive_keys()) {
        const auto first = context.places.find(pair.first);
        const auto second = context.places.find(pair.second);
        if (first != context.places.end() && second != context.places.end())
            context.errors.add(second->second.line,
                               fmt::format("{}.{}: not together with {}.{}, line {}",
                                           second->second.section, second->first,
                                           first->second.section, first->first,
                                           first->second.line));
    }
    return context.errors.count() == errors_before;
}

/// Checks the constraints that no factor influences; plan.hpp checks the others.
void check_base(const ConfigContext& context) {
    for (const CaseConstraint& constraint : case_constraints()) {
        const auto place_of = [&](std::string_view key) { return context.places.find(key); };
        const bool is_varied = std::ranges::any_of(constraint.keys, [&](std::string_view key) {
            const auto place = place_of(key);
            return place != context.places.end() &&
                   (place->second.section == "factors" || place->second.section == "design.point");
        });
        const auto violation = constraint.violation(context.config.base);
        if (is_varied || !violation)
            continue;
        const auto given = std::ranges::find_if(constraint.keys, [&](std::string_view key) {
            return place_of(key) != context.places.end();
        });
        // A constraint may be broken by defaults alone; then no key of the file is to blame.
        const std::size_t line = given != constraint.keys.end() ? place_of(*given)->second.line : 1;
        context.errors.add(line, violation->key, violation->value, violation->allowed);
    }
}

} // namespace

StudyConfig load_config(const std::filesystem::path& file) {
    return parse_config(core::file_text(file), file.string());
}

StudyConfig parse_config(std::string_view text, const std::string& file, const StudyFiles& files) {
    const toml::table root = core::parse_toml_text(text, file);
    StudyConfig config;
    config.file = file;
    config.text = std::string(text);
    core::FileFaults errors(file);
    ConfigContext context{root, config, errors, {}, files};
    // Each reader continues after an error, so that one run reports all of them. The order matters
    // only where a section refers to another: the design decides how factors are read.
    check_sections(context);
    read_study(context);
    read_effects(context);
    const std::size_t errors_before_stem = errors.count();
    read_stem_and_release(context);
    const bool is_stem_known = errors.count() == errors_before_stem;
    read_law(context);
    read_integrator(context);
    read_vibration(context);
    read_reduce(context);
    read_archive(context);
    read_timestep(context);
    read_design(context);
    read_replicates(context);
    read_factors(context);
    read_correlation(context);
    const bool is_given_twice = !check_exclusive_keys(context);
    config.given.apply_to(config.base);
    config.base.effects = config.effects.with_defaults(config.base.stem);
    // Otherwise the default of a value that could not be read would be checked here.
    if (is_stem_known && !is_given_twice)
        check_base(context);
    errors.throw_if_any();
    return config;
}

} // namespace culm::study
