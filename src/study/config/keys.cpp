// SPDX-License-Identifier: BSD-3-Clause
#include "study/config/keys.hpp"

#include "physics/bond_law_options.hpp"
#include "study/config/parameters.hpp"

#include <limits>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace culm::study {

namespace {

using core::Choices;
using core::Interval;
using core::path;
using core::ValueKind;
using run::CaseSpec;
using run::IntegrationMethod;
using run::Integrator;
using Table = core::KeyTable<StudyConfig>;

constexpr Interval any_number{-std::numeric_limits<double>::max(),
                              std::numeric_limits<double>::max()};
constexpr Interval positive{0.0, any_number.high, true, false};
constexpr Interval positive_time{0.0, 10000.0, true, false};
constexpr Interval counts{1.0, 1e8};
constexpr double largest_whole = 9007199254740992.0; // 2⁵³: whole numbers up to it are exact

constexpr Choices<StudyKind, 2> kinds{
    {{"vibration", StudyKind::Vibration}, {"timestep", StudyKind::Timestep}}};
constexpr Choices<run::StoreLevel, 4> store_levels{{{"fit", run::StoreLevel::Fit},
                                                    {"tip", run::StoreLevel::Tip},
                                                    {"heights", run::StoreLevel::Heights},
                                                    {"full", run::StoreLevel::Full}}};
constexpr Choices<IntegrationMethod, 3> methods{{{"implicit", IntegrationMethod::Implicit},
                                                 {"sundials", IntegrationMethod::Sundials},
                                                 {"explicit", IntegrationMethod::Explicit}}};
constexpr Choices<DesignType, 4> design_types{{{"factorial", DesignType::Factorial},
                                               {"latin_hypercube", DesignType::LatinHypercube},
                                               {"sobol", DesignType::Sobol},
                                               {"list", DesignType::List}}};
constexpr Choices<Scrambling, 2> scramblings{
    {{"none", Scrambling::None}, {"owen", Scrambling::Owen}}};
constexpr Choices<bool, 2> amplitudes{{{"free", true}, {"fixed", false}}};

bool is_vibration(const StudyConfig& config) {
    return config.kind == StudyKind::Vibration;
}

bool is_timestep(const StudyConfig& config) {
    return config.kind == StudyKind::Timestep;
}

bool is_explicit(const StudyConfig& config) {
    return config.base.integrator.method == IntegrationMethod::Explicit;
}

bool stores_heights(const StudyConfig& config) {
    return config.base.store == run::StoreLevel::Heights;
}

bool is_sampled(const StudyConfig& config) {
    return config.design.is_sampled();
}

template <DesignType type>
bool is_design(const StudyConfig& config) {
    return config.design.type == type;
}

/// A time-step study chooses its steps, its record and its storage.
core::Key<StudyConfig>& of_vibrations(core::Key<StudyConfig>& key) {
    return key.only_if("study.kind", is_vibration, "only with study.kind = \"vibration\"");
}

core::Key<StudyConfig>& of_timesteps(core::Key<StudyConfig>& key) {
    return key.only_if("study.kind", is_timestep, "only with study.kind = \"timestep\"");
}

core::Key<StudyConfig>& of_comparisons(core::Key<StudyConfig>& key) {
    return of_timesteps(key).only_if(
        "timestep.fractions",
        [](const StudyConfig& config) { return !config.timestep.fractions.empty(); },
        "only with timestep.fractions");
}

Table study_keys() {
    Table study("study");
    study.key("name", &StudyConfig::name, "how the study is called in reports")
        .otherwise("the file's name")
        .without_influence();
    study.key("kind", &StudyConfig::kind, kinds,
              "what is computed at each point: the free vibration, or how large explicit steps may "
              "be (docs/timestep.md)");
    study
        .key("store", path(&StudyConfig::base, &CaseSpec::store), store_levels,
             "what of every trajectory is kept; each word includes the ones before it")
        .shown_as([](const StudyConfig& config) {
            return is_vibration(config)
                       ? std::string(core::word_of(store_levels, config.base.store))
                       : std::string();
        });
    of_vibrations(study.key("heights_mm", path(&StudyConfig::base, &CaseSpec::heights),
                            {0.0, 100000.0},
                            "heights above the clamp at which the deflection is stored; needed by "
                            "`heights`, possible with `full`"))
        .only_if(
            "study.store",
            [](const StudyConfig& config) {
                return stores_heights(config) || config.base.store == run::StoreLevel::Full;
            },
            "only with store = \"heights\" or \"full\"")
        .needed_if("study.store", stores_heights, "store = \"heights\" needs it");
    study.key({.name = "effects",
               .kind = ValueKind::WordList,
               .default_text = "[]",
               .meaning = "what is added to the published chain, as on the command line: names, "
                          "with values in parentheses if they are not the defaults, or files "
                          "(docs/effects.md); `\"effect.parameter\"` may be a factor"});
    study.key("seed", &StudyConfig::seed, {0.0, largest_whole},
              "selects the random numbers of the study");
    return study;
}

Table integrator_keys() {
    Table integrator("integrator");
    const auto options = [](auto member) {
        return path(&StudyConfig::base, &CaseSpec::integrator, member);
    };
    integrator
        .key("method", options(&Integrator::method), methods,
             "time integration: culm's own implicit method on SIMD lanes, an implicit method of "
             "SUNDIALS, or velocity Verlet; of a time-step study, that of the reference run")
        .shown_as([](const StudyConfig& config) {
            const IntegrationMethod method = config.base.integrator.method;
            const bool is_stated = is_vibration(config) || method == IntegrationMethod::Sundials;
            return is_stated ? std::string(core::word_of(methods, method)) : std::string();
        });
    of_vibrations(integrator.key("timestep_s", options(&Integrator::timestep),
                                 {0.0, 1.0, true, false},
                                 "step of the explicit method, which needs it; must divide "
                                 "sample_interval_s"))
        .otherwise("")
        .only_if("integrator.method", is_explicit,
                 "only with method = \"explicit\"; implicit methods choose their steps by "
                 "relative_tolerance")
        .needed_if("integrator.method", is_explicit, "method = \"explicit\" needs it");
    of_vibrations(integrator.key(
                      "relative_tolerance", options(&Integrator::relative_tolerance), {1e-12, 1e-2},
                      "of the implicit methods: error of the positions allowed per step, as a "
                      "share of the released deflection"))
        .only_if(
            "integrator.method", [](const StudyConfig& config) { return !is_explicit(config); },
            "only with an implicit method; the explicit method needs timestep_s");
    integrator.key("dimensions", path(&StudyConfig::base, &CaseSpec::dimensions), {2.0, 3.0},
                   "2: motion in the plane of the pull; 3: in space");
    return integrator;
}

Table law_keys() {
    Table law("law");
    // The name sets several members, so a function reads it.
    core::Key<StudyConfig>& name =
        law.key({.name = "name",
                 .kind = ValueKind::Word,
                 .default_text = fmt::format("\"{}\"", physics::law_name(CaseSpec{}.law)),
                 .words = physics::law_names(),
                 .meaning = "bond law: as in the authors' code, or conserving angular momentum"});
    name.read = [words = name.words, allowed = name.allowed()](const core::TomlTable& table,
                                                               StudyConfig& config) {
        const auto index = table.word("name", words, allowed);
        if (index)
            config.base.law = physics::law_by_name(words[*index]).value();
        return index.has_value();
    };
    name.shown_as([](const StudyConfig& config) { return physics::law_name(config.base.law); });
    return law;
}

Table vibration_keys() {
    Table vibration("vibration");
    of_vibrations(vibration.key("duration_s", path(&StudyConfig::base, &CaseSpec::duration),
                                positive_time,
                                "of the free vibration; a multiple of sample_interval_s"));
    of_vibrations(vibration.key("sample_interval_s",
                                path(&StudyConfig::base, &CaseSpec::sample_interval), positive_time,
                                "time between stored samples"));
    return vibration;
}

Table design_keys() {
    Table design("design");
    design.key("type", path(&StudyConfig::design, &DesignOptions::type), design_types,
               "how factors are combined to points");
    design
        .key("points", path(&StudyConfig::design, &DesignOptions::points), counts,
             "number of design points; for `latin_hypercube` and `sobol`, which need it")
        .otherwise("")
        .only_if("design.type", is_sampled, "only with type = \"latin_hypercube\" or \"sobol\"")
        .needed_if("design.type", is_design<DesignType::LatinHypercube>,
                   "type = \"latin_hypercube\" needs it")
        .needed_if("design.type", is_design<DesignType::Sobol>, "type = \"sobol\" needs it")
        .without_influence(); // of a list it follows from the tables; see identity()
    design.key("replicates", path(&StudyConfig::design, &DesignOptions::replicates), counts,
               "repetitions of every design point with new draws of the distributions; "
               "`replicates.stems` is the same");
    design
        .key("scrambling", path(&StudyConfig::design, &DesignOptions::scrambling), scramblings,
             "how a Sobol sequence is made random")
        .only_if("design.type", is_design<DesignType::Sobol>, "only with type = \"sobol\"");
    design
        .key({.name = "point",
              .kind = ValueKind::Tables,
              .meaning = "the points of a `list`, which needs them: every table gives one point's "
                         "values"})
        .only_if("design.type", is_design<DesignType::List>, "only with type = \"list\"")
        .needed_if("design.type", is_design<DesignType::List>,
                   "type = \"list\" needs [[design.point]] tables");
    return design;
}

Table replicate_keys() {
    Table replicates("replicates");
    replicates
        .key("stems", path(&StudyConfig::design, &DesignOptions::replicates), counts,
             "stems for every design point, each with new draws of the distributions")
        .without_influence(); // as design.replicates it has
    replicates.key("within", path(&StudyConfig::design, &DesignOptions::tests), counts,
                   "tests of every stem, with new draws of what has level = \"test\" or within_sd");
    return replicates;
}

Table reduce_keys() {
    Table reduce("reduce");
    of_vibrations(reduce.key("window_s", path(&StudyConfig::reduce, &ReduceOptions::window),
                             positive_time, "time from the release to which Eq. 1 is fitted"))
        .otherwise("the whole record")
        .shown_as([](const StudyConfig& config) {
            return fmt::format("{}", config.reduce.window.value_or(config.base.duration));
        });
    reduce.key("amplitude", path(&StudyConfig::reduce, &ReduceOptions::is_amplitude_free),
               amplitudes, "is b0 fitted, or fixed at the deflection of the release?");
    of_vibrations(reduce.key(
        "significance", path(&StudyConfig::reduce, &ReduceOptions::significance),
        {0.0, 1.0, true, true}, "a term of the regressions stays if its F-test has p below this"));
    return reduce;
}

Table timestep_keys() {
    Table timestep("timestep");
    const auto options = [](auto member) { return path(&StudyConfig::timestep, member); };
    of_timesteps(
        timestep.key("limit_tolerance", options(&TimestepOptions::limit_tolerance), {1e-5, 0.5},
                     "the largest stable step is bisected until it is known this closely"));
    of_timesteps(
        timestep.key("trial_steps", options(&TimestepOptions::trial_steps), {100.0, 1e9},
                     "steps of every run of the bisection; at least 20/limit_tolerance, or a weak "
                     "instability would not show"))
        .otherwise("20000, or 20/limit_tolerance if that is more");
    of_timesteps(timestep.key("fractions", options(&TimestepOptions::fractions),
                              {0.0, 1.0, true, true},
                              "steps whose b1 and b2 are compared, as shares of the linearised "
                              "chain's limit"))
        .otherwise("none: the limits alone")
        .shown_as([](const StudyConfig& config) {
            return fmt::format("[{}]", fmt::join(config.timestep.fractions, ", "));
        });
    of_comparisons(timestep.key("record_cycles", options(&TimestepOptions::record_cycles),
                                {1.0, 1000.0},
                                "length of the compared histories, in periods of the undamped "
                                "stem"));
    of_comparisons(timestep.key("samples_per_cycle", options(&TimestepOptions::samples_per_cycle),
                                {8.0, 1000.0}, "of the compared histories"));
    of_comparisons(timestep.key(
        "reference_tolerance", options(&TimestepOptions::reference_tolerance), {1e-12, 1e-2},
        "of the implicit run whose b1 and b2 are the reference of the explicit ones"));
    return timestep;
}

Table archive_keys() {
    Table archive("archive");
    of_vibrations(archive.key("trajectory_compression", &StudyConfig::trajectory_compression,
                              {0.0, 9.0},
                              "deflate level of the positions in a study file that `culm archive "
                              "merge` writes; 0: none"))
        .without_influence();
    of_vibrations(
        archive.key("trajectory_precision", &StudyConfig::single_precision_trajectories,
                    Choices<bool, 2>{{{"float64", false}, {"float32", true}}},
                    "of the stored positions: `float32` needs half the space and keeps 7 digits"));
    return archive;
}

/// The rows of parameters.hpp, which are read and compared by their own rules.
Table parameter_keys(std::string_view section) {
    Table table{std::string(section)};
    for (const Parameter& parameter : parameters())
        if (parameter.section == section)
            table.key(description_of(parameter));
    return table;
}

core::KeyTable<FactorEntry> factor_keys() {
    using Entry = FactorEntry;
    core::KeyTable<Entry> table("factors.<parameter>");
    const auto number = [&table](const char* name, auto member, const Interval& range,
                                 const char* meaning) -> core::Key<Entry>& {
        core::Key<Entry>& key = table.key(name, member, range, meaning);
        key.unit = "as the parameter";
        return key;
    };
    number("from", &Entry::from, any_number, "first value of a range");
    number("to", &Entry::to, any_number, "last value of a range");
    number("step", &Entry::step, positive,
           "distance of the levels of a range; must divide to − from");
    table.key("count", &Entry::count, {2.0, 1e6},
              "number of levels of a range, both ends included; instead of step");
    table.key("spacing", &Entry::spacing,
              Choices<Spacing, 2>{{{"linear", Spacing::Linear}, {"log", Spacing::Log}}},
              "are the levels equidistant, or their logarithms?");
    table
        .key("distribution", &Entry::distribution,
             Choices<std::optional<DrawnFrom>, 4>{{{"normal", DrawnFrom::Normal},
                                                   {"lognormal", DrawnFrom::Lognormal},
                                                   {"uniform", DrawnFrom::Uniform},
                                                   {"empirical", DrawnFrom::Empirical}}},
             "the factor is drawn from a distribution; `empirical`: from measured values")
        .otherwise("");
    number("mean", &Entry::mean, any_number,
           "of the normal, or of the lognormal quantity itself, before truncation");
    number("sd", &Entry::sd, positive, "standard deviation of the same");
    number("min", &Entry::min, any_number, "lower truncation; needed by `uniform`")
        .otherwise("the parameter's range");
    number("max", &Entry::max, any_number, "upper truncation; needed by `uniform`")
        .otherwise("the parameter's range");
    table.key("file", &Entry::file,
              "table (CSV with a header) of measured stems, in the study's folder or below it; "
              "needed by `empirical`");
    table.key("column", &Entry::column, "header of the column; needed by `empirical`");
    table.key("unit", &Entry::unit, "of the column, for example \"cm\"")
        .otherwise("that of the column's name, else of the parameter");
    table.key("rows", &Entry::rows,
              Choices<Rows, 2>{{{"independent", Rows::Independent}, {"together", Rows::Together}}},
              "`together`: columns of the same file are taken from the same row, so that a stem's "
              "values stay together");
    table.key("level", &Entry::level,
              Choices<Level, 2>{{{"stem", Level::Stem}, {"test", Level::Test}}},
              "is a distribution drawn once for each stem, or for each test of a stem?");
    number("within_sd", &Entry::within_sd, positive,
           "standard deviation of the tests of a stem about the stem's own value (normal, confined "
           "to the parameter's range)")
        .otherwise("none");
    return table;
}

} // namespace

KeyDescription description_of(const Parameter& parameter) {
    return {std::string(parameter.section),
            std::string(parameter.key),
            parameter.is_whole_number ? ValueKind::WholeNumber : ValueKind::Number,
            std::string(parameter.unit.name),
            std::string(parameter.default_text),
            parameter.range,
            {},
            std::string(parameter.meaning)};
}

const std::vector<core::KeyTable<StudyConfig>>& study_tables() {
    static const std::vector tables{
        study_keys(),     parameter_keys("stem"), parameter_keys("release"),
        law_keys(),       integrator_keys(),      vibration_keys(),
        Table("factors"), design_keys(),          replicate_keys(),
        reduce_keys(),    archive_keys(),         timestep_keys()};
    return tables;
}

const core::KeyTable<FactorEntry>& factor_table() {
    static const core::KeyTable<FactorEntry> table = factor_keys();
    return table;
}

std::vector<KeyDescription> config_keys() {
    std::vector<KeyDescription> keys;
    for (const Table& table : study_tables()) {
        keys.insert(keys.end(), table.keys().begin(), table.keys().end());
        if (table.name() == "factors")
            keys.insert(keys.end(), factor_table().keys().begin(), factor_table().keys().end());
    }
    return keys;
}

} // namespace culm::study
