// SPDX-License-Identifier: BSD-3-Clause
// The catalogue itself: one row for every key.
#include "physics/bond_law_options.hpp"
#include "study/config_keys.hpp"
#include "study/parameter_table.hpp"

#include <limits>

namespace culm::study {

namespace {

constexpr double largest_whole = 9007199254740992.0; // 2⁵³: whole numbers up to it are exact
constexpr Interval any_number{-std::numeric_limits<double>::max(),
                              std::numeric_limits<double>::max()};

using Keys = std::vector<ConfigKey>;

Keys study_keys() {
    return {
        {"study",
         "name",
         ValueKind::Text,
         "",
         "the file's name",
         {},
         {},
         "how the study is called in reports"},
        {"study",
         "store",
         ValueKind::Word,
         "",
         "\"tip\"",
         {},
         {"fit", "tip", "heights", "full"},
         "what of every trajectory is kept; each word includes the ones before it"},
        {"study",
         "heights_mm",
         ValueKind::NumberList,
         "mm",
         "",
         {0.0, 100000.0},
         {},
         "heights above the clamp at which the deflection is stored; needed by `heights`, "
         "possible with `full`"},
        {"study",
         "seed",
         ValueKind::WholeNumber,
         "",
         "1",
         {0.0, largest_whole},
         {},
         "selects the random numbers of the study"},
    };
}

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
    return {
        {"law",
         "name",
         ValueKind::Word,
         "",
         "\"schramm2019\"",
         {},
         physics::law_names(),
         "bond law: as in the authors' code, or conserving angular momentum"},
        {"law",
         "damping_factor",
         ValueKind::NumberOrWord,
         "",
         "2",
         {0.0, 10.0, true, false},
         {"sqrt2"},
         "factor before β: 2 in the paper, √2 in Guo et al. (2013)"},
        {"law",
         "damping_inertia",
         ValueKind::Word,
         "",
         "\"reduced\"",
         {},
         {"reduced", "individual"},
         "inertia under the roots of the damping coefficients"},
        {"integrator",
         "method",
         ValueKind::Word,
         "",
         "\"implicit\"",
         {},
         {"implicit", "explicit"},
         "time integration"},
        {"integrator",
         "timestep_s",
         ValueKind::Number,
         "s",
         "",
         {0.0, 1.0, true, false},
         {},
         "step of the explicit method, which needs it; must divide sample_interval_s"},
        {"integrator",
         "relative_tolerance",
         ValueKind::Number,
         "",
         "1e-06",
         {1e-12, 1e-2},
         {},
         "of the implicit method"},
        {"integrator",
         "dimensions",
         ValueKind::WholeNumber,
         "",
         "2",
         {2.0, 3.0},
         {},
         "2: motion in the plane of the pull; 3: in space"},
        {"vibration",
         "duration_s",
         ValueKind::Number,
         "s",
         "0.1",
         {0.0, 10000.0, true, false},
         {},
         "of the free vibration; a multiple of sample_interval_s"},
        {"vibration",
         "sample_interval_s",
         ValueKind::Number,
         "s",
         "5e-05",
         {0.0, 10000.0, true, false},
         {},
         "time between stored samples"},
    };
}

Keys factor_keys() {
    const std::string section = "factors.<parameter>";
    const std::string unit = "as the parameter";
    return {
        {section, "from", ValueKind::Number, unit, "", any_number, {}, "first value of a range"},
        {section, "to", ValueKind::Number, unit, "", any_number, {}, "last value of a range"},
        {section,
         "step",
         ValueKind::Number,
         unit,
         "",
         {0.0, any_number.high, true, false},
         {},
         "distance of the levels of a range; must divide to − from"},
        {section,
         "count",
         ValueKind::WholeNumber,
         "",
         "",
         {2.0, 1e6},
         {},
         "number of levels of a range, both ends included; instead of step"},
        {section,
         "spacing",
         ValueKind::Word,
         "",
         "\"linear\"",
         {},
         {"linear", "log"},
         "are the levels equidistant, or their logarithms?"},
        {section,
         "distribution",
         ValueKind::Word,
         "",
         "",
         {},
         {"normal", "lognormal", "uniform"},
         "the factor is drawn from a distribution"},
        {section,
         "mean",
         ValueKind::Number,
         unit,
         "",
         any_number,
         {},
         "of the normal, or of the lognormal quantity itself, before truncation"},
        {section,
         "sd",
         ValueKind::Number,
         unit,
         "",
         {0.0, any_number.high, true, false},
         {},
         "standard deviation of the same"},
        {section,
         "min",
         ValueKind::Number,
         unit,
         "the parameter's range",
         any_number,
         {},
         "lower truncation; needed by `uniform`"},
        {section,
         "max",
         ValueKind::Number,
         unit,
         "the parameter's range",
         any_number,
         {},
         "upper truncation; needed by `uniform`"},
    };
}

Keys output_keys() {
    return {
        {"design",
         "type",
         ValueKind::Word,
         "",
         "\"factorial\"",
         {},
         {"factorial", "latin_hypercube", "sobol", "list"},
         "how factors are combined to points"},
        {"design",
         "points",
         ValueKind::WholeNumber,
         "",
         "",
         {1.0, 1e8},
         {},
         "number of design points; for `latin_hypercube` and `sobol`, which need it"},
        {"design",
         "replicates",
         ValueKind::WholeNumber,
         "",
         "1",
         {1.0, 1e8},
         {},
         "repetitions of every design point with new draws of the distributions"},
        {"design",
         "point",
         ValueKind::Tables,
         "",
         "",
         {},
         {},
         "the points of a `list`, which needs them: every table gives one point's values"},
        {"reduce",
         "window_s",
         ValueKind::Number,
         "s",
         "the whole record",
         {0.0, 10000.0, true, false},
         {},
         "time from the release to which Eq. 1 is fitted"},
        {"reduce",
         "amplitude",
         ValueKind::Word,
         "",
         "\"free\"",
         {},
         {"free", "fixed"},
         "is b0 fitted, or fixed at the deflection of the release?"},
        {"reduce",
         "significance",
         ValueKind::Number,
         "",
         "0.05",
         {0.0, 1.0, true, true},
         {},
         "a term of the regressions stays if its F-test has p below this"},
        {"archive",
         "trajectory_compression",
         ValueKind::WholeNumber,
         "",
         "0",
         {0.0, 9.0},
         {},
         "deflate level of the stored positions; 0: none"},
    };
}

} // namespace

const std::vector<std::string>& config_sections() {
    static const std::vector<std::string> sections{"study",      "stem",      "release", "law",
                                                   "integrator", "vibration", "factors", "design",
                                                   "reduce",     "archive"};
    return sections;
}

std::vector<ConfigKey> config_keys() {
    Keys keys;
    for (const Keys& part : {study_keys(), parameter_keys("stem"), parameter_keys("release"),
                             model_keys(), factor_keys(), output_keys()})
        keys.insert(keys.end(), part.begin(), part.end());
    return keys;
}

} // namespace culm::study
