// SPDX-License-Identifier: BSD-3-Clause
// Where the stem lies in a row: by its brightness across, as the frames show it in which it hardly
// moves, smeared as far as it moves while the shutter is open.
#include "measure/track/track.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include <Eigen/Dense>
#include <boost/math/tools/minima.hpp>

namespace culm::measure {

namespace {

constexpr double no_match = std::numeric_limits<double>::quiet_NaN();
constexpr double beyond_edge = 4.0; // pixels: two standard deviations of a strong blur
// Closer knots follow the noise, and the axis in the frames that the profile is made of follows
// them.
constexpr double closest_knots = 0.5; // pixels
constexpr double table_step = 1.0 / 16.0;
constexpr double least_smear = 2.0 * table_step;
constexpr double largest_noise = 4.0; // standard deviations; beyond it a pixel is dust (Huber)

/// Of the four cubic B-splines on the interval in which u = 0 … 1.
std::array<double, 4> basis(double u) {
    const double v = 1.0 - u;
    return {v * v * v / 6.0, (4.0 + 3.0 * u * u * (u - 2.0)) / 6.0,
            (4.0 + 3.0 * v * v * (v - 2.0)) / 6.0, u * u * u / 6.0};
}

/// Columns begin … end − 1 of a row.
struct Pixels {
    int begin;
    int end;
};

struct PixelRow {
    const float* values;         ///< grey, or less grey: of a dark stem
    const std::uint8_t* clutter; ///< 1 = not the stem nor its background; null: none
    int width;

    [[nodiscard]] bool counts(int column) const { return !clutter || clutter[column] == 0; }
    [[nodiscard]] Pixels within(double column, double distance) const;
};

/// Contrast over the distance of a pixel's middle from the stem's axis. It holds what the lens and
/// the pixel do to an edge and how the light falls on the stem, so none of these moves a reading.
class StemProfile {
  public:
    /// `reach`: the largest distance that counts, pixels.
    explicit StemProfile(double reach);

    /// Takes the pixels of a row in which the axis lies at `axis`, over the straight line through
    /// those beside the stem.
    void add(const PixelRow& row, double axis);

    /// Least squares for a cubic spline through what was added. False if that is too little.
    [[nodiscard]] bool close();

    struct Point {
        double value; ///< grey values
        double slope; ///< per pixel
    };
    /// Mean over a stem that moves by `smear` (pixels) at an even speed.
    [[nodiscard]] Point at(double distance, double smear) const;
    /// Distance to which pixels beside the stem tell of its background.
    [[nodiscard]] double beside() const { return 2.0 * reach_; }

  private:
    [[nodiscard]] double spline(double place) const;
    [[nodiscard]] double in_table(const std::vector<double>& table, double distance) const;

