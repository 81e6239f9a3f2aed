// SPDX-License-Identifier: BSD-3-Clause
// The catalogue itself: one row for every key.
#include "physics/bond_law_options.hpp"
#include "study/config_factor_catalogue.hpp"
#include "study/config_keys.hpp"
#include "study/parameter_table.hpp"

namespace culm::study {

namespace {

constexpr double largest_whole = 9007199254740992.0; // 2⁵³: whole numbers up to it are exact

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
         "kind",
         ValueKind::Word,
         "",
         "\"vibration\"",
         {},
         {"vibration", "timestep"},
         "what is computed at each point: the free vibration, or how large explicit steps may be "
         "(docs/timestep.md)"},
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
         "effects",
         ValueKind::WordList,
         "",
         "[]",
         {},
         {},
         "what is added to the published chain, as on the command line: names, with values in "
         "parentheses if they are not the defaults, or files (docs/effects.md); "
         "`\"effect.parameter\"` may be a factor"},
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
         "2e-06",
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

Keys output_keys() {
    return {
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

Keys timestep_keys() {
    return {
        {"timestep",
         "limit_tolerance",
         ValueKind::Number,
         "",
         "0.01",
         {1e-5, 0.5},
         {},
         "the largest stable step is bisected until it is known this closely"},
        {"timestep",
         "trial_steps",
         ValueKind::WholeNumber,
         "",
         "20000, or 20/limit_tolerance if that is more",
         {100.0, 1e9},
         {},
         "steps of every run of the bisection; at least 20/limit_tolerance, or a weak instability "
         "would not show"},
        {"timestep",
         "fractions",
         ValueKind::NumberList,
         "",
         "none: the limits alone",
         {0.0, 1.0, true, true},
         {},
         "steps whose b1 and b2 are compared, as shares of the linearised chain's limit"},
        {"timestep",
         "record_cycles",
         ValueKind::Number,
         "",
         "2",
         {1.0, 1000.0},
         {},
         "length of the compared histories, in periods of the undamped stem"},
        {"timestep",
         "samples_per_cycle",
         ValueKind::WholeNumber,
         "",
         "40",
         {8.0, 1000.0},
         {},
         "of the compared histories"},
        {"timestep",
         "reference_tolerance",
         ValueKind::Number,
         "",
         "1e-09",
         {1e-12, 1e-2},
         {},
         "of the implicit run whose b1 and b2 are put beside the explicit ones"},
    };
}

} // namespace

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
