// SPDX-License-Identifier: BSD-3-Clause
// The numbers of an answer: effects with their probability and size, stems, and their population.
#pragma once

#include "diagnose/search/posterior.hpp"
#include "reduce/population_statistics.hpp"

#include <limits>
#include <string>
#include <vector>

namespace culm::diagnose {

/// A number that all stems on a rig share.
struct SharedValue {
    std::string name; ///< of the effect's parameter
    std::string unit;
    double value = 0.0;
    double lower = 0.0; ///< 95 % interval
    double upper = 0.0;
};

template <class To>
void describe(To& to, const SharedValue& value) {
    to("name", value.name);
    to("unit", value.unit);
    to("value", value.value);
    to("interval_95", [&] { return reduce::Bounds{value.lower, value.upper}; });
}

/// An effect that may act.
struct EffectAnswer {
    std::string effect;
    std::string rig; ///< empty: of stems
    std::string family;
    bool is_known = false;
    double probability = 0.0;        ///< of this effect
    double family_probability = 0.0; ///< of one of the laws of its family
    std::vector<SharedValue> values; ///< of a rig; empty: the answer does not contain the effect
    std::vector<std::string> stems;  ///< of an own effect: those that have it with 95 %
    std::vector<std::string> possible_stems; ///< those in which it is more probable than not
    /// About how many stems like these make it certain; 0: it is, or more stems do not help.
    double stems_needed = 0.0;
    /// The likeliest model with the effect against the likeliest without it, and the part that each
    /// further stem like these adds; NaN: only one of the two was fitted.
    double log_odds = std::numeric_limits<double>::quiet_NaN();
    double log_odds_per_stem = std::numeric_limits<double>::quiet_NaN();
};

/// Numbers of a stem with every input as stated.
struct StemNumbers {
    double youngs_modulus = 0.0;       ///< of the bonds, Pa
    double youngs_modulus_error = 0.0; ///< standard error, with the inputs and the shared numbers
    double damping = 0.0;              ///< β
    double damping_error = 0.0;
    double youngs_modulus_error_by_shared = 0.0; ///< part that the shared numbers contribute
    double damping_error_by_shared = 0.0;
    double rmse = 0.0;       ///< m
    double over_noise = 0.0; ///< root of the reduced χ²
};

template <class To>
void describe(To& to, const StemNumbers& numbers) {
    to("bond_youngs_modulus_pa", numbers.youngs_modulus);
    to("bond_youngs_modulus_standard_error_pa", numbers.youngs_modulus_error);
    to("bond_damping", numbers.damping);
    to("bond_damping_standard_error", numbers.damping_error);
    to("rms_mm", numbers.rmse);
}

struct StemAnswer {
    std::string name;
    std::string rig;
    std::string failure; ///< why it was left out; empty if it was not
    StemNumbers before;  ///< of the published chain
    StemNumbers after;   ///< with the effects
    Finding finding = Finding::Undecided;
    std::string tests;                            ///< for lack of fit that fail
    std::vector<fit::FittedParameter> own_values; ///< of the effects of this stem alone
    std::vector<std::string> own;                 ///< names of these effects
    double youngs_modulus_distance = 0.0; ///< from the median, in robust standard deviations
    double damping_distance = 0.0;
};

/// Y and β over the stems.
struct Population {
    reduce::SampleSummary bond_youngs_modulus; ///< Pa
    reduce::SampleSummary bond_damping;
    double correlation = 0.0; ///< Pearson's, of Y and β
};

template <class To>
void describe(To& to, const Population& population) {
    to("bond_youngs_modulus_pa", population.bond_youngs_modulus);
    to("bond_damping", population.bond_damping);
    to("correlation", population.correlation);
}

/// A stem is an outlier if Y or β is more than this from the median.
inline constexpr double outlier_distance = 3.5;

/// The effects of the model number `answer` of the search, the known ones first, then those that
/// are possible.
[[nodiscard]] std::vector<EffectAnswer>
effect_answers(const SearchResult& search, const Posterior& posterior, std::size_t answer);

/// The stems in the published chain and in that model.
[[nodiscard]] std::vector<StemAnswer> stem_answers(const SearchResult& search, std::size_t answer);

[[nodiscard]] Population population_of(const std::vector<StemAnswer>& stems,
                                       StemNumbers StemAnswer::*numbers);

} // namespace culm::diagnose