    double reach_;
    double spacing_; ///< of the knots, pixels
    std::size_t knots_;
    std::vector<double> normal_; ///< (knots, knots) lower part
    std::vector<double> right_;
    std::vector<double> coefficients_;
    std::vector<double> values_;    ///< at even distances
    std::vector<double> integrals_; ///< from −reach
    std::size_t pixels_ = 0;
};

struct RowMatch {
    double axis = 0.0;
    double variance = 0.0; ///< of the axis, pixels², over the pixels' noise² in grey values²
    double squares = 0.0;  ///< what is left, grey values²
};

Pixels PixelRow::within(double column, double distance) const {
    return {std::max(0, static_cast<int>(std::ceil(column - distance))),
            std::min(width, static_cast<int>(std::floor(column + distance)) + 1)};
}

StemProfile::StemProfile(double reach)
    : reach_(reach), spacing_(std::max(closest_knots, reach / 40.0)),
      knots_(static_cast<std::size_t>(std::ceil(2.0 * reach / spacing_)) + 3),
      normal_(knots_ * knots_), right_(knots_) {}

void StemProfile::add(const PixelRow& row, double axis) {
    const Pixels around = row.within(axis, beside());
    Eigen::Matrix2d of_line = Eigen::Matrix2d::Zero();
    Eigen::Vector2d line = Eigen::Vector2d::Zero();
    for (int c = around.begin; c < around.end; ++c)
        if (std::abs(c - axis) > reach_ && row.counts(c)) {
            const Eigen::Vector2d by(1.0, c - axis);
            of_line += by * by.transpose();
            line += by * row.values[c];
        }
    line = of_line.ldlt().solve(line);
    const Pixels inside = row.within(axis, reach_);
    for (int c = inside.begin; c < inside.end; ++c) {
        if (!row.counts(c))
            continue;
        const double contrast = row.values[c] - line[0] - line[1] * (c - axis);
        const double place = (c - axis + reach_) / spacing_;
        const std::size_t first = std::min(static_cast<std::size_t>(place), knots_ - 4);
        const std::array<double, 4> weights = basis(place - static_cast<double>(first));
        for (std::size_t i = 0; i < 4; ++i) {
            right_[first + i] += weights[i] * contrast;
            for (std::size_t j = 0; j <= i; ++j)
                normal_[(first + i) * knots_ + first + j] += weights[i] * weights[j];
        }
        ++pixels_;
    }
}

bool StemProfile::close() {
    if (pixels_ < 4 * knots_)
        return false;
    const auto size = static_cast<Eigen::Index>(knots_);
    using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    RowMajor normal = Eigen::Map<const RowMajor>(normal_.data(), size, size);
    // A stem that keeps its place between the pixels leaves knots without a pixel: a thousandth of
    // a pixel's weight against bends joins them to their neighbours.
    const double weight = 1e-3 * static_cast<double>(pixels_) / static_cast<double>(knots_);
    for (Eigen::Index k = 1; k + 1 < size; ++k)
        for (Eigen::Index i = -1; i <= 1; ++i)
            for (Eigen::Index j = -1; j <= i; ++j)
                normal(k + i, k + j) += weight * (i == 0 ? -2.0 : 1.0) * (j == 0 ? -2.0 : 1.0);
    const Eigen::VectorXd solution = normal.selfadjointView<Eigen::Lower>().ldlt().solve(
        Eigen::Map<const Eigen::VectorXd>(right_.data(), size));
    coefficients_.assign(solution.begin(), solution.end());
    values_.clear();
    integrals_.assign(1, 0.0);
    for (double distance = -reach_; distance <= reach_; distance += table_step)
        values_.push_back(spline((distance + reach_) / spacing_));
    for (std::size_t k = 1; k < values_.size(); ++k)
        integrals_.push_back(integrals_.back() + 0.5 * table_step * (values_[k - 1] + values_[k]));
    return true;
}

double StemProfile::spline(double place) const {
    const std::size_t first = std::min(static_cast<std::size_t>(place), knots_ - 4);
    const std::array<double, 4> weights = basis(place - static_cast<double>(first));
    double sum = 0.0;
    for (std::size_t i = 0; i < 4; ++i)
        sum += weights[i] * coefficients_[first + i];
    return sum;
}

double StemProfile::in_table(const std::vector<double>& table, double distance) const {
    const double last = static_cast<double>(table.size()) - 1.001;
    const double place = std::clamp((distance + reach_) / table_step, 0.0, last);
    const auto below = static_cast<std::size_t>(place);
    return table[below] + (place - static_cast<double>(below)) * (table[below + 1] - table[below]);
}

StemProfile::Point StemProfile::at(double distance, double smear) const {
    const double width = std::max(std::abs(smear), least_smear);
    const double low = distance - 0.5 * width;
    const double high = distance + 0.5 * width;
    return {(in_table(integrals_, high) - in_table(integrals_, low)) / width,
            (in_table(values_, high) - in_table(values_, low)) / width};
}

/// Least squares for the axis, the stem's brightness and a straight line for the background's, from
/// an axis that is good to half a pixel or so. Empty if that leads away.
std::optional<RowMatch> match_row(const StemProfile& profile, const PixelRow& row, double axis,
                                  double smear, double noise) {
    constexpr int most_iterations = 20;
    constexpr double close = 1e-4; // pixels
    const Pixels around = row.within(axis, profile.beside() + 0.5 * std::abs(smear));
    // Of the axis, the stem's brightness, the background's and its slope.
    Eigen::Vector4d values(axis, 1.0, 0.0, 0.0);
    RowMatch found;
    for (int k = 0; k < most_iterations; ++k) {
        Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
        Eigen::Vector4d right = Eigen::Vector4d::Zero();
        double squares = 0.0;
        for (int c = around.begin; c < around.end; ++c) {
            if (!row.counts(c))
                continue;
            const StemProfile::Point point = profile.at(c - values[0], smear);
            const Eigen::Vector4d by(-values[1] * point.slope, point.value, 1.0, c - axis);
            const double left = row.values[c] - values.tail<3>().dot(by.tail<3>());
            const double weight =
                k < 3 ? 1.0 : std::min(1.0, largest_noise * noise / std::abs(left));
            normal.noalias() += weight * by * by.transpose();
            right += weight * left * by;
            squares += weight * left * left;
        }
        const auto solver = normal.ldlt();
        const Eigen::Vector4d step = solver.solve(right);
        if (!step.allFinite() || !(normal.diagonal().minCoeff() > 0.0))
            return std::nullopt;
        found.variance = solver.solve(Eigen::Vector4d::UnitX())[0];
        found.squares = squares - step.dot(right);
        values += step;
        values[0] -= step[0] - std::clamp(step[0], -1.0, 1.0);
        found.axis = values[0];
        if (!(values[1] > 0.2) || std::abs(found.axis - axis) > 1.0 + 0.3 * std::abs(smear))
            return std::nullopt;
        if (k > 3 && std::abs(step[0]) < close)
            return found.variance > 0.0 ? std::optional(found) : std::nullopt;
    }
    return std::nullopt;
}

/// Grey values of a row where the stem is not.
class GroundRow {
  public:
    /// Pixels within `hidden` of the axis are not the ground; NaN: the axis is not known.
    void add(const PixelRow& row, double axis, double hidden) {
        sums_.resize(std::size_t(row.width));
        counts_.resize(std::size_t(row.width));
        if (std::isnan(axis) || std::isnan(hidden))
            return;
        for (int c = 0; c < row.width; ++c)
            if (std::abs(c - axis) > hidden) {
                sums_[std::size_t(c)] += row.values[c];
                ++counts_[std::size_t(c)];
            }
    }

