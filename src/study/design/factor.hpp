// SPDX-License-Identifier: BSD-3-Clause
// A factor of a design: levels, or a distribution that its values are drawn from.
#pragma once

#include "study/config/parameters.hpp"

#include <algorithm>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace culm::study {

enum class DistributionKind { Uniform, LogUniform, Normal, Lognormal, Empirical };

/// A distribution confined to [min, max]. Values are in SI, as the factor's.
class Distribution {
  public:
    /// Equal density between min and max.
    [[nodiscard]] static Distribution uniform(double min, double max) {
        return {DistributionKind::Uniform, min, max};
    }
    /// Equal density of the logarithm between min and max; both positive.
    [[nodiscard]] static Distribution log_uniform(double min, double max) {
        return {DistributionKind::LogUniform, min, max};
    }
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
    /// in [min, max] and increasing in u (except for empirical values in another order).
    [[nodiscard]] double quantile(double u) const;

    /// Probability of [min, max] in the unconfined distribution; 1 for the uniform ones.
    [[nodiscard]] double kept_probability() const { return high_tail_ - low_tail_; }

    [[nodiscard]] DistributionKind kind() const { return kind_; }
    [[nodiscard]] double mean() const { return mean_; } ///< of the normal and lognormal
    [[nodiscard]] double sd() const { return sd_; }     ///< of the normal and lognormal
    [[nodiscard]] double min() const { return min_; }
    [[nodiscard]] double max() const { return max_; }
    [[nodiscard]] std::span<const double> values() const { return values_; } ///< of the empirical

  private:
    Distribution(DistributionKind kind, double min, double max)
        : kind_(kind), min_(min), max_(max) {}
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

/// The levels of a list or a stepped range, in SI, in the order of the config. In a design of type
/// `list` from [[design.point]]: the value at each point.
using Levels = std::vector<double>;

/// Normal scatter of the tests of one stem about the stem's own value, confined to [min, max]; SI.
struct WithinStemScatter {
    double sd = 0.0;
    double min = 0.0;
    double max = 0.0;
};

/// Source of the values of an empirical distribution.
struct MeasuredColumn {
    std::string file;   ///< as written in the study
    std::string column; ///< its header
    bool keeps_rows = false;
};

struct Factor {
    const Parameter* parameter = nullptr;
    std::variant<Levels, Distribution> values;
    /// Does every replicate draw a new value? True for distributions; false for lists and ranges,
    /// whose values belong to the design point.
    bool is_redrawn = false;
    /// Drawn for every test of a stem, or once for the stem?
    bool is_per_test = false;
    std::optional<WithinStemScatter> within_stem = {};
    std::optional<MeasuredColumn> measured = {}; ///< of an empirical distribution

    /// Maps 0 < u < 1 to a value in SI: levels are equally probable, distributions are inverted.
    [[nodiscard]] double quantile(double u) const {
        if (const auto* distribution = std::get_if<Distribution>(&values))
            return distribution->quantile(u);
        const auto& levels = std::get<Levels>(values);
        const auto count = static_cast<double>(levels.size());
        return levels[std::min(static_cast<std::size_t>(u * count), levels.size() - 1)];
    }

    /// The name of the coordinate of the unit cube that selects the value. Columns whose rows stay
    /// together share the coordinate of their file.
    [[nodiscard]] std::string_view coordinate() const {
        return measured && measured->keeps_rows ? std::string_view(measured->file) : parameter->key;
    }
};

} // namespace culm::study
