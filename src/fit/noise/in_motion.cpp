// SPDX-License-Identifier: BSD-3-Clause
#include "core/order_statistics.hpp"
#include "fit/noise/noise_laws.hpp"
#include "fit/noise/reading_noise.hpp"
#include "fit/solve/residual_statistics.hpp"
#include "run/modes.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <memory>
#include <numbers>
#include <span>
#include <utility>
#include <vector>

#include <Eigen/QR>
#include <boost/math/special_functions/gamma.hpp>
#include <fmt/core.h>
#include <unsupported/Eigen/FFT>

namespace culm::fit {
namespace {

constexpr std::size_t fewest_frames = 64;
constexpr std::size_t fewest_bins = 20;
/// A frequency or frame is free of lines if they leave this share of white noise's power.
constexpr double least_left = 0.5;
constexpr double level = 1e-3; ///< of the tests for a property of the noise
/// Largest ratio of the part at the lines to the rest; above it the rest contains misfit, too.
constexpr double largest_misfit = 2.0;
constexpr double far_off = 4.0; ///< distance of an outlier, scales

/// A frequency at which the motion and the misfit of a model have power.
struct Line {
    double frequency = 0.0;  ///< Hz
    double decay_rate = 0.0; ///< 1/s, positive
    int degree = 0;          ///< of the polynomial in time that multiplies the decay
};

/// The modes and the drift, the most important ones first.
std::vector<Line> lines_of(const RecordingFit& fit, double half_rate) {
    std::vector<Line> lines;
    const auto modes = run::chain_modes(computed_case(fit.model), 3);
    if (modes.empty())
        return lines;
    const double first = modes.front().frequency;
    const double decay = std::max(-modes.front().decay_rate, 0.0);
    lines.push_back({first, decay, 6});
    lines.push_back({0.0, 0.0, 4});
    // With another damping law than the chain's, a higher mode decays at any rate between these.
    for (std::size_t k = 1; k < modes.size(); ++k) {
        const double own = std::max(-modes[k].decay_rate, decay);
        for (const double rate : {decay, std::sqrt(decay * own), own})
            lines.push_back({modes[k].frequency, rate, 1});
    }
    std::erase_if(lines, [&](const Line& line) { return line.frequency >= half_rate; });
    return lines;
}

void add_columns(const Line& line, std::span<const double> times,
                 std::vector<Eigen::VectorXd>& columns) {
    const double duration = times.back() - times.front();
    const auto frames = static_cast<Eigen::Index>(times.size());
    for (int power = 0; power <= line.degree; ++power) {
        Eigen::VectorXd cosine(frames);
        Eigen::VectorXd sine(frames);
        for (Eigen::Index i = 0; i < frames; ++i) {
            const double time = times[static_cast<std::size_t>(i)] - times.front();
            const double place = 2.0 * time / duration - 1.0;
            // Chebyshev polynomials, because powers are almost dependent.
            const double size = std::exp(-line.decay_rate * time) *
                                std::cos(power * std::acos(std::clamp(place, -1.0, 1.0)));
            const double phase = 2.0 * std::numbers::pi * line.frequency * time;
            cosine(i) = size * std::cos(phase);
            sine(i) = size * std::sin(phase);
        }
        columns.push_back(cosine);
        if (line.frequency > 0.0)
            columns.push_back(sine);
    }
}

/// Residuals over the noise without the parts at the modes and in a drift. This most flexible fit
/// leaves only noise, whatever the model lacks.
class FlexibleRest {
  public:
    /// Uses the frames from `first` on.
    FlexibleRest(const RecordingFit& fit, std::size_t first) {
        const auto frames = static_cast<Eigen::Index>(fit.times.size() - first);
        const double duration = fit.times.back() - fit.times[first];
        const double rate = static_cast<double>(frames - 1) / duration;
        std::vector<Eigen::VectorXd> columns;
        for (const Line& line : lines_of(fit, 0.5 * rate)) {
            // A quarter of the frames at most: the noise is estimated from the rest.
            const auto more = 2 * (static_cast<std::size_t>(line.degree) + 1);
            if (columns.size() + more > static_cast<std::size_t>(frames) / 4)
                break;
            add_columns(line, std::span(fit.times).subspan(first), columns);
        }
        basis_.resize(frames, 0);
        if (columns.empty()) // Eigen's QR needs a column
            return;
        Eigen::MatrixXd basis(frames, static_cast<Eigen::Index>(columns.size()));
        for (std::size_t k = 0; k < columns.size(); ++k)
            basis.col(static_cast<Eigen::Index>(k)) = columns[k].normalized();
        Eigen::ColPivHouseholderQR<Eigen::MatrixXd> solver(basis);
        solver.setThreshold(1e-6);
        basis_ = solver.householderQ() * Eigen::MatrixXd::Identity(frames, solver.rank());
    }

