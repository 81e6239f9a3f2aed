// SPDX-License-Identifier: BSD-3-Clause
// The stem's position in a row, by matching its brightness profile. The profile is known from
// frames in which the stem hardly moves and is smeared by the motion during the exposure.
#include "core/order_statistics.hpp"
#include "measure/track/matched_row.hpp"
#include "measure/track/track.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include <boost/math/tools/minima.hpp>

namespace culm::measure {

namespace {

constexpr double no_match = std::numeric_limits<double>::quiet_NaN();
constexpr double beyond_edge = 4.0; // pixels: two standard deviations of a strong blur

/// A row of the picture that a height uses.
struct UsedRow {
    std::size_t row;
    std::size_t height;
};

class RowMatcher {
  public:
    RowMatcher(Track& track, const FrameSource& source, int threads)
        : track_(track), source_(source), threads_(threads), used_(used_rows(track)),
          held_(track.window.held_frames > 1 ? track.window.last_held + 1 : 0) {}

    std::optional<double> run() {
        find_ground();
        const std::vector<std::size_t> slow = slow_frames();
        const std::vector<BandImage> slow_rows = pictures(slow);
        // The first pass determines the axis to a tenth of a pixel, a profile to a hundredth.
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
        source_.for_each(
            track_.source_indices, threads_,
            [&](std::size_t i, const FrameImage& frame) { match(i, used_rows_of(frame)); });
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

    /// The ground is the mean of the used rows over the frames that do not show the stem there.
    /// Without it, the ground under the stem's edges would shift a reading. Pixels that are always
    /// hidden get the mean of their neighbours.
    void find_ground() {
        ground_ = mean_ground();
        // If a lamp flickers, this mean depends on the frames that show a pixel. It determines the
        // light of each frame; the mean of the residuals corrects the ground.
        const std::vector<std::vector<float>> rest = mean_ground();
        for (std::size_t u = 0; u < used_.size(); ++u)
            std::ranges::transform(ground_[u], rest[u], ground_[u].begin(), std::plus<>());
    }
    /// Mean of used_rows_of() over the frames.
    [[nodiscard]] std::vector<std::vector<float>> mean_ground() const {
        constexpr std::size_t frames_for_ground = 600;
        constexpr std::size_t at_once = 16;
        const std::size_t step = track_.rows.numbers.size() / frames_for_ground + 1;
        std::vector<std::size_t> frames;
        for (std::size_t frame = 0; frame < track_.rows.numbers.size(); frame += step)
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
                                  profile_reach() + std::abs(motion(some[i], used_[u].row).speed));
        }
        std::vector<std::vector<float>> mean;
        mean.reserve(ground.size());
        for (const GroundRow& row : ground)
            mean.push_back(row.mean(std::pow(track_.survey.noise, 2)));
        return mean;
    }
    [[nodiscard]] double profile_reach() const {
        return 0.5 * track_.survey.apparent_width + beyond_edge + 1.0;
    }

