// SPDX-License-Identifier: BSD-3-Clause
// What a repetition of the experiment would show: the noise counts as it does in the fits.
#include "diagnose/experiment/next_experiment.hpp"

#include "beam_generator/recording.hpp"
#include "diagnose/models/stem_fit.hpp"
#include "diagnosis_records.hpp"

#include <cmath>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <gtest/gtest.h>

namespace culm::tests {
namespace {

beam::RecordingSpec little_drag() {
    beam::RecordingSpec spec;
    spec.heights = beam::even_heights(spec.stem.length, 6);
    spec.duration = 0.2;
    spec.errors.noise = 0.03e-3;
    spec.effects = {{"quadratic_drag", {{"drag_coefficient", 0.3}}}};
    return spec;
}

/// Expected gaps between chain and drag, by experiment, with this correlation of two rows.
std::map<std::string, double> gaps_with(double common_share) {
    fit::ObservedRecording recording(beam::record(little_drag()));
    fit::NoiseModel noise;
    noise.by_row.assign(recording.heights.size(), little_drag().errors.noise);
    noise.common_share = common_share;
    recording.noise_model = std::make_shared<const fit::NoiseModel>(std::move(noise));
    const std::vector<fit::ObservedRecording> recordings{recording};
    const fit::FitOptions options = quick_fit();
    const fit::Fit chain = fit::fit_model({}, {}, recordings, options);
    const fit::Fit drag = diagnose::fit_larger(physics::parse_effects("quadratic_drag", {}), chain,
                                               recordings, options);
    std::map<std::string, double> gaps;
    for (const diagnose::Experiment& each :
         diagnose::next_experiments({{drag, {}}, {chain, {}}}, recordings, options, {}))
        gaps[each.what] = each.expected_gap;
    return gaps;
}

/// First mode of a slender cantilever.
double mode_shape(double share_of_length) {
    constexpr double root = 1.87510407;
    const double x = root * share_of_length;
    const double factor = (std::cosh(root) + std::cos(root)) / (std::sinh(root) + std::sin(root));
    return std::cosh(x) - std::cos(x) - factor * (std::sinh(x) - std::sin(x));
}

// The models differ in the amplitude of the first mode. With the covariance C of the rows of a
// frame the squared distance of the shape s is s' C⁻¹ s instead of s' s.
TEST(NextExperiment, CountsTheCorrelationOfTheNoise) {
    constexpr double common_share = 0.9;
    const beam::RecordingSpec spec = little_drag();
    const auto rows = static_cast<Eigen::Index>(spec.heights.size());
    Eigen::VectorXd shape(rows);
    for (Eigen::Index j = 0; j < rows; ++j)
        shape(j) = mode_shape(spec.heights[static_cast<std::size_t>(j)] / spec.stem.length);
    Eigen::MatrixXd covariance = Eigen::MatrixXd::Constant(rows, rows, common_share);
    covariance.diagonal().setOnes();
    const double ratio = shape.dot(covariance.ldlt().solve(shape)) / shape.squaredNorm();
    EXPECT_GT(ratio, 3.0); // white noise: 1
    const std::map<std::string, double> separate = gaps_with(0.0);
    const std::map<std::string, double> common = gaps_with(common_share);
    const std::string experiment = "release in a vacuum";
    ASSERT_TRUE(separate.contains(experiment) && common.contains(experiment));
    EXPECT_NEAR(common.at(experiment) / separate.at(experiment), ratio, 0.15 * ratio);
}

} // namespace
} // namespace culm::tests