    /// The part of a series at the lines.
    [[nodiscard]] Eigen::VectorXd smooth(const Eigen::VectorXd& values) const {
        return basis_ * (basis_.transpose() * values);
    }

    /// Share of the degrees of freedom that the lines do not take.
    [[nodiscard]] double free_share() const {
        return 1.0 - static_cast<double>(basis_.cols()) / static_cast<double>(basis_.rows());
    }

    /// (frames) share of white noise's power that remains there.
    [[nodiscard]] Eigen::VectorXd free_of_frames() const {
        return (1.0 - basis_.rowwise().squaredNorm().array()).matrix();
    }

    /// (Fourier frequencies from 0 to half the rate) share of white noise's power that remains
    /// there.
    [[nodiscard]] Eigen::ArrayXd left_of_noise() const {
        Eigen::FFT<double> transform;
        Eigen::ArrayXd left = Eigen::ArrayXd::Ones(basis_.rows() / 2 + 1);
        for (Eigen::Index c = 0; c < basis_.cols(); ++c) {
            const std::vector<double> values(basis_.col(c).begin(), basis_.col(c).end());
            std::vector<std::complex<double>> found;
            transform.fwd(found, values);
            for (Eigen::Index k = 0; k < left.size(); ++k)
                left(k) -= std::norm(found[static_cast<std::size_t>(k)]) /
                           static_cast<double>(basis_.rows());
        }
        return left;
    }

  private:
    Eigen::MatrixXd basis_; ///< (frames, columns), orthonormal
};

class NoiseEstimate {
  public:
    NoiseEstimate(const RecordingFit& fit, ObservedRecording& measurement)
        : fit_(fit), measurement_(measurement), noise_(relative_noise(measurement, fit.noise)) {
        noise_.resize(measurement.deflections.size(), 1.0);
        for (std::size_t at = 0; at < noise_.size(); ++at)
            noise_[at] *= fit.noise[at % fit.noise.size()];
    }

    /// False if the record is too short.
    bool run() {
        const auto released = std::ranges::find_if(fit_.times, [](double t) { return t >= 0.0; });
        first_ = static_cast<std::size_t>(released - fit_.times.begin());
        if (fit_.times.size() - first_ < fewest_frames)
            return false;
        const FlexibleRest flexible(fit_, first_);
        take_residuals(flexible);
        estimate_timing();
        left_ = flexible.left_of_noise();
        for (Eigen::Index k = 1; k < left_.size() - 1; ++k)
            if (left_(k) > least_left)
                bins_.push_back(k);
        if (bins_.size() < fewest_bins)
            return false;
        draw_in_outliers(flexible);
        if (fit_.is_noise_known && smooth_.norm() > largest_misfit * rest_.norm())
            return false;
        estimate_correlation();
        write();
        return true;
    }

  private:
    [[nodiscard]] bool is_seen(Eigen::Index frame, Eigen::Index row) const {
        return !std::isnan(fit_.residuals[place(frame, row)]);
    }
    [[nodiscard]] std::size_t place(Eigen::Index frame, Eigen::Index row) const {
        return (first_ + static_cast<std::size_t>(frame)) * fit_.prediction.rows +
               static_cast<std::size_t>(row);
    }

    /// Sets the residuals over the noise, and the part of each row at the lines.
    void take_residuals(const FlexibleRest& flexible) {
        const auto frames = static_cast<Eigen::Index>(fit_.times.size() - first_);
        const auto rows = static_cast<Eigen::Index>(fit_.prediction.rows);
        values_ = Eigen::MatrixXd::Zero(frames, rows);
        growth_ = Eigen::MatrixXd::Ones(frames, rows);
        for (Eigen::Index j = 0; j < rows; ++j)
            for (Eigen::Index i = 0; i < frames; ++i)
                if (is_seen(i, j))
                    values_(i, j) = fit_.residuals[place(i, j)] / noise_[place(i, j)];
        smooth_ = Eigen::MatrixXd::Zero(frames, rows);
        settle(flexible, {});
    }

