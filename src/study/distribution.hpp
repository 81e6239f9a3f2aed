// SPDX-License-Identifier: BSD-3-Clause
// Truncated distributions that factors are drawn from, by their inverse distribution functions.
#pragma once

#include <span>
#include <string>
#include <vector>

namespace culm::study {

enum class DistributionKind { Uniform, LogUniform, Normal, Lognormal, Empirical };

/// A distribution confined to [min, max]. Values are in SI, as the factor's.
class Distribution {
  public:
    /// Equal density between min and max.
    [[nodiscard]] static Distribution uniform(double min, double max);
    /// Equal density of the logarithm between min and max; both positive.
    [[nodiscard]] static Distribution log_uniform(double min, double max);
    /// Normal with mean and sd BEFORE it is confined to [min, max].
    [[nodiscard]] static Distribution normal(double mean, double sd, double min, double max);
    /// Lognormal; mean > 0 and sd are those of the quantity itself (not of its logarithm), before
    /// it is confined to [min, max], min >= 0: σ² = ln(1 + sd²/mean²), μ = ln mean − σ²/2.
    [[nodiscard]] static Distribution lognormal(double mean, double sd, double min, double max);

    /// Each of the measured values with equal probability. `u` selects them in the order given:
    /// ascending values make an inverse distribution function, rows of a table keep what belongs
    /// together. At least one value.
    [[nodiscard]] static Distribution empirical(std::vector<double> values);

    /// The value below which the fraction u of the (confined) distribution lies, 0 < u < 1; always
    /// in [min, max] and increasing in u (but for empirical values in another order).
    [[nodiscard]] double quantile(double u) const;

    /// How much of the unconfined distribution lies between min and max; 1 for the uniform ones.
    [[nodiscard]] double kept_probability() const { return high_tail_ - low_tail_; }

    [[nodiscard]] DistributionKind kind() const { return kind_; }
    [[nodiscard]] double mean() const { return mean_; } ///< of the normal and lognormal
    [[nodiscard]] double sd() const { return sd_; }     ///< of the normal and lognormal
    [[nodiscard]] double min() const { return min_; }
    [[nodiscard]] double max() const { return max_; }
    [[nodiscard]] std::span<const double> values() const { return values_; } ///< of the empirical

  private:
    Distribution(DistributionKind kind, double min, double max);
    void set_normal_core(double location, double scale, double low, double high);

    DistributionKind kind_;
    double min_;
    double max_;
    double mean_ = 0.0;
    double sd_ = 0.0;
    double location_ = 0.0; ///< mean of the underlying normal
    double scale_ = 0.0;    ///< its standard deviation
    double low_tail_ = 0.0; ///< its distribution function at the lower end (mirrored: upper end)
    double high_tail_ = 1.0;
    bool mirrored_ = false; ///< computed from the other tail, where it is accurate
    std::vector<double> values_;
};

/// "uniform", "log-uniform", "normal", "lognormal", "empirical".
[[nodiscard]] const char* to_string(DistributionKind kind);

} // namespace culm::study
