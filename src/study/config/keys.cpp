// SPDX-License-Identifier: BSD-3-Clause
#include "study/config/keys.hpp"

#include "core/nearest_name.hpp"
#include "core/toml/value.hpp"
#include "physics/bond_law_options.hpp"
#include "study/config/parameters.hpp"

#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace culm::study {

namespace {

std::string with_unit(const std::string& text, const std::string& unit) {
    return unit.empty() || unit == "as the parameter" ? text : text + " " + unit;
}

std::string number_in(const Interval& range, const std::string& unit) {
    if (range.high < std::numeric_limits<double>::max())
        return "number in " + with_unit(range.text(), unit);
    return range.low < 0.0 ? "number" : "number above 0";
}

/// The hint for a key that names a valid quantity with another unit, or with none.
std::optional<std::string> unit_hint(const UnknownKey& unknown,
                                     std::span<const std::string> valid) {
    const KeyParts found = split_key(unknown.key);
    for (const std::string& key : valid) {
        const KeyParts right = split_key(key);
        // The same quantity in another unit: the key was meant.
        if (right.quantity != found.quantity || !right.unit)
            continue;
        if (!found.unit || found.unit->dimension != right.unit->dimension || !unknown.value)
            return fmt::format("unknown key: write {}, in {}", key, right.unit->name);
        // The value is converted too: with a new key alone the stem would change by powers of ten.
        const double converted = right.unit->from_si(found.unit->to_si(*unknown.value));
        return fmt::format("unknown key: the unit is {} (write {} = {:.12g})", right.unit->name,
                           key, converted);
    }
    return std::nullopt;
}

constexpr Interval any_number{-std::numeric_limits<double>::max(),
                              std::numeric_limits<double>::max()};

using Keys = std::vector<ConfigKey>;
using Words = std::vector<std::string>;

/// Adds the keys of one section.
class Section {
  public:
    Section(Keys& keys, std::string name) : keys_(keys), name_(std::move(name)) {}

    void add(ValueKind kind, const char* key, const std::string& unit, const char* default_text,
             const Interval& range, const Words& words, const char* meaning) {
        keys_.push_back({name_, key, kind, unit, default_text, range, words, meaning});
    }
    void text(const char* key, const char* default_text, const char* meaning) {
        add(ValueKind::Text, key, "", default_text, {}, {}, meaning);
    }
    void word(const char* key, const char* default_text, const Words& words, const char* meaning) {
        add(ValueKind::Word, key, "", default_text, {}, words, meaning);
    }
    void number(const char* key, const std::string& unit, const char* default_text,
                const Interval& range, const char* meaning) {
        add(ValueKind::Number, key, unit, default_text, range, {}, meaning);
    }
    void whole(const char* key, const char* default_text, const Interval& range,
               const char* meaning) {
        add(ValueKind::WholeNumber, key, "", default_text, range, {}, meaning);
    }

