// SPDX-License-Identifier: BSD-3-Clause
#include "fit/coarse_image.hpp"

#include "beam_generator/recording.hpp"
#include "diagnose/score/stacked_readings.hpp"
#include "fit/fit_model.hpp"
#include "physics/effects/library.hpp"
#include "support/parameter_ids.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace {

using namespace culm;
using Recordings = std::vector<fit::ObservedRecording>;

/// Of the beam generator, whose model is not the chain: a stem in a clamp that yields.
Recordings stem_in_a_soft_clamp(int spheres) {
    beam::RecordingSpec spec;
    spec.id = "soft";
    spec.tip_deflection = 20e-3;
    spec.effects = {{"clamp_compliance", {{"stiffness_nm_rad", 0.7}}}};
    spec.heights = beam::even_heights(spec.stem.length, 6);
    spec.duration = 0.2;
    spec.errors.noise = 0.05e-3;
    spec.seed = 3;
    Recordings recordings{fit::ObservedRecording(beam::record(spec))};
    recordings.front().stem.spheres = spheres;
    return recordings;
}

fit::SelectedEffects clamp_compliance() {
    const physics::EffectPointer effect = physics::effect_named("clamp_compliance");
    return {{effect, std::vector<std::optional<double>>(effect->parameters().size())}};
}

double value(const std::vector<fit::FittedParameter>& parameters, const std::string& name) {
    const auto found = std::ranges::find(parameters, tests::id(name), &fit::FittedParameter::id);
    return found == parameters.end() ? std::nan("") : found->value;
}

TEST(CoarseImage, LeavesWhatTheFitLeavesAndChangesAsItDoes) {
    const Recordings recordings = stem_in_a_soft_clamp(56);
    const fit::Fit fine = fit::fit_model({}, {}, recordings);
    const fit::CoarseImage image(fine, recordings, {});
    ASSERT_TRUE(image.is_coarser());
    EXPECT_LT(2 * image.fit().parts.front().model.spec.stem.sphere_count, 56);

    const auto of_fine = diagnose::stacked_readings(fine, recordings);
    const auto of_image = diagnose::stacked_readings(image.fit(), image.recordings());
    // Rounding only: that is what the shift is for.
    EXPECT_LT((of_image.residual - of_fine.residual).norm(), 1e-9 * of_fine.residual.norm());
    ASSERT_EQ(of_image.ids, of_fine.ids);
    for (std::size_t k = 0; k < of_fine.ids.size(); ++k) {
        const auto column = static_cast<Eigen::Index>(k);
        const physics::ParameterId& column_id = of_fine.ids[k];
        const double to_coarse =
            column_id == physics::bond_damping || column_id == physics::bond_youngs_modulus
                ? value(image.fit().parameters, to_string(column_id)) /
                      value(fine.parameters, to_string(column_id))
                : 1.0;
        const Eigen::VectorXd derivative = to_coarse * of_image.jacobian.col(column);
        // The square of the bond length over the wave length of the second mode, 0.3 L/2π.
        EXPECT_LT((derivative - of_fine.jacobian.col(column)).norm(),
                  0.03 * of_fine.jacobian.col(column).norm())
            << to_string(column_id);
    }
}

TEST(CoarseImage, OfAFitOfSeveralRecordingsKeepsOneMaterial) {
    Recordings recordings = stem_in_a_soft_clamp(56);
    recordings.push_back(recordings.front());
    recordings.back().stem.id = "other";
    recordings.back().stem.spheres = 40;
    const fit::Fit fine = fit::fit_model({}, {}, recordings);
    ASSERT_FALSE(fine.failed()) << fine.reason;
    const fit::CoarseImage image(fine, recordings, {});
    ASSERT_TRUE(image.is_coarser());
    for (std::size_t m = 0; m < recordings.size(); ++m) {
        const run::CaseSpec& coarse = image.fit().parts[m].model.spec;
        const run::CaseSpec& own = fine.parts[m].model.spec;
        // The square of a bond length over the stem's, 1/15.
        EXPECT_NEAR(coarse.stem.bond_youngs_modulus / own.stem.bond_youngs_modulus, 1.0, 0.01);
        EXPECT_NEAR(fit::damping_time(coarse) / fit::damping_time(own), 1.0, 0.03);
    }
    // Chains of equally many spheres have the same β, the first one's counted here.
    EXPECT_NEAR(image.fit().parts[0].model.spec.stem.bond_damping /
                    image.fit().parts[1].model.spec.stem.bond_damping,
                1.0, 1e-9);
    EXPECT_EQ(value(image.fit().parameters, "bond_damping"),
              image.fit().parts.front().find(tests::id("bond_damping"))->value);
}

TEST(CoarseImage, LeadsToWhereTheFineChainEnds) {
    const Recordings recordings = stem_in_a_soft_clamp(56);
    const fit::Fit smaller = fit::fit_model({}, {}, recordings);
    const fit::Fit fine = fit::fit_model(clamp_compliance(), smaller, recordings);
    const fit::CoarseImage image(smaller, recordings, {});
    const fit::Fit found = image.as_fine(fit::numbers_of(
        fit::fit_model(clamp_compliance(), image.fit(), image.recordings(), image.options({}))));
    ASSERT_TRUE(fine.is_fitted() && found.is_fitted()) << fine.reason << found.reason;
    // The clamp takes most of the misfit; what is left of the coarse chain's error is of second
    // order in what it changes.
    EXPECT_GT(smaller.chi_squared, 5.0 * fine.chi_squared);
    EXPECT_NEAR(found.chi_squared, fine.chi_squared,
                0.02 * (smaller.chi_squared - fine.chi_squared));
    for (const fit::FittedParameter& parameter : fine.parameters)
        EXPECT_NEAR(value(found.parameters, to_string(parameter.id)), parameter.value,
                    std::max(0.03 * std::abs(parameter.value), 3.0 * parameter.standard_error))
            << to_string(parameter.id);

    const fit::Fit refined = fit::refined(fit::models_of(found, recordings), clamp_compliance(),
                                          smaller, recordings, {});
    ASSERT_FALSE(refined.failed()) << refined.reason;
    // Solutions end where an iteration gains less than 0.005 of what one standard error makes.
    EXPECT_NEAR(refined.chi_squared, fine.chi_squared, 0.2);
    EXPECT_LT(refined.runs, fine.runs);
}

TEST(CoarseImage, OfAChainThatIsNoFinerIsTheFitItself) {
    const Recordings recordings = stem_in_a_soft_clamp(20);
    const fit::Fit fit = fit::fit_model({}, {}, recordings);
    const fit::CoarseImage image(fit, recordings, {});
    EXPECT_FALSE(image.is_coarser());
    EXPECT_EQ(&image.fit(), &fit);
    EXPECT_EQ(image.recordings().data(), recordings.data());
    EXPECT_EQ(image.options({}).chain.spheres, std::nullopt);
}

} // namespace
