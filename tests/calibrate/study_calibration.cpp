// SPDX-License-Identifier: BSD-3-Clause
#include "calibrate/study_calibration.hpp"

#include "support/simulated_measurement.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace {

using namespace culm;

/// A study of the stem of empty_measurement() whose points obey √Y = 570 b2 and β = −270 b1, with a
/// scatter of 0.1 %.
calibrate::StudyForCalibration exact_study() {
    std::vector<double> moduli;
    std::vector<double> dampings;
    std::vector<double> decays;
    std::vector<double> frequencies;
    for (const double modulus : {0.5e9, 1e9, 2e9, 4e9})
        for (const double damping : {5.0, 20.0, 40.0, 80.0}) {
            const double scatter = moduli.size() % 2 == 0 ? 1.001 : 0.999;
            moduli.push_back(modulus);
            dampings.push_back(damping);
            frequencies.push_back(scatter * std::sqrt(modulus) / 570.0);
            decays.push_back(-damping / 270.0 / scatter);
        }
    calibrate::StudyForCalibration study;
    study.name = "study";
    study.base = fit::chain_of(tests::empty_measurement()).spec;
    study.base.duration = 0.1;
    study.regression = reduce::regress_study({moduli, dampings, decays, frequencies});
    study.bond_youngs_modulus = {0.5e9, 4e9};
    study.bond_damping = {5.0, 80.0};
    return study;
}

TEST(StudyCalibration, PutsTheReadingIntoTheRegressions) {
    const auto found = calibrate::calibrate_by_study(tests::simulated_measurement(), exact_study());
    EXPECT_EQ(found.height, 0.15); // the highest row
    EXPECT_EQ(found.window, 0.1);  // the study's
    ASSERT_TRUE(found.prediction.bond_youngs_modulus.by_single_law);
    ASSERT_TRUE(found.prediction.bond_damping.by_single_law);
    const double wanted = std::pow(570.0 * found.reading.frequency.value, 2);
    // The scatter of the study.
    EXPECT_NEAR(found.prediction.bond_youngs_modulus.by_single_law->value, wanted, 5e-3 * wanted);
    EXPECT_NEAR(found.prediction.bond_damping.by_single_law->value,
                -270.0 * found.reading.decay_per_cycle.value, 0.3);
    EXPECT_TRUE(found.warnings.empty()) << found.warnings.front();
}

TEST(StudyCalibration, HasErrorsThatGrowWithTheNoiseOfTheRecord) {
    // The release is at t = 0: one between frames would be the larger error of Eq. 1.
    tests::TrueValues values;
    values.release_time = 0.0;
    const auto quiet =
        calibrate::calibrate_by_study(tests::simulated_measurement(values), exact_study());
    measure::Measurement noisy = tests::empty_measurement();
    noisy.noise = 2e-3;
    noisy = tests::read_with_noise(noisy, tests::true_model(noisy, values), 1);
    const auto loud = calibrate::calibrate_by_study(noisy, exact_study());
    EXPECT_GT(loud.prediction.bond_damping.by_single_law->standard_error,
              1.5 * quiet.prediction.bond_damping.by_single_law->standard_error);
}

TEST(StudyCalibration, WarnsThatItExtrapolates) {
    tests::TrueValues stiff;
    stiff.bond_youngs_modulus = 9e9;
    const auto found =
        calibrate::calibrate_by_study(tests::simulated_measurement(stiff), exact_study());
    ASSERT_FALSE(found.warnings.empty());
    EXPECT_NE(found.warnings.front().find("b2 ="), std::string::npos) << found.warnings.front();
    EXPECT_NE(found.warnings.front().find("EXTRAPOLATED"), std::string::npos);
    EXPECT_FALSE(found.prediction.is_inside_design);
}

TEST(StudyCalibration, WarnsThatTheStudyIsAboutAnotherStem) {
    calibrate::StudyForCalibration study = exact_study();
    study.base.stem.bond_length *= 1.1;
    const auto found = calibrate::calibrate_by_study(tests::simulated_measurement(), study);
    ASSERT_FALSE(found.warnings.empty());
    EXPECT_NE(found.warnings.back().find("ANOTHER STEM: length 155.7 mm against 171.2"),
              std::string::npos)
        << found.warnings.back();
}

} // namespace