  private:
    Keys& keys_;
    std::string name_;
};

/// Keys of the table of one factor.
Keys factor_keys() {

    const std::string unit = "as the parameter";
    Keys keys;
    Section factor(keys, "factors.<parameter>");
    factor.number("from", unit, "", any_number, "first value of a range");
    factor.number("to", unit, "", any_number, "last value of a range");
    factor.number("step", unit, "", {0.0, any_number.high, true, false},
                  "distance of the levels of a range; must divide to − from");
    factor.whole("count", "", {2.0, 1e6},
                 "number of levels of a range, both ends included; instead of step");
    factor.word("spacing", "\"linear\"", {"linear", "log"},
                "are the levels equidistant, or their logarithms?");
    factor.word("distribution", "", {"normal", "lognormal", "uniform", "empirical"},
                "the factor is drawn from a distribution; `empirical`: from measured values");
    factor.number("mean", unit, "", any_number,
                  "of the normal, or of the lognormal quantity itself, before truncation");
    factor.number("sd", unit, "", {0.0, any_number.high, true, false},
                  "standard deviation of the same");
    factor.number("min", unit, "the parameter's range", any_number,
                  "lower truncation; needed by `uniform`");
    factor.number("max", unit, "the parameter's range", any_number,
                  "upper truncation; needed by `uniform`");
    factor.text("file", "",
                "table (CSV with a header) of measured stems, in the study's folder or below it; "
                "needed by `empirical`");
    factor.text("column", "", "header of the column; needed by `empirical`");
    factor.text("unit", "that of the column's name, else of the parameter",
                "of the column, for example \"cm\"");
    factor.word("rows", "\"independent\"", {"independent", "together"},
                "`together`: columns of the same file are taken from the same row, so that a "
                "stem's values stay together");
    factor.word("level", "\"stem\"", {"stem", "test"},
                "is a distribution drawn once for each stem, or for each test of a stem?");
    factor.number("within_sd", unit, "none", {0.0, any_number.high, true, false},
                  "standard deviation of the tests of a stem about the stem's own value (normal, "
                  "confined to the parameter's range)");
    return keys;
}

/// Keys of [design], [replicates] and [correlation].
Keys design_keys() {
    Keys keys;
    Section design(keys, "design");
    design.word("type", "\"factorial\"", {"factorial", "latin_hypercube", "sobol", "list"},
                "how factors are combined to points");
    design.whole("points", "", {1.0, 1e8},
                 "number of design points; for `latin_hypercube` and `sobol`, which need it");
    design.whole("replicates", "1", {1.0, 1e8},
                 "repetitions of every design point with new draws of the distributions; "
                 "`replicates.stems` is the same");
    design.word("scrambling", "\"none\"", {"none", "owen"}, "how a Sobol sequence is made random");
    design.add(ValueKind::Tables, "point", "", "", {}, {},
               "the points of a `list`, which needs them: every table gives one point's values");
    Section replicates(keys, "replicates");
    replicates.whole("stems", "1", {1.0, 1e8},
                     "stems for every design point, each with new draws of the distributions");
    replicates.whole(
        "within", "1", {1.0, 1e8},
        "tests of every stem, with new draws of what has level = \"test\" or within_sd");
    Section correlation(keys, "correlation");
    correlation.add(ValueKind::WordList, "factors", "", "", {}, {},
                    "factors that are correlated with each other; needs `rank`");
    correlation.add(ValueKind::Matrix, "rank", "", "", {-1.0, 1.0}, {},
                    "their rank correlations (Spearman), in the order of `factors`");
    return keys;
}

constexpr double largest_whole = 9007199254740992.0; // 2⁵³: whole numbers up to it are exact

Keys study_keys() {
    Keys keys;
    Section study(keys, "study");
    study.text("name", "the file's name", "how the study is called in reports");
    study.word("kind", "\"vibration\"", {"vibration", "timestep"},
               "what is computed at each point: the free vibration, or how large explicit steps "
               "may be (docs/timestep.md)");
    study.word("store", "\"tip\"", {"fit", "tip", "heights", "full"},
               "what of every trajectory is kept; each word includes the ones before it");
    study.add(ValueKind::NumberList, "heights_mm", "mm", "", {0.0, 100000.0}, {},
              "heights above the clamp at which the deflection is stored; needed by `heights`, "
              "possible with `full`");
    study.add(ValueKind::WordList, "effects", "", "[]", {}, {},
              "what is added to the published chain, as on the command line: names, with values in "
              "parentheses if they are not the defaults, or files (docs/effects.md); "
              "`\"effect.parameter\"` may be a factor");
    study.whole("seed", "1", {0.0, largest_whole}, "selects the random numbers of the study");
    return keys;
}

/// Parameters are in a separate table (parameters.cpp) because factors use them too; the catalogue
/// takes its rows from there.
Keys parameter_keys(std::string_view section) {
    Keys keys;
    for (const Parameter& p : parameters())
        if (p.section == section)
            keys.push_back({std::string(section),
                            std::string(p.key),
                            p.is_whole_number ? ValueKind::WholeNumber : ValueKind::Number,
                            std::string(p.unit.name),
                            std::string(p.default_text),
                            p.range,
                            {},
                            std::string(p.meaning)});
    return keys;
}

Keys model_keys() {
    Keys keys;
    Section law(keys, "law");
    law.word("name", "\"schramm2019\"", physics::law_names(),
             "bond law: as in the authors' code, or conserving angular momentum");
    Section integrator(keys, "integrator");
    integrator.word(
        "method", "\"implicit\"", {"implicit", "sundials", "explicit"},
        "time integration: culm's own implicit method on SIMD lanes, an implicit method of "
        "SUNDIALS, or velocity Verlet; of a time-step study, that of the reference run");
    integrator.number("timestep_s", "s", "", {0.0, 1.0, true, false},
                      "step of the explicit method, which needs it; must divide sample_interval_s");
    integrator.number(
        "relative_tolerance", "", "2e-06", {1e-12, 1e-2},
        "of the implicit methods: error of the positions allowed per step, as a share of the "
        "released deflection");
    integrator.whole("dimensions", "2", {2.0, 3.0},
                     "2: motion in the plane of the pull; 3: in space");
    Section vibration(keys, "vibration");
    vibration.number("duration_s", "s", "0.1", {0.0, 10000.0, true, false},
                     "of the free vibration; a multiple of sample_interval_s");
    vibration.number("sample_interval_s", "s", "5e-05", {0.0, 10000.0, true, false},
                     "time between stored samples");
    return keys;
}

Keys output_keys() {
    Keys keys;
    Section reduce(keys, "reduce");
    reduce.number("window_s", "s", "the whole record", {0.0, 10000.0, true, false},
                  "time from the release to which Eq. 1 is fitted");
    reduce.word("amplitude", "\"free\"", {"free", "fixed"},
                "is b0 fitted, or fixed at the deflection of the release?");
    reduce.number("significance", "", "0.05", {0.0, 1.0, true, true},
                  "a term of the regressions stays if its F-test has p below this");
    Section archive(keys, "archive");
    archive.whole("trajectory_compression", "0", {0.0, 9.0},
                  "deflate level of the stored positions; 0: none");
    return keys;
}

Keys timestep_keys() {
    Keys keys;
    Section timestep(keys, "timestep");
    timestep.number("limit_tolerance", "", "0.01", {1e-5, 0.5},
                    "the largest stable step is bisected until it is known this closely");
    timestep.whole("trial_steps", "20000, or 20/limit_tolerance if that is more", {100.0, 1e9},
                   "steps of every run of the bisection; at least 20/limit_tolerance, or a weak "
                   "instability would not show");
    timestep.add(ValueKind::NumberList, "fractions", "", "none: the limits alone",
                 {0.0, 1.0, true, true}, {},
                 "steps whose b1 and b2 are compared, as shares of the linearised chain's limit");
    timestep.number("record_cycles", "", "2", {1.0, 1000.0},
                    "length of the compared histories, in periods of the undamped stem");
    timestep.whole("samples_per_cycle", "40", {8.0, 1000.0}, "of the compared histories");
    timestep.number("reference_tolerance", "", "1e-09", {1e-12, 1e-2},
                    "of the implicit run whose b1 and b2 are the reference of the explicit ones");
    return keys;
}

} // namespace

