// SPDX-License-Identifier: BSD-3-Clause
// The diagnosis of a laboratory: the effects of its rig, the own effects of its stems, and the
// distributions of Y and β.
#pragma once

#include "diagnose/adequacy.hpp"
#include "diagnose/diagnosis.hpp"
#include "diagnose/laboratory/laboratory_search.hpp"

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

/// An effect of a rig.
struct RigAnswer {
    std::string effect;
    std::string rig;
    bool is_known = false;
    double probability = 0.0;        ///< of this effect
    double family_probability = 0.0; ///< of one of the laws of its family
    std::string family;
    std::vector<SharedValue> values; ///< empty: the best model does not contain it
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
    double rmse = 0.0; ///< m
};

struct StemAnswer {
    std::string name;
    std::string rig;
    std::string failure;            ///< why it was left out; empty if it was not
    StemNumbers before;             ///< of the published chain
    StemNumbers after;              ///< with the effects
    double over_noise_before = 0.0; ///< root of the reduced χ²
    double over_noise = 0.0;
    Finding finding = Finding::Undecided;
    std::string tests;                            ///< for lack of fit that fail
    std::vector<fit::FittedParameter> own_values; ///< of its own effects
    std::vector<std::string> own;                 ///< names of its own effects
    double youngs_modulus_distance = 0.0; ///< from the median, in robust standard deviations
    double damping_distance = 0.0;
};

template <class Wire>
void fields(Wire& wire, StemNumbers& numbers) {
    wire(numbers.youngs_modulus, numbers.youngs_modulus_error, numbers.damping,
         numbers.damping_error, numbers.youngs_modulus_error_by_shared,
         numbers.damping_error_by_shared, numbers.rmse);
}
template <class Wire>
void fields(Wire& wire, StemAnswer& stem) {
    wire(stem.name, stem.rig, stem.failure, stem.before, stem.after, stem.over_noise_before,
         stem.over_noise, stem.finding, stem.tests, stem.own_values, stem.own,
         stem.youngs_modulus_distance, stem.damping_distance);
}

/// Y and β over the stems.
struct Population {
    double mean_modulus = 0.0;    ///< Pa
    double modulus_scatter = 0.0; ///< standard deviation, Pa
    double mean_damping = 0.0;
    double damping_scatter = 0.0;
    double correlation = 0.0; ///< Pearson's, of Y and β
};

/// Detection limit of an effect that the best model does not contain.
struct SharedLimit {
    std::string effect;
    std::string rig;
    std::string parameter;
    std::string unit;
    double of_one = std::numeric_limits<double>::infinity(); ///< of the median stem, 3 deviations
    double of_all = std::numeric_limits<double>::infinity(); ///< of all stems together
};

/// An effect that some stems have.
struct OwnAnswer {
    std::string effect;
    double probability = 0.0; ///< that stems have it
    std::vector<std::string> stems;
};

struct Laboratory {
    Conclusion conclusion = Conclusion::Unknown;
    std::string reason;             ///< one sentence
    std::vector<RigAnswer> effects; ///< of rigs: those of the best model, then possible ones
    std::vector<OwnAnswer> own;
    std::vector<StemAnswer> stems;
    Population before;
    Population after;
    std::vector<SharedLimit> limits;
    std::vector<std::string> models;  ///< visited, the likeliest first
    std::vector<double> log_evidence; ///< (models) over that of the published chain
    double largest_unvisited =
        -std::numeric_limits<double>::infinity(); ///< log evidence over the best
};

/// search_laboratory(), the verdict and the numbers of all stems. A stem is an outlier if Y or β is
/// more than outlier_distance from the median.
inline constexpr double outlier_distance = 3.5;
[[nodiscard]] Laboratory diagnose_laboratory(std::span<const Specimen> specimens,
                                             const DiagnosisOptions& options);

} // namespace culm::diagnose
