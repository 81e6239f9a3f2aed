// SPDX-License-Identifier: BSD-3-Clause
// Reads a whole study file: section by section, then the constraints between sections.
#include "study/config/sections.hpp"

#include "core/error.hpp"
#include "core/user_files.hpp"
#include "study/config/keys.hpp"
#include "study/config/study_config.hpp"
#include "study/config/study_effects.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>

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

void read_heights(const TableReader& reader, ConfigContext& context) {
    const run::StoreLevel store = context.config.base.store;
    const auto heights = reader.numbers("heights_mm");
    if (store == run::StoreLevel::Heights && !reader.has("heights_mm"))
        reader.error("heights_mm", "store = \"heights\" needs it");
    if (!heights)
        return;
    // Heights must not exceed the stem (violations_of), which may be known only later: the
    // error then needs this line.
    context.note_given("heights_mm", {"study", reader.line("heights_mm")});
    if (store != run::StoreLevel::Heights && store != run::StoreLevel::Full)
        reader.error("heights_mm", "only with store = \"heights\" or \"full\"");
    auto sorted = *heights;
    std::ranges::sort(sorted);
    if (const auto twice = std::ranges::adjacent_find(sorted); twice != sorted.end())
        reader.error("heights_mm", fmt::format("must name {} once only", *twice));
    for (const double height : *heights)
        context.config.base.heights.push_back(millimetre.to_si(height));
}

void read_parameters(const std::string& section, ConfigContext& context) {
    const TableReader reader = context.checked_reader(section);
    for (const Parameter& parameter : parameters()) {
        if (parameter.section != section || !reader.has(parameter.key))
            continue;
        context.note_given(std::string(parameter.key), {section, reader.line(parameter.key)});
        if (const auto value = reader.number(parameter.key))
            context.config.given.set(parameter, parameter.unit.to_si(*value));
    }
}

void read_study(ConfigContext& context) {
    const TableReader reader = context.checked_reader("study");
    StudyConfig& config = context.config;
    config.name = reader.text("name").value_or(std::filesystem::path(config.file).stem().string());
    config.seed = static_cast<std::uint64_t>(reader.whole_number("seed").value_or(1));
    const bool is_vibration = reader.word("kind").value_or("vibration") == "vibration";
    config.kind = is_vibration ? StudyKind::Vibration : StudyKind::Timestep;
    const auto store = reader.word("store");
    const auto level =
        std::ranges::find(store_levels, store.value_or(is_vibration ? "tip" : "fit"));
    config.base.store = static_cast<run::StoreLevel>(level - store_levels.begin());
    // After a mistyped level of storage the heights would get a second, misleading error.
    if (store || !reader.has("store"))
        read_heights(reader, context);
}

