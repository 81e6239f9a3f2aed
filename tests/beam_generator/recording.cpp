// SPDX-License-Identifier: BSD-3-Clause
#include "beam_generator/recording.hpp"

#include "beam_generator/beam_motion.hpp"
#include "beam_generator/random_number.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace culm::beam {
namespace {

using Eigen::VectorXd;

/// The stem's line in space at one time, between the points of the grid.
class StemLine {
  public:
    StemLine(const BeamModel& model, const VectorXd& q) : grid_(model.grid()) {
        const auto functions = grid_.functions();
        const VectorXd in_plane = q.head(functions);
        Eigen::ArrayXd square = (grid_.slope * in_plane).array().square();
        if (model.fields() == 2)
            square += (grid_.slope * q.tail(functions)).array().square();
        cosine_ = (1.0 - square).sqrt();
        axial_ = grid_.integral * cosine_;
        lateral_ = grid_.deflection * in_plane;
    }

    /// The point at the arc length `place` from the clamp.
    [[nodiscard]] AxisPoint at(double place) const {
        const VectorXd weights = grid_.interpolation(place);
        return {weights.dot(axial_.head(grid_.points())),
                weights.dot(lateral_.head(grid_.points()))};
    }

    /// Deflection where the line crosses `height`; NaN above the tip.
    [[nodiscard]] double deflection_at(double height) const {
        if (height > axial_[grid_.points()])
            return std::numeric_limits<double>::quiet_NaN();
        constexpr int iterations = 6; // of Newton's method; the slope's square is small
        double place = height;
        VectorXd weights;
        for (int k = 0; k < iterations; ++k) {
            weights = grid_.interpolation(place);
            const double excess = weights.dot(axial_.head(grid_.points())) - height;
            place = std::clamp(place - excess / weights.dot(cosine_), 0.0, grid_.length);
            if (std::abs(excess) < 1e-12 * grid_.length)
                break;
        }
        return weights.dot(lateral_.head(grid_.points()));
    }

  private:
    const BeamGrid& grid_;
    VectorXd cosine_;
    VectorXd axial_;   ///< (P + 1)
    VectorXd lateral_; ///< (P + 1)
};

double support_position(const BeamTerms& terms, double time) {
    if (!terms.support)
        return 0.0;
    return terms.support->amplitude *
           std::sin(2.0 * std::numbers::pi * terms.support->frequency * time +
                    terms.support->phase);
}

void add_noise(const RecordingSpec& spec, measure::Measurement& measurement) {
    const ReadingErrors& errors = spec.errors;
    const double fresh = std::sqrt(1.0 - errors.correlation * errors.correlation);
    const std::size_t rows = measurement.heights.size();
    for (std::size_t j = 0; j < rows; ++j) {
        double noise = 0.0;
        for (std::size_t i = 0; i < measurement.times.size(); ++i) {
            double& reading = measurement.deflections[i * rows + j];
            const double drawn = normal({spec.seed, RandomUse::Noise, j, i});
            noise = i == 0 ? drawn : errors.correlation * noise + fresh * drawn;
            reading += errors.noise * noise;
            if (uniform({spec.seed, RandomUse::Outlier, 2 * j, i}) < errors.outlier_share)
                reading +=
                    errors.outlier_size * normal({spec.seed, RandomUse::Outlier, 2 * j + 1, i});
            if (errors.quantum > 0.0)
                reading = errors.quantum * std::round(reading / errors.quantum);
            if (uniform({spec.seed, RandomUse::Gap, j, i}) < errors.missing_share)
                reading = std::numeric_limits<double>::quiet_NaN();
        }
    }
}

} // namespace

std::vector<double> even_heights(double length, int rows) {
    constexpr double lowest = 0.08;
    constexpr double highest = 0.88;
    std::vector<double> heights;
    for (int j = 0; j < rows; ++j) {
        const double share = rows == 1 ? 1.0 : static_cast<double>(j) / (rows - 1);
        heights.push_back(length * (lowest + (highest - lowest) * share));
    }
    return heights;
}

std::vector<double> true_readings(const RecordingSpec& spec, const std::vector<double>& times) {
    const HiddenPhysics physics = hidden_physics(spec.stem, spec.effects, spec.law_errors);
    const BeamModel model(spec.stem, physics.terms);
    const double last = times.empty() ? 0.0 : times.back();
    const BeamMotion motion =
        release(model, held_at_tip(model, spec.tip_deflection),
                std::max(last, 0.0) + std::abs(physics.camera.readout_time), default_step(model));
    std::vector<double> readings;
    readings.reserve(times.size() * spec.heights.size());
    const bool is_row_by_row = physics.camera.readout_time != 0.0;
    for (const double time : times) {
        const StemLine frame(model, motion.coordinates(time));
        for (const double height : spec.heights) {
            const double share = height / spec.stem.length;
            const double seen = time + physics.camera.readout_time * share;
            const double deflection =
                is_row_by_row ? StemLine(model, motion.coordinates(seen)).deflection_at(height)
                              : frame.deflection_at(height);
            readings.push_back((deflection + support_position(physics.terms, seen)) *
                               (1.0 + physics.camera.scale_change * share));
        }
    }
    return readings;
}

std::vector<std::vector<AxisPoint>> axis_positions(const RecordingSpec& spec,
                                                   const std::vector<double>& times, int points) {
    const HiddenPhysics physics = hidden_physics(spec.stem, spec.effects, spec.law_errors);
    const BeamModel model(spec.stem, physics.terms);
    const BeamMotion motion = release(model, held_at_tip(model, spec.tip_deflection),
                                      std::max(times.back(), 0.0), default_step(model));
    std::vector<std::vector<AxisPoint>> positions;
    for (const double time : times) {
        const StemLine line(model, motion.coordinates(time));
        std::vector<AxisPoint>& axis = positions.emplace_back();
        for (int k = 0; k < points; ++k)
            axis.push_back(line.at(spec.stem.length * k / (points - 1)));
    }
    return positions;
}

measure::Measurement record(const RecordingSpec& spec) {
    measure::Measurement measurement;
    measurement.stem.id = spec.id;
    measurement.stem.length = spec.stem.length * (1.0 + spec.errors.length_error);
    measurement.stem.section = measure::CircularSection{spec.stem.diameter, std::nullopt};
    if (spec.stem.width > 0.0)
        measurement.stem.section = measure::RectangularSection{spec.stem.width, spec.stem.diameter};
    measurement.stem.density = spec.stem.density;
    measurement.gravity_direction = spec.gravity_direction;
    measurement.hold_time = spec.hold_time;
    measurement.frames_per_second = spec.frames_per_second;
    if (spec.errors.is_noise_stated && spec.errors.noise > 0.0)
        measurement.noise = spec.errors.noise;
    const int after = static_cast<int>(std::floor(spec.duration * spec.frames_per_second + 1e-9));
    std::vector<double> since_release;
    for (int k = -spec.frames_before; k <= after; ++k) {
        measurement.times.push_back(k / spec.frames_per_second);
        since_release.push_back(measurement.times.back() - spec.errors.clock_error);
    }
    measurement.heights = spec.heights;
    measurement.deflections = true_readings(spec, since_release);
    add_noise(spec, measurement);
    return measurement;
}

} // namespace culm::beam