    /// A computer that polls a sensor stamps its readings at uncertain times: their noise grows
    /// with the rate of the reading. (A camera's frames have the times of its crystal.)
    void estimate_timing() {
        std::vector<double> errors;
        std::vector<double> rates;
        Eigen::MatrixXd rate = Eigen::MatrixXd::Zero(rest_.rows(), rest_.cols());
        for (Eigen::Index j = 0; j < rest_.cols(); ++j) {
            if (measure::is_of_camera(measurement_.sensors, static_cast<std::size_t>(j)))
                continue;
            for (Eigen::Index i = 1; i + 1 < rest_.rows(); ++i)
                rate(i, j) = rate_at(i, j) / noise_[place(i, j)];
            for (Eigen::Index i = 0; i < rest_.rows(); ++i)
                if (is_seen(i, j) && std::isfinite(rate(i, j))) {
                    errors.push_back(rest_(i, j));
                    rates.push_back(rate(i, j));
                }
        }
        const TimingNoise timing = timing_noise_of(errors, rates);
        model_.time_uncertainty = timing.time_uncertainty;
        if (timing.time_uncertainty == 0.0)
            return;
        for (Eigen::Index j = 0; j < rest_.cols(); ++j) {
            const Eigen::ArrayXd square =
                1.0 + (timing.time_uncertainty / timing.deviation * rate.col(j)).array().square();
            growth_.col(j) = (square / square.mean()).sqrt().matrix();
        }
    }

    /// Rate of the predicted reading, m/s for a displacement.
    [[nodiscard]] double rate_at(Eigen::Index i, Eigen::Index j) const {
        const std::vector<double>& readings = fit_.prediction.readings;
        const std::size_t frame = first_ + static_cast<std::size_t>(i);
        return (readings[place(i + 1, j)] - readings[place(i - 1, j)]) /
               (fit_.times[frame + 1] - fit_.times[frame - 1]);
    }

    /// Iterates the smooth part s to its fixed point. A missing reading is replaced by s (Dempster
    /// et al. 1977), one with heavy tails by s + ψ((y − s)/σ) σ/ψ̄′ with Student's
    /// ψ(z) = (ν + 1) z/(ν + z²). To first order such readings are the truth plus noise of the
    /// variance of the best estimate (Huber 1981, 7.8), whatever is then fitted to them.
    void settle(const FlexibleRest& flexible, const Tails& tails) {
        constexpr int most_passes = 12;
        constexpr double settled = 1e-3; // of the noise
        for (Eigen::Index j = 0; j < values_.cols(); ++j)
            for (int pass = 0; pass < most_passes; ++pass) {
                Eigen::VectorXd taken = values_.col(j);
                for (Eigen::Index i = 0; i < taken.size(); ++i)
                    taken(i) = smooth_(i, j) + (is_seen(i, j) ? limited(tails, i, j) : 0.0);
                const Eigen::VectorXd next = flexible.smooth(taken);
                const double change = (next - smooth_.col(j)).cwiseAbs().maxCoeff();
                smooth_.col(j) = next;
                if (change < settled)
                    break;
            }
        rest_ = Eigen::MatrixXd::Zero(values_.rows(), values_.cols());
        for (Eigen::Index j = 0; j < rest_.cols(); ++j)
            for (Eigen::Index i = 0; i < rest_.rows(); ++i)
                if (is_seen(i, j))
                    rest_(i, j) = limited(tails, i, j);
    }

    /// The rest of a reading, with outliers limited.
    [[nodiscard]] double limited(const Tails& tails, Eigen::Index i, Eigen::Index j) const {
        return growth_(i, j) * tails.scored((values_(i, j) - smooth_(i, j)) / growth_(i, j));
    }

    [[nodiscard]] Tails tails_now(double free_share) const {
        std::vector<double> errors;
        for (Eigen::Index j = 0; j < values_.cols(); ++j)
            for (Eigen::Index i = 0; i < values_.rows(); ++i)
                if (is_seen(i, j))
                    errors.push_back((values_(i, j) - smooth_(i, j)) /
                                     (growth_(i, j) * std::sqrt(free_share)));
        return tails_of(errors);
    }