    /// The used rows, one below the other; the stem is brighter than the rest, which is about 0 if
    /// the ground is known.
    [[nodiscard]] BandImage used_rows_of(const FrameImage& frame) const {
        const StemView& view = track_.survey.view;
        const BandImage image = upright_band(frame, view.band, view.up);
        BandImage rows(image.width, static_cast<int>(used_.size()));
        for (std::size_t u = 0; u < used_.size(); ++u)
            for (int c = 0; c < image.width; ++c)
                rows.row(static_cast<int>(u))[c] =
                    static_cast<float>(view.sign) * image.row(static_cast<int>(used_[u].row))[c];
        if (ground_.empty())
            return rows;
        const float lamp = lamp_in(rows);
        for (std::size_t u = 0; u < used_.size(); ++u)
            for (int c = 0; c < image.width; ++c)
                rows.row(static_cast<int>(u))[c] -= lamp * ground_[u][std::size_t(c)];
        return rows;
    }
    /// Light of a frame relative to the ground: the median over the pixels, few of which the stem
    /// hides. 1 where the ground is nearly black.
    [[nodiscard]] float lamp_in(const BandImage& rows) const {
        const auto least = static_cast<float>(3.0 * track_.survey.noise);
        constexpr std::size_t fewest = 200;
        std::vector<float> lamps;
        for (std::size_t u = 0; u < used_.size(); ++u)
            for (int c = 0; c < rows.width; ++c)
                if (const float ground = ground_[u][std::size_t(c)]; std::abs(ground) > least)
                    lamps.push_back(rows.row(static_cast<int>(u))[c] / ground);
        if (lamps.size() < fewest)
            return 1.0F;
        return core::median(std::move(lamps));
    }
    [[nodiscard]] PixelRow pixels(const BandImage& rows, std::size_t u) const {
        const std::vector<std::uint8_t>& clutter = track_.survey.trace.clutter;
        const std::size_t begin = used_[u].row * std::size_t(rows.width);
        return {rows.row(static_cast<int>(u)), clutter.empty() ? nullptr : clutter.data() + begin,
                rows.width};
    }
    [[nodiscard]] std::vector<BandImage> pictures(const std::vector<std::size_t>& frames) const {
        std::vector<std::size_t> indices;
        indices.reserve(frames.size());
        for (const std::size_t frame : frames)
            indices.push_back(track_.source_indices[frame]);
        std::vector<BandImage> rows(frames.size());
        source_.for_each(indices, threads_, [&](std::size_t i, const FrameImage& frame) {
            rows[i] = used_rows_of(frame);
        });
        return rows;
    }

    /// Motion of a row's axis, pixels per frame and per frame².
    struct Motion {
        double speed;
        double acceleration;
    };

    /// From the two neighbours on either side. If these are missing or the release is between them,
    /// one neighbour gives a rough estimate: the acceleration jumps at the release, and one side
    /// does not determine a swing of a few frames.
    [[nodiscard]] Motion motion(std::size_t frame, std::size_t row) const {
        const AxisRecord& record = *speeds_of_;
        if (frame < held_) {
            const std::size_t earlier = frame - std::min<std::size_t>(frame, 2);
            const std::size_t later = frame + 2 < held_ ? frame + 2 : frame;
            return {earlier == later ? 0.0 : slope(earlier, later, row), 0.0};
        }
        const std::size_t before = frame - std::min<std::size_t>(frame, 1);
        const std::size_t after = std::min(frame + 1, record.numbers.size() - 1);
        const double near = slope(before, after, row);
        if ((held_ == 0 || frame > held_ + 1) && are_five_in_a_row(frame, row)) {
            const auto sum = [&](std::size_t k) {
                return record.at(frame - k, row) + record.at(frame + k, row);
            };
            return {(4.0 * near - slope(frame - 2, frame + 2, row)) / 3.0,
                    (16.0 * sum(1) - sum(2) - 30.0 * record.at(frame, row)) / 12.0};
        }
        if (before == frame || after == frame)
            return {near, 0.0};
        return {near, record.at(after, row) - 2.0 * record.at(frame, row) + record.at(before, row)};
    }

    [[nodiscard]] double slope(std::size_t begin, std::size_t end, std::size_t row) const {
        return (speeds_of_->at(end, row) - speeds_of_->at(begin, row)) /
               (speeds_of_->numbers[end] - speeds_of_->numbers[begin]);
    }

    /// Was the row seen in the two frames before and after, with none missing between them?
    [[nodiscard]] bool are_five_in_a_row(std::size_t frame, std::size_t row) const {
        const AxisRecord& record = *speeds_of_;
        if (frame < 2 || frame + 2 >= record.numbers.size() ||
            std::abs(record.numbers[frame + 2] - record.numbers[frame - 2] - 4.0) > 1e-6)
            return false;
        double sum = 0.0;
        for (std::size_t k = frame - 2; k <= frame + 2; ++k)
            sum += record.at(k, row);
        return !std::isnan(sum);
    }

