// SPDX-License-Identifier: BSD-3-Clause
#include "study/design/factor.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <boost/math/distributions/normal.hpp>

namespace culm::study {

Distribution Distribution::normal(double mean, double sd, double min, double max) {
    Distribution result{DistributionKind::Normal, min, max};
    result.mean_ = mean;
    result.sd_ = sd;
    result.set_normal_core(mean, sd, min, max);
    return result;
}

Distribution Distribution::lognormal(double mean, double sd, double min, double max) {
    Distribution result{DistributionKind::Lognormal, min, max};
    result.mean_ = mean;
    result.sd_ = sd;
    // Moments of the quantity itself: the logarithm has the variance ln(1 + sd²/mean²) and the mean
    // ln(mean) − variance/2.
    const double variance = std::log1p(sd * sd / (mean * mean));
    const double low = min > 0.0 ? std::log(min) : -std::numeric_limits<double>::infinity();
    result.set_normal_core(std::log(mean) - 0.5 * variance, std::sqrt(variance), low,
                           std::log(max));
    return result;
}

Distribution Distribution::empirical(std::vector<double> values) {
    const auto [least, largest] = std::ranges::minmax(values);
    Distribution result{DistributionKind::Empirical, least, largest};
    result.values_ = std::move(values);
    return result;
}

void Distribution::set_normal_core(double location, double scale, double low, double high) {
    location_ = location;
    scale_ = scale;
    // Above the mean the distribution function is close to 1 and loses digits; its mirror image
    // does not.
    mirrored_ = low > location;
    const double a = (mirrored_ ? location - high : low - location) / scale;
    const double b = (mirrored_ ? location - low : high - location) / scale;
    const boost::math::normal standard;
    // Truncation: the quantile of u is that of the whole normal at F(a) + u (F(b) − F(a)).
    low_tail_ = std::isinf(a) ? 0.0 : boost::math::cdf(standard, a);
    high_tail_ = std::isinf(b) ? 1.0 : boost::math::cdf(standard, b);
}

double Distribution::quantile(double u) const {
    if (kind_ == DistributionKind::Uniform)
        return std::clamp(min_ + u * (max_ - min_), min_, max_);
    if (kind_ == DistributionKind::LogUniform)
        return std::clamp(min_ * std::exp(u * std::log(max_ / min_)), min_, max_);
    if (kind_ == DistributionKind::Empirical) {
        const auto place = static_cast<std::size_t>(u * static_cast<double>(values_.size()));
        return values_[std::min(place, values_.size() - 1)];
    }
    const double v = mirrored_ ? 1.0 - u : u;
    // Rounding may reach an end of (0, 1), where the quantile is infinite.
    const double p = std::clamp(low_tail_ + v * (high_tail_ - low_tail_),
                                std::numeric_limits<double>::min(), 1.0 - 0x1p-53);
    const double z = boost::math::quantile(boost::math::normal{}, p);
    const double core = location_ + scale_ * (mirrored_ ? -z : z);
    return std::clamp(kind_ == DistributionKind::Lognormal ? std::exp(core) : core, min_, max_);
}

const char* to_string(DistributionKind kind) {
    switch (kind) {
    case DistributionKind::Uniform:
        return "uniform";
    case DistributionKind::LogUniform:
        return "log-uniform";
    case DistributionKind::Normal:
        return "normal";
    case DistributionKind::Lognormal:
        return "lognormal";
    case DistributionKind::Empirical:
        return "empirical";
    }
    return "unknown";
}

} // namespace culm::study
