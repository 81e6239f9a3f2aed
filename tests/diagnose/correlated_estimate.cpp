// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/correlated_estimate.hpp"

#include "beam_generator/recording.hpp"
#include "fit/model/stem_model.hpp"
#include "physics/effects/library.hpp"
#include "support/parameter_ids.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace culm::tests {
namespace {

using diagnose::ReadingSequence;
using diagnose::StackedReadings;

/// Two rows of 400 frames, read as a·cos + b, with noise of one row's correlation in both: the same
/// in each row if they miss together.
struct LinearRecord {
    StackedReadings stacked;
    std::vector<ReadingSequence> sequences;
};

constexpr int frames = 400;

LinearRecord linear_record(double correlation, bool rows_are_alike, std::mt19937_64& engine) {
    std::normal_distribution<double> normal;
    LinearRecord record;
    record.stacked.ids = {id("amplitude"), id("zero")};
    record.stacked.jacobian.resize(2 * frames, 2);
    record.stacked.residual.resize(2 * frames);
    record.sequences.resize(2);
    const double fresh = std::sqrt(1.0 - correlation * correlation);
    std::array<double, 2> noise{normal(engine), normal(engine)};
    for (int i = 0; i < frames; ++i)
        for (int j = 0; j < 2; ++j) {
            const Eigen::Index place = 2 * i + j;
            double& own = noise[static_cast<std::size_t>(j)];
            own = j == 1 && rows_are_alike ? noise[0] : correlation * own + fresh * normal(engine);
            record.stacked.jacobian.row(place) << std::cos(0.05 * i), 1.0;
            record.stacked.residual(place) = own;
            record.sequences[static_cast<std::size_t>(j)].readings.push_back(place);
        }
    return record;
}

struct Scatter {
    double amplitude = 0.0; ///< root mean square error over the stated one
    double zero = 0.0;
};

/// Of generalised least squares, whose true values are 0, over many records.
Scatter scatter(double correlation, bool rows_are_alike) {
    constexpr int records = 400;
    std::mt19937_64 engine(7);
    Scatter out;
    for (int k = 0; k < records; ++k) {
        const LinearRecord record = linear_record(correlation, rows_are_alike, engine);
        const auto noise = diagnose::correlated_noise(record.stacked.residual, record.sequences);
        const auto white = diagnose::whitened(record.stacked, record.sequences, noise);
        const std::vector<bool> free(2);
        const Eigen::VectorXd change = diagnose::solve_linear(white.stacked, free).change;
        auto left = white;
        left.stacked.residual -= left.stacked.jacobian * change;
        const Eigen::MatrixXd covariance = diagnose::covariance_by_frames(left, free);
        out.amplitude += change(0) * change(0) / covariance(0, 0) / records;
        out.zero += change(1) * change(1) / covariance(1, 1) / records;
    }
    return {std::sqrt(out.amplitude), std::sqrt(out.zero)};
}

// 400 records tell a scatter to 3.5 % (1/√(2·400)). A correlation that is estimated from 400 frames
// comes out too small by (1 + 3ρ)/400 (Kendall 1954), 1 % of it and a fifth of 1 − ρ at 0.95: the
// zero's error is then 10 % more than stated.
TEST(CorrelatedNoise, StatesTheErrorsThatWhiteNoiseMakes) {
    const Scatter found = scatter(0.0, false);
    EXPECT_NEAR(found.amplitude, 1.0, 0.11);
    EXPECT_NEAR(found.zero, 1.0, 0.11);
}

TEST(CorrelatedNoise, StatesTheErrorsThatSlowNoiseMakes) {
    const Scatter found = scatter(0.95, false);
    EXPECT_NEAR(found.amplitude, 1.0, 0.15);
    EXPECT_NEAR(found.zero, 1.1, 0.2);
}

// Counted as independent, two rows that miss together would promise errors smaller by √2.
TEST(CorrelatedNoise, KnowsThatTheRowsOfAFrameMissTogether) {
    const Scatter found = scatter(0.9, true);
    EXPECT_NEAR(found.amplitude, 1.0, 0.15);
    EXPECT_NEAR(found.zero, 1.1, 0.2);
}

TEST(CorrelatedNoise, BridgesNoGap) {
    std::mt19937_64 engine(3);
    LinearRecord record = linear_record(0.9, false, engine);
    for (ReadingSequence& sequence : record.sequences)
        for (std::size_t i = 100; i < 110; ++i)
            sequence.readings[i] = -1;
    const auto noise = diagnose::correlated_noise(record.stacked.residual, record.sequences);
    const auto white = diagnose::whitened(record.stacked, record.sequences, noise);
    EXPECT_EQ(white.stacked.residual.size(), 2 * (frames - 10));
    // The first reading after the gap is taken for itself.
    const auto after = std::ranges::find(white.frames, 110u);
    const auto place = after - white.frames.begin();
    EXPECT_NEAR(white.stacked.residual(place),
                record.stacked.residual(2 * 110) *
                    std::sqrt(1.0 - std::pow(noise.correlation[0], 2)) / noise.deviation[0],
                1e-12);
}

beam::RecordingSpec beam_recording() {
    beam::RecordingSpec spec;
    spec.heights = beam::even_heights(spec.stem.length, 5);
    spec.duration = 0.3;
    spec.errors.noise = 0.05e-3;
    return spec;
}

fit::Fit fitted(const std::vector<measure::Measurement>& recordings) {
    return fit::fit_model({}, {}, recordings);
}

const fit::FittedParameter& modulus(const std::vector<fit::FittedParameter>& all) {
    return *std::ranges::find(all, id("bond_youngs_modulus"), &fit::FittedParameter::id);
}

TEST(CorrelatedEstimate, SaysNothingWhereTheMissesAreIndependent) {
    const std::vector<measure::Measurement> recordings{beam::record(beam_recording())};
    EXPECT_FALSE(diagnose::correlated_estimate(fitted(recordings), recordings).has_value());
}

/// A soft stem that is held level and let go, as the chain moves, with a clamp line that creeps by
/// an eighth of the sag while it is filmed.
std::vector<measure::Measurement> creeping_recording(double youngs_modulus) {
    beam::RecordingSpec spec = beam_recording();
    spec.frames_per_second = 200.0;
    spec.duration = 3.0;
    spec.gravity_direction = measure::GravityDirection::Transverse;
    measure::Measurement recording = beam::record(spec);
    recording.release = measure::ReleaseKind::HeldStraight;
    fit::StemChain chain = fit::chain_of(recording, {});
    chain.spec.stem.bond_youngs_modulus = youngs_modulus;
    chain.spec.stem.bond_damping = 200.0;
    chain.spec.sample_interval = 1e-3;
    const fit::StemModel model = fit::candidate_model(
        {chain.spec, {}, 0.0, 0.0, {}}, physics::parse_effects("gravity", {}), recording);
    const auto seen = fit::predict_readings(model, recording.times, {});
    std::mt19937_64 engine(11);
    std::normal_distribution<double> noise(0.0, 0.02e-3);
    const std::size_t rows = recording.heights.size();
    const double sag = seen.readings.back();
    for (std::size_t i = 0; i < recording.times.size(); ++i)
        for (std::size_t j = 0; j < rows; ++j) {
            const double time = std::max(recording.times[i], 0.0);
            recording.deflections[i * rows + j] = seen.readings[i * rows + j] + noise(engine) +
                                                  0.125 * sag * (1.0 - std::exp(-time / 0.5)) *
                                                      recording.heights[j] /
                                                      recording.heights.back();
        }
    recording.noise = 0.02e-3;
    return {recording};
}

// The frequency tells Y, the sag tells another: least squares lies between them and does not know.
TEST(CorrelatedEstimate, LetsASwingTellWhatACreepingZeroHides) {
    const double truth = 30e6;
    const auto recordings = creeping_recording(truth);
    const fit::Fit fit =
        fit::fit_model(physics::parse_effects("gravity", {}), fitted(recordings), recordings);
    ASSERT_FALSE(fit.failed()) << fit.reason;
    const auto estimate = diagnose::correlated_estimate(fit, recordings);
    ASSERT_TRUE(estimate.has_value());
    EXPECT_GT(estimate->correlation.front().back(), 0.9);
    const fit::FittedParameter& counted = modulus(fit.parameters);
    const fit::FittedParameter& weighed = modulus(estimate->parameters);
    EXPECT_GT(std::abs(counted.value - truth), 5.0 * counted.standard_error);
    EXPECT_LT(std::abs(weighed.value - truth), 3.0 * weighed.standard_error);
    EXPECT_LT(std::abs(weighed.value - truth), 0.3 * std::abs(counted.value - truth));
}

} // namespace
} // namespace culm::tests
