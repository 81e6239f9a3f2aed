// SPDX-License-Identifier: BSD-3-Clause
// Reads a whole study file: section by section, then the constraints between sections.
#include "study/config/sections.hpp"

#include "core/error.hpp"
#include "core/user_files.hpp"
#include "study/config/keys.hpp"
#include "study/config/study_config.hpp"
#include "study/config/study_effects.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace culm::study {

void ConfigContext::note_given(const std::string& key, const GivenPlace& place) {
    const auto [earlier, is_new] = places.try_emplace(key, place);
    if (!is_new)
        errors.add(place.line,
                   fmt::format("{}.{}: may be given once only; it is in [{}] too, line {}",
                               place.section, key, earlier->second.section, earlier->second.line));
}

const std::string& text_of_named_file(ConfigContext& context, const std::string& name) {
    StudyFiles& used = context.config.files;
    // A study from an archive brings its files along; the disk is not read.
    const auto given = context.files.find(name);
    if (given != context.files.end())
        return used.insert_or_assign(name, given->second).first->second;
    std::string text = core::file_text(core::path_named_in(context.config.file, name));
    return used.insert_or_assign(name, std::move(text)).first->second;
}

namespace {

/// Is `whole` a multiple of `part`? Decimal inputs are off by some 1e-16 of their quotient, which
/// stays far below 1e-6 for every quotient up to 1e9.
bool is_multiple(double whole, double part) {
    const double quotient = whole / part;
    return std::round(quotient) >= 1.0 && std::abs(quotient - std::round(quotient)) <= 1e-6;
}

void read_parameters(const std::string& section, ConfigContext& context) {
    const core::TomlTable table = context.table(section);
    for (const Parameter& parameter : parameters()) {
        if (parameter.section != section || !table.has(parameter.key))
            continue;
        const KeyDescription key = description_of(parameter);
        context.note_given(key.name, {section, table.line(key.name)});
        std::optional<double> value;
        if (!parameter.is_whole_number)
            value = table.number(key.name, key.range, key.allowed());
        else if (const auto whole = table.whole_number(key.name, key.range, key.allowed()))
            value = static_cast<double>(*whole);
        if (value)
            context.config.given.set(parameter, parameter.unit.to_si(*value));
    }
}

void check_storage(ConfigContext& context) {
    const core::TomlTable table = context.table("study");
    run::CaseSpec& base = context.config.base;
    if (context.config.kind == StudyKind::Timestep) {
        if (!table.has("store"))
            base.store = run::StoreLevel::Fit;
        else if (base.store != run::StoreLevel::Fit)
            table.refuse("store",
                         "study.kind = \"timestep\" keeps no histories: \"fit\" or nothing");
    }
    if (!table.has("heights_mm") || base.heights.empty())
        return;
    // Heights must not exceed the stem (violations_of), which may be known only later: the
    // error then needs this line.
    context.note_given("heights_mm", {"study", table.line("heights_mm")});
    std::vector<double> sorted = base.heights;
    std::ranges::sort(sorted);
    if (const auto twice = std::ranges::adjacent_find(sorted); twice != sorted.end())
        table.refuse("heights_mm",
                     fmt::format("must name {} once only", core::millimetre.from_si(*twice)));
}

void read_effects(ConfigContext& context) {
    const toml::node* node = context.table("study").node("effects");
    if (node == nullptr)
        return;
    const std::size_t line = core::line_of(*node);
    const toml::array* names = node->as_array();
    if (names == nullptr || !(names->empty() || names->is_homogeneous<std::string>())) {
        context.errors.add(line, "study.effects", core::value_text(*node),
                           "must be a list of names");
        return;
    }
    std::vector<std::string> texts;
    for (const toml::node& name : *names)
        texts.push_back(name.value_or<std::string>(""));
    try {
        context.config.effects = StudyEffects(physics::parse_effects(
            fmt::format("{}", fmt::join(texts, ",")), [&context](const std::string& file) {
                const std::filesystem::path study(context.config.file);
                // The texts of effect files become part of the archive, so that the study can be
                // repeated from it.
                return read_effect_text(text_of_named_file(context, file),
                                        (study.parent_path() / file).string());
            }));
    } catch (const core::InputError& error) {
        context.errors.add(line, fmt::format("study.effects: {}", error.what()));
    }
    if (context.config.kind == StudyKind::Timestep && !context.config.effects.selected().empty())
        context.errors.add(line,
                           "study.effects: not in a study of kind \"timestep\", which is about "
                           "the published chain");
}

void check_vibration(const ConfigContext& context, const std::set<std::string>& wrong) {
    if (wrong.contains("vibration.duration_s") || wrong.contains("vibration.sample_interval_s"))
        return;
    const core::TomlTable table = context.table("vibration");
    const run::CaseSpec& base = context.config.base;
    // The error refers to a key that the user gave, because only such a key has a line.
    const char* duration_key = table.has("duration_s") ? "duration_s" : "sample_interval_s";
    if (base.sample_interval > base.duration)
        table.refuse("sample_interval_s",
                     fmt::format("must not exceed duration_s = {}", base.duration));
    else if (!is_multiple(base.duration, base.sample_interval))
        table.refuse(duration_key,
                     fmt::format("duration_s = {} must be a multiple of sample_interval_s = {}",
                                 base.duration, base.sample_interval));
    const double step = base.integrator.timestep;
    // The explicit method has no interpolation: every sample must fall on a step.
    if (base.integrator.method == run::IntegrationMethod::Explicit && step > 0.0 &&
        !is_multiple(base.sample_interval, step))
        context.table("integrator")
            .refuse("timestep_s", fmt::format("must divide vibration.sample_interval_s = {}",
                                              base.sample_interval));
    if (context.config.reduce.window > base.duration)
        context.table("reduce").refuse(
            "window_s", fmt::format("must not exceed vibration.duration_s = {}", base.duration));
}

void check_replicates(const ConfigContext& context) {
    const core::TomlTable table = context.table("replicates");
    if (table.has("stems") && context.table("design").has("replicates"))
        table.refuse("stems", "not together with design.replicates, which means the same");
}

void check_timestep(ConfigContext& context) {
    if (context.config.kind != StudyKind::Timestep)
        return;
    if (context.config.base.integrator.method == run::IntegrationMethod::Explicit)
        context.table("integrator")
            .refuse("method", "of a time-step study it is that of the reference run: "
                              "\"implicit\" or \"sundials\"");
    const core::TomlTable table = context.table("timestep");
    TimestepOptions& options = context.config.timestep;
    // The growth of a motion just above the limit (run/explicit_steps.hpp): with fewer steps an
    // unstable one would count as stable.
    const auto fewest = static_cast<std::int64_t>(std::ceil(20.0 / options.limit_tolerance));
    if (!table.has("trial_steps"))
        options.trial_steps = std::max(options.trial_steps, fewest);
    else if (options.trial_steps < fewest)
        table.refuse("trial_steps",
                     fmt::format("must be at least 20/limit_tolerance = {}", fewest));
    std::ranges::sort(options.fractions);
    if (const auto twice = std::ranges::adjacent_find(options.fractions);
        twice != options.fractions.end())
        table.refuse("fractions", fmt::format("must name {} once only", *twice));
}

/// Records an error for every pair of which both are given; true if there is none.
bool check_exclusive_keys(const ConfigContext& context) {
    const std::size_t errors_before = context.errors.count();
    for (const ExclusiveKeys& pair : exclusive_keys) {
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
    for (const Violation& violation : violations_of(context.config.base)) {
        const auto place_of = [&](std::string_view key) { return context.places.find(key); };
        const bool is_varied = std::ranges::any_of(violation.keys, [&](std::string_view key) {
            const auto place = place_of(key);
            return place != context.places.end() &&
                   (place->second.section == "factors" || place->second.section == "design.point");
        });
        if (is_varied)
            continue;
        const auto given = std::ranges::find_if(violation.keys, [&](std::string_view key) {
            return place_of(key) != context.places.end();
        });
        // A constraint may be broken by defaults alone; then no key of the file is to blame.
        const std::size_t line = given != violation.keys.end() ? place_of(*given)->second.line : 1;
        context.errors.add(line, violation.key, violation.value, violation.allowed);
    }
}

/// Makes the keys of all tables known to the hints for unknown ones.
void declare_keys(const core::TomlTable& root) {
    for (const auto& table : study_tables()) {
        std::vector<std::string> names;
        for (const KeyDescription& key : table.keys())
            names.push_back(key.name);
        root.declare(table.name(), names);
    }
}

} // namespace

StudyConfig load_config(const std::filesystem::path& file) {
    return parse_config(core::file_text(file), file.string());
}

StudyConfig parse_config(std::string_view text, const std::string& file, const StudyFiles& files) {
    core::TomlDocument document(text, file);
    const core::TomlTable& root = document.root();
    core::FileFaults& errors = document.faults();
    StudyConfig config;
    config.file = file;
    config.name = std::filesystem::path(file).stem().string();
    config.text = std::string(text);
    ConfigContext context{root, config, errors, {}, files};
    declare_keys(root);
    // Each reader continues after an error, so that one run reports all of them. First the values,
    // then the conditions that keys put on one another.
    std::set<std::string> wrong;
    for (const auto& table : study_tables())
        table.read(context.table(table.name()), config, wrong);
    read_effects(context);
    const std::size_t errors_before_stem = errors.count();
    read_parameters("stem", context);
    read_parameters("release", context);
    const bool is_stem_known = errors.count() == errors_before_stem;
    for (const auto& table : study_tables())
        table.check(context.table(table.name()), config, wrong);
    check_storage(context);
    check_vibration(context, wrong);
    check_timestep(context);
    check_replicates(context);
    read_factors(context); // the design decides how factors are read
    const bool is_given_twice = !check_exclusive_keys(context);
    config.given.apply_to(config.base);
    config.base.effects = config.effects.with_defaults(config.base.stem);
    // Otherwise the default of a value that could not be read would be checked here.
    if (is_stem_known && !is_given_twice)
        check_base(context);
    document.finish();
    return config;
}

} // namespace culm::study