    void draw_in_outliers(const FlexibleRest& flexible) {
        tails_ = tails_now(flexible.free_share());
        if (!tails_.is_heavy)
            return;
        // Outliers have moved the first smooth part, most where few readings determine it. The
        // second starts from readings that are clipped at 4 scales.
        const double clip = far_off * tails_.scale;
        draw_in_where_lines_take_all(flexible.free_of_frames(), clip);
        for (Eigen::Index j = 0; j < values_.cols(); ++j)
            smooth_.col(j) = flexible.smooth(values_.col(j).cwiseMin(clip).cwiseMax(-clip));
        constexpr int passes = 2;
        for (int pass = 0; pass < passes; ++pass) {
            settle(flexible, tails_);
            tails_ = tails_now(flexible.free_share());
            if (!tails_.is_heavy)
                break;
        }
        settle(flexible, tails_);
    }

    /// In some frames, mainly next to the release, the lines absorb most of a reading with its
    /// error, so the rest shows no outlier. There a reading is compared with its neighbours.
    void draw_in_where_lines_take_all(const Eigen::VectorXd& free, double clip) {
        for (Eigen::Index i = 0; i < values_.rows(); ++i)
            for (Eigen::Index j = 0; j < values_.cols() && free(i) < least_left; ++j) {
                const double about = of_neighbours(place(i, j));
                if (is_seen(i, j) && std::abs(values_(i, j) - about) > clip)
                    values_(i, j) = about + tails_.scored(values_(i, j) - about);
            }
    }

    /// The median residual of a reading and the rows next to it, five in all, over the noise.
    /// An outlier is in one row; the misfit of a model is in many.
    [[nodiscard]] double of_neighbours(std::size_t at) const {
        constexpr std::size_t most = 5;
        const std::size_t rows = fit_.noise.size();
        const std::size_t row = at % rows;
        const std::size_t count = std::min(most, rows);
        const std::size_t first = at - row + std::min(row - std::min(row, count / 2), rows - count);
        std::vector<double> near;
        for (std::size_t k = first; k < first + count; ++k)
            if (!std::isnan(fit_.residuals[k]))
                near.push_back(fit_.residuals[k] / noise_[k]);
        return near.size() > 2 ? core::median(near) : fit_.residuals[at] / noise_[at];
    }

    /// Weights outliers as in Student's t, by (ν + 1)/(ν + z²) with z the error over its scale. The
    /// mean weight is 1, and a weighted mean has the variance of the best estimate (Lange et al.
    /// 1989). While the stem is held, z is relative to the row's median, or to its neighbours.
    void weigh_outliers() {
        for (Eigen::Index j = 0; j < values_.cols(); ++j)
            for (Eigen::Index i = 0; i < values_.rows(); ++i)
                if (const std::size_t at = place(i, j); is_seen(i, j))
                    weigh(at, (fit_.residuals[at] / noise_[at] - smooth_(i, j)) / growth_(i, j));
        for (std::size_t j = 0; j < fit_.noise.size(); ++j)
            weigh_held(j);
    }

    void weigh(std::size_t at, double error) {
        model_.relative[at] *= std::sqrt((tails_.degrees + std::pow(error / tails_.scale, 2)) /
                                         (tails_.degrees + 1.0));
    }

    void weigh_held(std::size_t row) {
        constexpr std::size_t fewest = 5; // their median withstands two outliers
        std::vector<double> residuals;
        for (std::size_t i = 0; i < first_; ++i)
            if (const double residual = fit_.residuals[i * fit_.noise.size() + row];
                !std::isnan(residual))
                residuals.push_back(residual);
        if (residuals.empty())
            return;
        const double centre = core::median(residuals);
        for (std::size_t i = 0; i < first_; ++i) {
            const std::size_t at = i * fit_.noise.size() + row;
            const double about =
                residuals.size() < fewest ? of_neighbours(at) : centre / noise_[at];
            if (const double error = fit_.residuals[at] / noise_[at] - about; !std::isnan(error))
                weigh(at, error);
        }
    }

    void estimate_correlation() {
        const Eigen::MatrixXcd found =
            fourier_coefficients(rest_.cwiseQuotient(growth_), bins_, left_);
        const Eigen::ArrayXd power = found.cwiseAbs2().rowwise().mean();
        const auto rows = static_cast<double>(found.cols());
        const double correlation = slow_noise_of(power, rows, bins_, rest_.rows()).correlation;
        const Eigen::ArrayXd spectrum = spectrum_of(correlation, bins_, rest_.rows());
        model_.common_share = common_share_of(
            spectrum.rsqrt().matrix().cast<std::complex<double>>().asDiagonal() * found);
        const double copies = independent_rows(model_.common_share, rows);
        const SlowNoise slow = slow_noise_of(power, copies, bins_, rest_.rows());
        model_.correlation = slow.correlation;
        variance_ = slow.variance;
        degrees_ = 2.0 * copies * static_cast<double>(bins_.size());
    }