    /// Between pixels that were seen in thirty frames or more a straight line; 0 if there are none.
    [[nodiscard]] std::vector<float> mean() const {
        constexpr int fewest = 30;
        std::vector<float> mean(sums_.size(), 0.0F);
        std::optional<std::size_t> last;
        for (std::size_t c = 0; c < sums_.size(); ++c) {
            if (counts_[c] < fewest)
                continue;
            mean[c] = static_cast<float>(sums_[c] / counts_[c]);
            const std::size_t before = last.value_or(c);
            for (std::size_t k = last ? before + 1 : 0; k < c; ++k)
                mean[k] = std::lerp(mean[before], mean[c],
                                    c == before ? 1.0F : float(k - before) / float(c - before));
            last = c;
        }
        if (last)
            std::fill(mean.begin() + std::ptrdiff_t(*last), mean.end(), mean[*last]);
        return mean;
    }

  private:
    std::vector<double> sums_;
    std::vector<int> counts_;
};

/// A row of the picture that a height uses.
struct UsedRow {
    std::size_t row;
    std::size_t height;
};

class RowMatcher {
  public:
    RowMatcher(Track& track, const FrameSource& source, const std::vector<std::size_t>& wanted,
               int threads)
        : track_(track), source_(source), wanted_(wanted), threads_(threads),
          used_(used_rows(track)) {}

    std::optional<double> run() {
        find_ground();
        const std::vector<std::size_t> slow = frames_by_speed(false);
        const std::vector<BandImage> slow_rows = pictures(slow);
        // The first pass knows the axis to a tenth of a pixel only, a profile to a hundredth.
        for (int k = 0; k < 2; ++k) {
            make_profiles(slow, slow_rows);
            match(slow, slow_rows);
        }
        make_profiles(slow, slow_rows);
        std::optional<double> seen;
        if (track_.settings.description.exposure)
            exposure_ = *track_.settings.description.exposure * track_.frames_per_second;
        else if ((seen = exposure_seen()))
            exposure_ = *seen;
        const AxisRecord first = track_.rows; // speeds are those of the first pass in all frames
        speeds_of_ = &first;
        source_.for_each(wanted_, threads_, [&](std::size_t i, const FrameImage& frame) {
            match(i, used_rows_of(frame));
        });
        return seen;
    }