std::string ConfigKey::allowed() const {
    switch (kind) {
    case ValueKind::Text:
        return "text";
    case ValueKind::Word:
        return core::one_of(words);
    case ValueKind::Number:
        return "a " + number_in(range, unit);
    case ValueKind::WholeNumber:
        return "a whole " + number_in(range, unit);
    case ValueKind::Tables:
        return "tables [[design.point]] with the same parameters in each";
    case ValueKind::WordList:
        return "a list of names";
    case ValueKind::Matrix:
        return "a square matrix [[…], …] of numbers in " + range.text();
    case ValueKind::NumberList:
        return "a list of numbers in " + with_unit(range.text(), unit);
    }
    return {};
}

std::vector<ConfigKey> config_keys_of(std::string_view section) {
    std::vector<ConfigKey> keys = config_keys();
    std::erase_if(keys, [&](const ConfigKey& key) { return key.section != section; });
    return keys;
}

std::string config_key_tables() {
    const auto or_dash = [](const std::string& s) { return s.empty() ? "–" : s.c_str(); };
    std::string text;
    std::string section;
    for (const ConfigKey& key : config_keys()) {
        if (key.section != section) {
            section = key.section;
            text += fmt::format("\n### `[{}]`\n\n| key | unit | default | allowed | meaning |\n"
                                "|---|---|---|---|---|\n",
                                section);
        }
        text += fmt::format("| `{}` | {} | {} | {} | {} |\n", key.key, or_dash(key.unit),
                            or_dash(key.default_text), key.allowed(), key.meaning);
    }
    return text;
}

std::string unknown_key_hint(const UnknownKey& unknown, std::span<const std::string> valid) {
    for (const ConfigKey& key : config_keys())
        // A key in the wrong table is the likeliest mistake and has one correction, so it is
        // checked first.
        if (key.key == unknown.key && key.section.find('<') == std::string::npos)
            return fmt::format("unknown key: it belongs into [{}]", key.section);
    if (auto hint = unit_hint(unknown, valid))
        return *hint;
    const std::string guess = did_you_mean(unknown.key, valid);
    if (!guess.empty())
        return "unknown key" + guess;
    return fmt::format("unknown key: must be one of {}", fmt::join(valid, ", "));
}

std::string did_you_mean(std::string_view name, std::span<const std::string> valid,
                         std::string_view quote) {
    const std::string nearest = core::nearest_name(name, valid);
    return nearest.empty() ? "" : fmt::format(" (did you mean {0}{1}{0}?)", quote, nearest);
}

const std::vector<std::string>& config_sections() {
    static const std::vector<std::string> sections{
        "study",  "stem",       "release",     "law",    "integrator", "vibration", "factors",
        "design", "replicates", "correlation", "reduce", "timestep",   "archive"};
    return sections;
}

std::vector<ConfigKey> config_keys() {
    Keys keys;
    for (const Keys& part :
         {study_keys(), parameter_keys("stem"), parameter_keys("release"), model_keys(),
          factor_keys(), design_keys(), output_keys(), timestep_keys()})
        keys.insert(keys.end(), part.begin(), part.end());
    return keys;
}

} // namespace culm::study