void read_effects(ConfigContext& context) {
    const toml::table* table = context.section("study");
    const toml::node* node = table != nullptr ? table->get("effects") : nullptr;
    if (node == nullptr)
        return;
    const std::size_t line = line_of(*node);
    const toml::array* names = node->as_array();
    if (names == nullptr || !(names->empty() || names->is_homogeneous<std::string>())) {
        context.errors.add(line, "study.effects", value_text(*node), "must be a list of names");
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

void read_law(ConfigContext& context) {
    const TableReader reader = context.checked_reader("law");
    if (const auto named = physics::law_by_name(reader.word("name").value_or("schramm2019")))
        context.config.base.law = *named;
}

void read_integrator(ConfigContext& context) {
    const TableReader reader = context.checked_reader("integrator");
    run::Integrator& integrator = context.config.base.integrator;
    context.config.base.dimensions =
        static_cast<int>(reader.whole_number("dimensions").value_or(2));
    integrator.relative_tolerance =
        reader.number("relative_tolerance").value_or(integrator.relative_tolerance);
    // Read for every method, so that its range is checked before the method refuses it.
    integrator.timestep = reader.number("timestep_s").value_or(0.0);
    const auto method = reader.word("method");
    if (!method && reader.has("method"))
        return;
    const bool is_explicit = method == "explicit";
    const bool is_sundials = method == "sundials";
    integrator.method = is_explicit   ? run::IntegrationMethod::Explicit
                        : is_sundials ? run::IntegrationMethod::Sundials
                                      : run::IntegrationMethod::Implicit;
    if (is_explicit && !reader.has("timestep_s"))
        reader.error("timestep_s", "method = \"explicit\" needs it");
    if (!is_explicit && reader.has("timestep_s"))
        reader.error("timestep_s", "only with method = \"explicit\"; implicit methods choose "
                                   "their steps by relative_tolerance");
    if (is_explicit && reader.has("relative_tolerance"))
        reader.error("relative_tolerance",
                     "only with an implicit method; the explicit method needs timestep_s");
}

void read_vibration(ConfigContext& context) {
    const TableReader reader = context.checked_reader("vibration");
    run::CaseSpec& base = context.config.base;
    const std::size_t errors_before = context.errors.count();
    base.duration = reader.number("duration_s").value_or(base.duration);
    base.sample_interval = reader.number("sample_interval_s").value_or(base.sample_interval);
    if (context.errors.count() != errors_before)
        return;
    // The error refers to a key that the user gave, because only such a key has a line.
    const char* duration_key = reader.has("duration_s") ? "duration_s" : "sample_interval_s";
    if (base.sample_interval > base.duration)
        reader.error("sample_interval_s",
                     fmt::format("must not exceed duration_s = {}", base.duration));
    else if (!is_multiple(base.duration, base.sample_interval))
        reader.error(duration_key,
                     fmt::format("duration_s = {} must be a multiple of sample_interval_s = {}",
                                 base.duration, base.sample_interval));
    const double step = base.integrator.timestep;
    // The explicit method has no interpolation: every sample must fall on a step.
    if (base.integrator.method == run::IntegrationMethod::Explicit && step > 0.0 &&
        !is_multiple(base.sample_interval, step))
        context.reader("integrator")
            .error("timestep_s", fmt::format("must divide vibration.sample_interval_s = {}",
                                             base.sample_interval));
}

void read_reduce(ConfigContext& context) {
    const TableReader reader = context.checked_reader("reduce");
    ReduceOptions& reduce = context.config.reduce;
    reduce.window = reader.number("window_s");
    if (reduce.window > context.config.base.duration)
        reader.error("window_s", fmt::format("must not exceed vibration.duration_s = {}",
                                             context.config.base.duration));
    reduce.is_amplitude_free = reader.word("amplitude").value_or("free") == "free";
    reduce.significance = reader.number("significance").value_or(reduce.significance);
}

void read_archive(ConfigContext& context) {
    const TableReader reader = context.checked_reader("archive");
    context.config.trajectory_compression =
        static_cast<int>(reader.whole_number("trajectory_compression").value_or(0));
}

void read_replicates(ConfigContext& context) {
    const TableReader reader = context.checked_reader("replicates");
    DesignOptions& design = context.config.design;
    const toml::table* of_design = context.section("design");
    if (reader.has("stems") && of_design != nullptr && of_design->contains("replicates"))
        reader.error("stems", "not together with design.replicates, which means the same");
    design.replicates = reader.whole_number("stems").value_or(design.replicates);
    design.tests = reader.whole_number("within").value_or(1);
}

void read_design(ConfigContext& context) {
    const TableReader reader = context.checked_reader("design");
    DesignOptions& design = context.config.design;
    const std::string type = reader.word("type").value_or("factorial");
    design.type =
        static_cast<DesignType>(std::ranges::find(design_types, type) - design_types.begin());
    design.points = reader.whole_number("points").value_or(0);
    design.replicates = reader.whole_number("replicates").value_or(1);
    if (design.is_sampled() && !reader.has("points"))
        reader.error("points", fmt::format("type = \"{}\" needs it", type));
    if (!design.is_sampled() && reader.has("points"))
        reader.error("points", "only with type = \"latin_hypercube\" or \"sobol\"");
    if (reader.word("scrambling") == "owen")
        design.scrambling = Scrambling::Owen;
    if (reader.has("scrambling") && design.type != DesignType::Sobol)
        reader.error("scrambling", "only with type = \"sobol\"");
    if (design.type == DesignType::List && !reader.has("point"))
        reader.error("point", "type = \"list\" needs [[design.point]] tables");
    if (design.type != DesignType::List && reader.has("point"))
        reader.error("point", "only with type = \"list\"");
}

struct KeyPlace {
    const char* section;
    const char* key;
};

/// Keys of what a time-step study chooses automatically: its steps, its record and its storage.
constexpr std::array keys_of_vibrations{KeyPlace{"study", "heights_mm"},
                                        KeyPlace{"integrator", "timestep_s"},
                                        KeyPlace{"integrator", "relative_tolerance"},
                                        KeyPlace{"vibration", "duration_s"},
                                        KeyPlace{"vibration", "sample_interval_s"},
                                        KeyPlace{"reduce", "window_s"},
                                        KeyPlace{"reduce", "significance"},
                                        KeyPlace{"archive", "trajectory_compression"}};

constexpr std::array keys_of_comparisons{"record_cycles", "samples_per_cycle",
                                         "reference_tolerance"};

void refuse_keys_of_vibrations(ConfigContext& context) {
    for (const KeyPlace& place : keys_of_vibrations) {
        const TableReader reader = context.reader(place.section);
        if (reader.has(place.key))
            reader.error(place.key, "only with study.kind = \"vibration\"");
    }
    if (context.config.base.integrator.method == run::IntegrationMethod::Explicit)
        context.reader("integrator")
            .error("method", "of a time-step study it is that of the reference run: \"implicit\" "
                             "or \"sundials\"");
    if (context.config.base.store != run::StoreLevel::Fit)
        context.reader("study").error(
            "store", "study.kind = \"timestep\" keeps no histories: \"fit\" or nothing");
}

void read_fractions(const TableReader& reader, ConfigContext& context) {
    std::vector<double>& fractions = context.config.timestep.fractions;
    fractions = reader.numbers("fractions").value_or(std::vector<double>());
    std::ranges::sort(fractions);
    if (const auto twice = std::ranges::adjacent_find(fractions); twice != fractions.end())
        reader.error("fractions", fmt::format("must name {} once only", *twice));
    for (const char* key : keys_of_comparisons)
        if (!reader.has("fractions") && reader.has(key))
            reader.error(key, "only with timestep.fractions");
}

void read_timestep(ConfigContext& context) {
    const TableReader reader = context.checked_reader("timestep");
    if (context.config.kind != StudyKind::Timestep) {
        for (const ConfigKey& key : config_keys_of("timestep"))
            if (reader.has(key.key))
                reader.error(key.key, "only with study.kind = \"timestep\"");
        return;
    }
    refuse_keys_of_vibrations(context);
    TimestepOptions& options = context.config.timestep;
    options.limit_tolerance = reader.number("limit_tolerance").value_or(options.limit_tolerance);
    // The growth of a motion just above the limit (run/explicit_steps.hpp): with fewer steps an
    // unstable one would count as stable.
    const auto fewest = static_cast<std::int64_t>(std::ceil(20.0 / options.limit_tolerance));
    options.trial_steps =
        reader.whole_number("trial_steps").value_or(std::max(options.trial_steps, fewest));
    if (options.trial_steps < fewest)
        reader.error("trial_steps",
                     fmt::format("must be at least 20/limit_tolerance = {}", fewest));
    read_fractions(reader, context);
    options.record_cycles = reader.number("record_cycles").value_or(options.record_cycles);
    options.samples_per_cycle =
        reader.whole_number("samples_per_cycle").value_or(options.samples_per_cycle);
    options.reference_tolerance =
        reader.number("reference_tolerance").value_or(options.reference_tolerance);
}

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
    read_effects(context); // after the study's kind, before the factors
    const std::size_t errors_before_stem = errors.count();
    read_parameters("stem", context);
    read_parameters("release", context);
    const bool is_stem_known = errors.count() == errors_before_stem;
    read_law(context);
    read_integrator(context);
    read_vibration(context); // after the integrator, whose step must fit
    read_reduce(context);    // after the vibration, whose duration it needs
    read_archive(context);
    read_timestep(context);   // after the study, whose kind decides
    read_design(context);     // before the factors
    read_replicates(context); // after the design, before the factors
    read_factors(context);
    read_correlation(context); // after the factors
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