    /// The stated noise is used, unless the readings scatter more when nothing moves, or their
    /// noise is not independent and Gaussian.
    [[nodiscard]] bool is_as_stated() const {
        const double half = 0.5 * degrees_;
        return !tails_.is_heavy && model_.correlation == 0.0 && model_.common_share == 0.0 &&
               model_.time_uncertainty == 0.0 &&
               !(boost::math::gamma_q(half, half * variance_) < level);
    }

    void write() {
        if (is_as_stated())
            return;
        model_.source = in_words(model_, tails_, typical_noise(fit_) * std::sqrt(variance_),
                                 measure::reading_unit(fit_.model.spec.sensors), fit_.noise_source);
        if (fit_.is_noise_known) { // else only the residuals determine its size
            model_.by_row = fit_.noise;
            for (double& of_row : model_.by_row)
                of_row *= std::sqrt(variance_);
        }
        model_.relative = relative_noise(measurement_, fit_.noise);
        if (tails_.is_heavy || model_.time_uncertainty > 0.0)
            model_.relative.resize(measurement_.deflections.size(), 1.0);
        for (Eigen::Index j = 0; j < growth_.cols() && model_.time_uncertainty > 0.0; ++j)
            for (Eigen::Index i = 0; i < growth_.rows(); ++i)
                model_.relative[place(i, j)] *= growth_(i, j);
        if (tails_.is_heavy)
            weigh_outliers();
        measurement_.noise_model = std::make_shared<const NoiseModel>(std::move(model_));
    }

    const RecordingFit& fit_;
    ObservedRecording& measurement_;
    std::vector<double> noise_; ///< (frames, rows), m
    std::size_t first_ = 0;
    Eigen::MatrixXd values_; ///< (frames, rows), residuals over the noise
    Eigen::MatrixXd smooth_; ///< their smooth part
    Eigen::MatrixXd rest_;   ///< the rest, outliers limited
    Eigen::MatrixXd growth_; ///< of the noise by uncertain times, over its root mean square
    Eigen::ArrayXd left_;    ///< FlexibleRest::left_of_noise
    std::vector<Eigen::Index> bins_;
    Tails tails_;
    NoiseModel model_;
    double variance_ = 1.0; ///< over the noise's, away from the lines
    double degrees_ = 0.0;  ///< of freedom of the variance
};

bool is_near(double one, double other) {
    constexpr double allowed = 0.01;
    return std::abs(one - other) <= allowed * std::max(std::abs(one), std::abs(other));
}

} // namespace

bool has_same_noise(const ObservedRecording& one, const ObservedRecording& other) {
    if (!one.noise_model || !other.noise_model)
        return !one.noise_model && !other.noise_model;
    return is_near(one.noise_model->correlation, other.noise_model->correlation) &&
           is_near(one.noise_model->common_share, other.noise_model->common_share) &&
           one.noise_model->relative.empty() == other.noise_model->relative.empty() &&
           std::ranges::equal(one.noise_model->by_row, other.noise_model->by_row,
                              [](double a, double b) { return is_near(a, b); });
}

ObservedRecording with_noise_in_motion(const RecordingFit& fit,
                                       const ObservedRecording& measurement) {
    ObservedRecording out = measurement;
    const bool is_estimated = NoiseEstimate(fit, out).run();
    const double stated = is_estimated ? 0.0 : out.noise_correlation.value_or(0.0);
    if (out.noise_model || (out.reading_uncertainties.empty() && stated == 0.0))
        return out;
    NoiseModel model{{}, fit.noise_source, stated, 0.0, 0.0, relative_noise(out, fit.noise)};
    if (fit.is_noise_known)
        model.by_row = fit.noise;
    if (stated > 0.0)
        model.source += fmt::format(", correlated by {:.2g} from frame to frame (stated)", stated);
    out.noise_model = std::make_shared<const NoiseModel>(std::move(model));
    return out;
}

} // namespace culm::fit
