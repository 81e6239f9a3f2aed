// SPDX-License-Identifier: BSD-3-Clause
// These recordings of the beam generator contain errors of persons or instruments, but no missing
// physics. A fit that takes inputs, noise, division of the chain or release as exact is found
// inadequate.
#include "beam_generator/recording.hpp"
#include "diagnose/adequacy.hpp"
#include "fit/chain/prediction.hpp"
#include "fit/fit_model.hpp"
#include "fit/noise/whitening.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include <Eigen/Cholesky>
#include <gtest/gtest.h>

namespace culm::tests {
namespace {

using diagnose::Finding;

beam::RecordingSpec plain_spec(double noise = 0.04e-3) {
    beam::RecordingSpec spec;
    spec.id = "plain";
    spec.heights = beam::even_heights(spec.stem.length, 8);
    spec.duration = 0.35;
    spec.errors.noise = noise;
    spec.seed = 20;
    return spec;
}

measure::Measurement recorded(const beam::RecordingSpec& spec, int spheres = 40) {
    measure::Measurement measurement = beam::record(spec);
    measurement.stem.spheres = spheres;
    return measurement;
}

Finding finding(const fit::Fit& fit, std::span<const fit::ObservedRecording> recordings) {
    EXPECT_FALSE(fit.failed()) << fit.reason;
    return fit.failed() ? Finding::Undecided : diagnose::verdict_on(fit, recordings).finding;
}

/// The verdicts on a fit that takes everything as exact and on one with reading errors.
std::pair<Finding, Finding> findings(const std::vector<measure::Measurement>& recordings) {
    fit::FitOptions options;
    options.with_inputs = false;
    const fit::Fit exact = fit::fit_model({}, {}, fit::observed(recordings), options);
    const fit::BaselineFit beside = fit::fit_baseline(recordings);
    return {finding(exact, fit::observed(recordings)), finding(beside.fit, beside.recordings)};
}

const std::pair inadequate_then_adequate{Finding::Inadequate, Finding::Adequate};

// 50 frames are too few to distinguish a correlation from missing physics.
TEST(ReadingErrors, AreCorrelatedAsAShortRecordStates) {
    beam::RecordingSpec spec = plain_spec();
    spec.duration = 0.05;
    spec.errors.correlation = 0.8;
    measure::Measurement recording = recorded(spec);
    const fit::BaselineFit silent = fit::fit_baseline({&recording, 1});
    EXPECT_EQ(finding(silent.fit, silent.recordings), Finding::Inadequate);
    recording.noise_correlation = 0.8;
    const fit::BaselineFit stated = fit::fit_baseline({&recording, 1});
    EXPECT_EQ(finding(stated.fit, stated.recordings), Finding::Adequate);
    EXPECT_NE(
        stated.recordings.front().noise_model->source.find("0.8 from frame to frame (stated)"),
        std::string::npos);
}

TEST(ReadingErrors, AccountForSlowNoise) {
    beam::RecordingSpec spec = plain_spec();
    spec.errors.correlation = 0.8;
    EXPECT_EQ(findings({recorded(spec)}), inadequate_then_adequate);
}

TEST(ReadingErrors, AccountForOutliers) {
    beam::RecordingSpec spec = plain_spec();
    spec.errors.outlier_share = 0.03;
    spec.errors.outlier_size = 0.5e-3;
    EXPECT_EQ(findings({recorded(spec)}), inadequate_then_adequate);
}

// Where the flexible fit has one parameter per reading, it follows an outlier. The median of two
// held frames cannot show which one is wrong.
TEST(ReadingErrors, AccountForOutliersNextToTheRelease) {
    beam::RecordingSpec spec = plain_spec();
    spec.frames_before = 2;
    spec.errors.outlier_share = 0.03;
    spec.errors.outlier_size = 0.5e-3;
    measure::Measurement measurement = recorded(spec);
    const std::size_t rows = measurement.heights.size();
    const auto released = std::ranges::find_if(measurement.times, [](double t) { return t >= 0; });
    const auto first = static_cast<std::size_t>(released - measurement.times.begin());
    measurement.deflections[first * rows + 5] += 0.7e-3;
    measurement.deflections[(first + 1) * rows + 2] -= 0.9e-3;
    measurement.deflections[3] += 1.1e-3;
    EXPECT_EQ(findings({measurement}), inadequate_then_adequate);
}

TEST(ReadingErrors, AccountForRoundedReadings) {
    beam::RecordingSpec spec = plain_spec();
    spec.errors.quantum = 0.1e-3; // 2.5 times the noise
    EXPECT_EQ(findings({recorded(spec)}), inadequate_then_adequate);
}

TEST(ReadingErrors, AccountForNoiseThatRowsHaveInCommon) {
    measure::Measurement measurement = recorded(plain_spec());
    std::mt19937 dice(4);
    std::normal_distribution<double> normal(0.0, 0.04e-3);
    for (std::size_t i = 0; i < measurement.times.size(); ++i) {
        const double together = normal(dice); // the picture shakes
        for (std::size_t j = 0; j < measurement.heights.size(); ++j)
            measurement.deflections[i * measurement.heights.size() + j] += together;
    }
    EXPECT_EQ(findings({measurement}), inadequate_then_adequate);
}

// A fast stem smears: its readings scatter by four times as much as those of a slow one.
TEST(ReadingErrors, AccountForUncertaintiesOfSingleReadings) {
    measure::Measurement measurement = recorded(plain_spec());
    std::mt19937 dice(7);
    std::normal_distribution<double> normal;
    const std::size_t rows = measurement.heights.size();
    std::vector<double> uncertainties;
    for (std::size_t at = 0; at < measurement.deflections.size(); ++at) {
        const double time = measurement.times[at / rows];
        const double more = time > 0.0 && time < 0.05 ? 0.15e-3 : 0.0;
        measurement.deflections[at] += more * normal(dice);
        uncertainties.push_back(std::hypot(0.04e-3, more));
    }
    const fit::BaselineFit by_height = fit::fit_baseline({&measurement, 1});
    measurement.reading_uncertainties = uncertainties;
    const fit::BaselineFit by_reading = fit::fit_baseline({&measurement, 1});
    EXPECT_EQ(finding(by_height.fit, by_height.recordings), Finding::Inadequate);
    EXPECT_EQ(finding(by_reading.fit, by_reading.recordings), Finding::Adequate);
}

// Uneven light shifts each row by its own function of the position in the picture.
TEST(ReadingErrors, AccountForErrorsOfTheRowsOfAPicture) {
    measure::Measurement measurement = recorded(plain_spec(0.01e-3));
    const std::size_t rows = measurement.heights.size();
    std::mt19937 dice(3);
    std::normal_distribution<double> normal(0.0, 0.02e-3);
    std::vector<std::array<double, 2>> curves;
    for (std::size_t j = 0; j < rows; ++j)
        curves.push_back({normal(dice), normal(dice)});
    for (std::size_t at = 0; at < measurement.deflections.size(); ++at) {
        const double place =
            measurement.deflections[at] / std::abs(measurement.deflections[at % rows]);
        measurement.deflections[at] +=
            curves[at % rows][0] * place + curves[at % rows][1] * place * place;
    }
    const fit::BaselineFit without = fit::fit_baseline({&measurement, 1});
    measurement.uncertainties.row = 0.02e-3;
    const fit::BaselineFit with = fit::fit_baseline({&measurement, 1});
    EXPECT_EQ(finding(without.fit, without.recordings), Finding::Inadequate);
    EXPECT_EQ(finding(with.fit, with.recordings), Finding::Adequate);
}

// A position that was read contains noise. With a polynomial of the reading, the noise of rows that
// hardly swing explained itself, by two standard uncertainties in every video.
TEST(ReadingErrors, DoNotExplainTheNoiseOfARow) {
    beam::RecordingSpec spec = plain_spec();
    spec.heights = {8e-3, 16e-3, 24e-3, 32e-3, 64e-3, 96e-3, 128e-3};
    measure::Measurement measurement = recorded(spec);
    measurement.uncertainties.row = 0.03e-3;
    const fit::BaselineFit baseline = fit::fit_baseline({&measurement, 1});
    double squares = 0.0;
    for (const fit::Pull& pull : baseline.fit.pulls)
        squares += pull.value * pull.value;
    EXPECT_LT(squares, 8.0) << "sum of squared pulls";
}

TEST(ReadingErrors, AccountForAStatedRollingShutter) {
    beam::RecordingSpec spec = plain_spec(0.01e-3);
    spec.effects = {{"rolling_shutter", {{"readout_s", -1e-3}}}};
    measure::Measurement measurement = recorded(spec);
    const fit::BaselineFit without = fit::fit_baseline({&measurement, 1});
    measurement.row_height = 0.4e-3;
    measurement.row_time = -1e-3 * *measurement.row_height / measurement.stem.length;
    const fit::BaselineFit with = fit::fit_baseline({&measurement, 1});
    EXPECT_EQ(finding(without.fit, without.recordings), Finding::Inadequate);
    EXPECT_EQ(finding(with.fit, with.recordings), Finding::Adequate);
}

TEST(ReadingErrors, AccountForRulerAndPicture) {
    measure::Measurement measurement = recorded(plain_spec(0.01e-3));
    measurement.stem.length -= 0.3e-3; // one standard uncertainty, by default
    for (double& height : measurement.heights)
        height = 1.005 * height + 0.3e-3; // one, and one and a half
    for (double& reading : measurement.deflections)
        reading *= 1.005;
    EXPECT_EQ(findings({measurement}), inadequate_then_adequate);
}

// Frequencies of two lengths that are each stated within 0.2 % cannot both follow one modulus.
TEST(ReadingErrors, AccountForTwoRulers) {
    beam::RecordingSpec spec = plain_spec();
    std::vector<measure::Measurement> two{recorded(spec)};
    spec.id = "shorter";
    spec.stem.length = 0.14;
    spec.heights = beam::even_heights(spec.stem.length, 8);
    two.push_back(recorded(spec));
    two[0].stem.length += 0.3e-3;
    two[1].stem.length -= 0.3e-3;
    EXPECT_EQ(findings(two), inadequate_then_adequate);
}

// The tip mass is a smaller share of a thicker stem, so the moduli of the separate fits differ by
// cycles at the end of the record. A start between them needs twice the runs or ends elsewhere.
TEST(ReadingErrors, AccountForCalipers) {
    beam::RecordingSpec spec = plain_spec();
    std::vector<measure::Measurement> two{recorded(spec)};
    const double mass = 0.6 * spec.stem.mass_per_length() * spec.stem.length;
    spec.id = "loaded";
    spec.duration *= 2.0;
    spec.effects = {{"tip_mass", {{"mass_kg", mass}}}};
    two.push_back(recorded(spec));
    two.back().stem.added_masses = {{spec.stem.length, mass, {}}};
    for (measure::Measurement& each : two) {
        each.specimen.assign(1, 'A');
        each.rig = each.specimen;
        std::get<measure::CircularSection>(each.stem.section).diameter *= 1.02;
    }
    const fit::BaselineFit baseline = fit::fit_baseline(two);
    EXPECT_EQ(finding(baseline.fit, baseline.recordings), Finding::Adequate);
    EXPECT_LT(baseline.fit.batches, 120);
}

TEST(ReadingErrors, AccountForACoarseChain) {
    EXPECT_EQ(findings({recorded(plain_spec(0.005e-3), 14)}), inadequate_then_adequate);
}

TEST(ReadingErrors, KeepTheParametersOfAStemFilmedInMotion) {
    const measure::Measurement whole = recorded(plain_spec());
    const fit::BaselineFit of_whole = fit::fit_baseline({&whole, 1});
    for (const double start : {0.004, 0.0071, 0.013, 0.03}) {
        measure::Measurement cut = whole;
        const auto first = static_cast<std::size_t>(std::ranges::lower_bound(cut.times, start) -
                                                    cut.times.begin());
        cut.release = measure::ReleaseKind::Moving;
        cut.times.erase(cut.times.begin(), cut.times.begin() + static_cast<std::ptrdiff_t>(first));
        cut.deflections.erase(cut.deflections.begin(),
                              cut.deflections.begin() +
                                  static_cast<std::ptrdiff_t>(first * cut.heights.size()));
        for (double& time : cut.times)
            time -= start;
        const fit::BaselineFit of_cut = fit::fit_baseline({&cut, 1});
        ASSERT_FALSE(of_cut.fit.failed()) << of_cut.fit.reason;
        EXPECT_EQ(finding(of_cut.fit, of_cut.recordings), Finding::Adequate) << start;
        for (const physics::ParameterId& id :
             {physics::bond_youngs_modulus, physics::bond_damping}) {
            const fit::FittedParameter& one = *of_whole.fit.parts.front().find(id);
            const fit::FittedParameter& other = *of_cut.fit.parts.front().find(id);
            EXPECT_NEAR(other.value, one.value, interval_half_width(other))
                << to_string(id) << " " << start;
        }
    }
}

// W C Wᵀ = 1 for the covariance C of such noise: checked with the columns of its Cholesky factor.
TEST(ReadingWeights, ApplyTheInverseRootOfTheCovariance) {
    constexpr std::size_t frames = 14;
    constexpr std::size_t rows = 2;
    fit::NoiseModel model;
    model.correlation = 0.8;
    model.common_share = 0.6;
    std::vector<bool> is_seen(frames * rows, true);
    constexpr std::size_t lost = 5; // a frame that was not seen
    is_seen[lost * rows] = is_seen[lost * rows + 1] = false;
    const auto count = static_cast<Eigen::Index>(frames * rows);
    Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(count, count);
    for (std::size_t a = 0; a < frames * rows; ++a)
        for (std::size_t b = 0; b < frames * rows; ++b) {
            const auto lag = static_cast<double>(a / rows) - static_cast<double>(b / rows);
            covariance(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(b)) =
                std::pow(model.correlation, std::abs(lag)) *
                (a % rows == b % rows ? 1.0 : model.common_share);
        }
    std::vector<Eigen::Index> seen;
    for (Eigen::Index k = 0; k < count; ++k)
        if (is_seen[static_cast<std::size_t>(k)])
            seen.push_back(k);
    const Eigen::MatrixXd of_seen = covariance(seen, seen);
    const Eigen::MatrixXd root = of_seen.llt().matrixL();
    Eigen::MatrixXd white = Eigen::MatrixXd::Zero(count, root.cols());
    white(seen, Eigen::all) = root;
    const fit::ReadingWeights weights(std::vector<double>(rows, 1.0),
                                      std::make_shared<const fit::NoiseModel>(model), is_seen);
    for (Eigen::Index k = 0; k < white.cols(); ++k)
        weights.apply({white.col(k).data(), frames * rows});
    const Eigen::MatrixXd rest = white(seen, Eigen::all);
    EXPECT_LT((rest * rest.transpose() - Eigen::MatrixXd::Identity(rest.rows(), rest.rows()))
                  .cwiseAbs()
                  .maxCoeff(),
              1e-10);
}

} // namespace
} // namespace culm::tests