  private:
    static std::vector<UsedRow> used_rows(const Track& track) {
        const double reach = 0.5 * (track.settings.rows_per_height + 1);
        std::vector<UsedRow> used;
        for (std::size_t row = 0; row < track.rows.places.size(); ++row) {
            std::optional<UsedRow> nearest;
            double least = reach;
            for (std::size_t h = 0; h < track.heights.places.size(); ++h) {
                const double distance =
                    std::abs(track.survey.clamp_row - track.heights.places[h] - double(row));
                if (distance < least) {
                    least = distance;
                    nearest = UsedRow{row, h};
                }
            }
            if (nearest)
                used.push_back(*nearest);
        }
        return used;
    }

    /// What the used rows show where the stem is not: the mean over frames. A reading would else
    /// err with the ground under the stem's edges, alike as long as it moves little. Pixels that
    /// are always hidden lie between their neighbours.
    void find_ground() {
        constexpr std::size_t frames_for_ground = 600;
        constexpr std::size_t at_once = 16;
        const std::size_t step = wanted_.size() / frames_for_ground + 1;
        std::vector<std::size_t> frames;
        for (std::size_t frame = 0; frame < wanted_.size(); frame += step)
            frames.push_back(frame);
        std::vector<GroundRow> ground(used_.size());
        for (std::size_t begin = 0; begin < frames.size(); begin += at_once) {
            const std::vector<std::size_t> some(
                frames.begin() + std::ptrdiff_t(begin),
                frames.begin() + std::ptrdiff_t(std::min(begin + at_once, frames.size())));
            const std::vector<BandImage> rows = pictures(some);
            for (std::size_t i = 0; i < some.size(); ++i)
                for (std::size_t u = 0; u < used_.size(); ++u)
                    ground[u].add(pixels(rows[i], u), track_.rows.at(some[i], used_[u].row),
                                  profile_reach() + std::abs(speed(some[i], used_[u].row)));
        }
        for (const GroundRow& row : ground)
            ground_.push_back(row.mean());
    }
    [[nodiscard]] double profile_reach() const {
        return 0.5 * track_.survey.apparent_width + beyond_edge + 1.0;
    }

    /// The used rows, one below the other; the stem is brighter than the rest, which is about 0
    /// once the ground is known.
    [[nodiscard]] BandImage used_rows_of(const FrameImage& frame) const {
        const StemView& view = track_.survey.view;
        const BandImage image = upright_band(frame, view.band, view.up);
        BandImage rows(image.width, static_cast<int>(used_.size()));
        for (std::size_t u = 0; u < used_.size(); ++u)
            for (int c = 0; c < image.width; ++c)
                rows.row(static_cast<int>(u))[c] =
                    static_cast<float>(view.sign) * image.row(static_cast<int>(used_[u].row))[c] -
                    (ground_.empty() ? 0.0F : ground_[u][std::size_t(c)]);
        return rows;
    }
    [[nodiscard]] PixelRow pixels(const BandImage& rows, std::size_t u) const {
        const std::vector<std::uint8_t>& clutter = track_.survey.trace.clutter;
        const std::size_t begin = used_[u].row * std::size_t(rows.width);
        return {rows.row(static_cast<int>(u)), clutter.empty() ? nullptr : clutter.data() + begin,
                rows.width};
    }
    [[nodiscard]] std::vector<BandImage> pictures(const std::vector<std::size_t>& frames) const {
        std::vector<std::size_t> indices;
        for (const std::size_t frame : frames)
            indices.push_back(wanted_[frame]);
        std::vector<BandImage> rows(frames.size());
        source_.for_each(indices, threads_, [&](std::size_t i, const FrameImage& frame) {
            rows[i] = used_rows_of(frame);
        });
        return rows;
    }

    /// Pixels per frame, from the neighbouring frames.
    [[nodiscard]] double speed(std::size_t frame, std::size_t row) const {
        const AxisRecord& record = *speeds_of_;
        const std::size_t before = frame > 0 ? frame - 1 : frame;
        const std::size_t after = std::min(frame + 1, record.numbers.size() - 1);
        return (record.at(after, row) - record.at(before, row)) /
               (record.numbers[after] - record.numbers[before]);
    }