    struct FrameMotion {
        double square = 0.0; ///< of the used rows' speed, mean, pixels²
        double place = 0.0;  ///< their mean, pixels
        std::size_t frame = 0;
    };
    /// Motion in the frames in which more than half of the used rows are seen, sorted by speed.
    [[nodiscard]] std::vector<FrameMotion> motions() const {
        std::vector<FrameMotion> frames;
        for (std::size_t frame = 0; frame < track_.rows.numbers.size(); ++frame) {
            FrameMotion of{0.0, 0.0, frame};
            double seen = 0.0;
            for (const UsedRow& used : used_)
                if (const double v = motion(frame, used.row).speed; !std::isnan(v)) {
                    of.square += v * v;
                    of.place += track_.rows.at(frame, used.row);
                    seen += 1.0;
                }
            if (2.0 * seen > double(used_.size()))
                frames.push_back({of.square / seen, of.place / seen, frame});
        }
        std::ranges::stable_sort(frames, {}, &FrameMotion::square);
        return frames;
    }

    [[nodiscard]] std::vector<std::size_t> fastest_frames() const {
        std::vector<std::size_t> chosen;
        for (const FrameMotion& of : motions())
            chosen.push_back(of.frame);
        const std::size_t most = 16;
        chosen.erase(chosen.begin(), chosen.end() - std::ptrdiff_t(std::min(most, chosen.size())));
        std::ranges::sort(chosen);
        return chosen;
    }

    /// The slowest frames, but few at one location: the profile must be sampled between the pixels,
    /// or swings smaller than a pixel are read 5 % too large.
    [[nodiscard]] std::vector<std::size_t> slow_frames() const {
        const std::size_t count = std::clamp<std::size_t>(track_.rows.numbers.size() / 6, 12, 60);
        constexpr double places_a_pixel = 8.0;
        std::map<long, std::size_t> taken;
        std::vector<std::size_t> chosen;
        for (const FrameMotion& of : motions())
            if (chosen.size() < count && ++taken[std::lround(places_a_pixel * of.place)] <= 2)
                chosen.push_back(of.frame);
        std::ranges::sort(chosen);
        return chosen;
    }

    void make_profiles(const std::vector<std::size_t>& frames, const std::vector<BandImage>& rows) {
        profiles_.assign(track_.heights.places.size(), StemProfile(profile_reach()));
        for (std::size_t i = 0; i < frames.size(); ++i)
            for (std::size_t u = 0; u < used_.size(); ++u)
                if (const double axis = track_.rows.at(frames[i], used_[u].row); !std::isnan(axis))
                    profiles_[used_[u].height].add(pixels(rows[i], u), axis);
        for (StemProfile& profile : profiles_)
            profile.close();
    }

    [[nodiscard]] std::optional<RowMatch> matched(std::size_t frame, std::size_t u,
                                                  const BandImage& rows, double exposure) const {
        const double axis = track_.rows.at(frame, used_[u].row);
        Path path;
        if (exposure > 0.0) {
            const Motion of = motion(frame, used_[u].row);
            path = {exposure * of.speed, 0.5 * exposure * exposure * of.acceleration};
        }
        if (std::isnan(axis) || std::isnan(path.length) || !profiles_[used_[u].height].is_known())
            return std::nullopt;
        return match_row(profiles_[used_[u].height], pixels(rows, u), axis, path,
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
            if (!profiles_[used_[u].height].is_known())
                continue; // keeps the first pass
            track_.rows.columns[at] = found ? found->axis : no_match;
            track_.rows.uncertainties[at] =
                found ? track_.survey.noise * std::sqrt(found->variance) : no_match;
        }
    }

    /// Exposure, in frames, from the smear of the fastest frames, if it explains them better than
    /// none by six standard deviations of the noise and is shorter than a frame.
    [[nodiscard]] std::optional<double> exposure_seen() const {
        const std::vector<std::size_t> fast = fastest_frames();
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
    int threads_;
    std::vector<UsedRow> used_;
    std::size_t held_;                       ///< frames before the release; 0: it was not seen
    std::vector<std::vector<float>> ground_; ///< (used rows, columns); empty: not known yet
    std::vector<StemProfile> profiles_;
    const AxisRecord* speeds_of_ = &track_.rows;
    double exposure_ = 0.0; ///< frames
};

} // namespace

std::optional<double> match_rows(Track& track, const FrameSource& source, int threads) {
    return RowMatcher(track, source, threads).run();
}

} // namespace culm::measure