    /// Frames in which the used rows together move least, or most; in ascending order.
    [[nodiscard]] std::vector<std::size_t> frames_by_speed(bool fastest) const {
        const std::size_t count =
            fastest ? 16 : std::clamp<std::size_t>(wanted_.size() / 6, 12, 60);
        std::vector<std::pair<double, std::size_t>> frames;
        for (std::size_t frame = 0; frame < wanted_.size(); ++frame) {
            double sum = 0.0;
            std::size_t seen = 0;
            for (const UsedRow& used : used_)
                if (const double v = speed(frame, used.row); !std::isnan(v)) {
                    sum += v * v;
                    ++seen;
                }
            if (2 * seen > used_.size())
                frames.emplace_back((fastest ? -sum : sum) / double(seen), frame);
        }
        std::ranges::sort(frames);
        frames.resize(std::min(count, frames.size()));
        std::vector<std::size_t> chosen;
        for (const auto& [size, frame] : frames)
            chosen.push_back(frame);
        std::ranges::sort(chosen);
        return chosen;
    }

    void make_profiles(const std::vector<std::size_t>& frames, const std::vector<BandImage>& rows) {
        profiles_.assign(track_.heights.places.size(), StemProfile(profile_reach()));
        for (std::size_t i = 0; i < frames.size(); ++i)
            for (std::size_t u = 0; u < used_.size(); ++u)
                if (const double axis = track_.rows.at(frames[i], used_[u].row); !std::isnan(axis))
                    profiles_[used_[u].height].add(pixels(rows[i], u), axis);
        known_.clear();
        for (StemProfile& profile : profiles_)
            known_.push_back(profile.close() ? 1 : 0);
    }

    [[nodiscard]] std::optional<RowMatch> matched(std::size_t frame, std::size_t u,
                                                  const BandImage& rows, double exposure) const {
        const double axis = track_.rows.at(frame, used_[u].row);
        const double smear = exposure > 0.0 ? exposure * speed(frame, used_[u].row) : 0.0;
        if (std::isnan(axis) || std::isnan(smear) || known_[used_[u].height] == 0)
            return std::nullopt;
        return match_row(profiles_[used_[u].height], pixels(rows, u), axis, smear,
                         track_.survey.noise);
    }

    void match(const std::vector<std::size_t>& frames, const std::vector<BandImage>& rows) {
        for (std::size_t i = 0; i < frames.size(); ++i)
            match(frames[i], rows[i]);
    }
    void match(std::size_t frame, const BandImage& rows) {
        for (std::size_t u = 0; u < used_.size(); ++u) {
            const std::size_t at = frame * track_.rows.places.size() + used_[u].row;
            const std::optional<RowMatch> found = matched(frame, u, rows, exposure_);
            if (known_[used_[u].height] == 0)
                continue; // the first pass has to do
            track_.rows.columns[at] = found ? found->axis : no_match;
            track_.rows.uncertainties[at] =
                found ? track_.survey.noise * std::sqrt(found->variance) : no_match;
        }
    }

    /// By the smear of the fastest frames, in frames: where it explains them clearly better than
    /// none (six standard deviations of the noise) and lies within the time of a frame.
    [[nodiscard]] std::optional<double> exposure_seen() const {
        const std::vector<std::size_t> fast = frames_by_speed(true);
        const std::vector<BandImage> rows = pictures(fast);
        const auto squares = [&](double exposure) {
            double sum = 0.0;
            for (std::size_t i = 0; i < fast.size(); ++i)
                for (std::size_t u = 0; u < used_.size(); ++u)
                    if (const auto found = matched(fast[i], u, rows[i], exposure))
                        sum += found->squares;
                    else if (const auto none = matched(fast[i], u, rows[i], 0.0))
                        sum += none->squares;
            return sum;
        };
        constexpr int bits = 12;
        const auto [exposure, least] =
            boost::math::tools::brent_find_minima(squares, 0.0, 1.0, bits);
        const double gain = (squares(0.0) - least) / std::pow(track_.survey.noise, 2);
        if (gain < 36.0 || exposure > 0.99)
            return std::nullopt;
        return exposure;
    }

    Track& track_;
    const FrameSource& source_;
    const std::vector<std::size_t>& wanted_;
    int threads_;
    std::vector<UsedRow> used_;
    std::vector<std::vector<float>> ground_; ///< (used rows, columns); empty: not known yet
    std::vector<StemProfile> profiles_;
    std::vector<char> known_;
    const AxisRecord* speeds_of_ = &track_.rows;
    double exposure_ = 0.0; ///< frames
};

} // namespace

std::optional<double> match_rows(Track& track, const FrameSource& source,
                                 const std::vector<std::size_t>& wanted, int threads) {
    return RowMatcher(track, source, wanted, threads).run();
}

} // namespace culm::measure
