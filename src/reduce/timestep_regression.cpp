// SPDX-License-Identifier: BSD-3-Clause
#include "reduce/timestep_regression.hpp"

#include "core/error.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace culm::reduce {

namespace {

/// One usable stem: β, Y in Pa, and u = τ/Δt.
struct Stem {
    double damping;
    double youngs_modulus;
    double limit;        ///< Δt, s
    double inverse_step; ///< u
};

std::vector<Stem> usable(const TimestepPoints& points) {
    const std::size_t count = points.limit.size();
    if (points.bond_youngs_modulus.size() != count || points.bond_damping.size() != count ||
        points.bond_time.size() != count)
        throw core::NumericalError(core::FailureKind::FitFailed,
                                   "the points' moduli, dampings, bond times and limits differ in "
                                   "number");
    std::vector<Stem> stems;
    for (std::size_t k = 0; k < count; ++k) {
        const Stem stem{points.bond_damping[k], points.bond_youngs_modulus[k], points.limit[k],
                        points.bond_time[k] / points.limit[k]};
        const bool is_usable = std::isfinite(stem.damping) && stem.damping >= 0.0 &&
                               std::isfinite(stem.youngs_modulus) && stem.youngs_modulus > 0.0 &&
                               stem.limit > 0.0 && std::isfinite(stem.inverse_step) &&
                               stem.inverse_step > 0.0;
        if (is_usable)
            stems.push_back(stem);
    }
    return stems;
}

/// `row(stem)` gives the regressors, `response(stem)` the right-hand side, and
/// `fitted(coefficients, stem)` the step of the law.
template <std::size_t N, class Row, class Response, class Fitted>
TimestepLawOutcome fit_law(const std::vector<Stem>& stems, const std::array<std::string, N>& names,
                           const Row& row, const Response& response, const Fitted& fitted) {
    Eigen::MatrixXd design(static_cast<Eigen::Index>(stems.size()), static_cast<Eigen::Index>(N));
    std::vector<double> responses;
    for (std::size_t k = 0; k < stems.size(); ++k) {
        const std::array<double, N> regressors = row(stems[k]);
        for (std::size_t c = 0; c < N; ++c)
            design(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(c)) = regressors[c];
        responses.push_back(response(stems[k]));
    }
    TimestepLawOutcome outcome;
    try {
        TimestepLaw law{regress(design, responses, names), {}, 0.0};
        for (const Stem& stem : stems) {
            law.residuals.push_back(stem.limit / fitted(law.regression.coefficients, stem) - 1.0);
            law.largest_residual = std::max(law.largest_residual, std::abs(law.residuals.back()));
        }
        outcome.law = std::move(law);
    } catch (const core::NumericalError& error) {
        outcome.reason = error.what();
    }
    return outcome;
}

using Coefficients = std::vector<Coefficient>;

double one(const Stem&) {
    return 1.0;
}

/// (τ/dt)² = A + B β (τ/dt), the limit of central differences for a damped oscillator, divided by
/// u² = (τ/dt)² so that every stem's error counts relative to its step: 1 = A/u² + B β/u.
TimestepLawOutcome fit_damped_oscillator(const std::vector<Stem>& stems) {
    return fit_law<2>(
        stems, {"A", "B"},
        [](const Stem& s) {
            return std::array{1.0 / (s.inverse_step * s.inverse_step), s.damping / s.inverse_step};
        },
        one,
        [](const Coefficients& c, const Stem& s) {
            const double linear = c[1].value * s.damping;
            const double u = 0.5 * (linear + std::sqrt(linear * linear + 4.0 * c[0].value));
            return s.limit * s.inverse_step / u;
        });
}

/// dt = τ/(a + b β), the form of the authors' rule, as 1 = a/u + b β/u.
TimestepLawOutcome fit_rule_form(const std::vector<Stem>& stems) {
    return fit_law<2>(
        stems, {"a", "b"},
        [](const Stem& s) {
            return std::array{1.0 / s.inverse_step, s.damping / s.inverse_step};
        },
        one,
        [](const Coefficients& c, const Stem& s) {
            return s.limit * s.inverse_step / (c[0].value + c[1].value * s.damping);
        });
}

/// ln dt = ln c + p ln Y + q ln β; undamped stems have no logarithm of β.
TimestepLawOutcome fit_power_law(std::vector<Stem> stems) {
    std::erase_if(stems, [](const Stem& stem) { return stem.damping <= 0.0; });
    return fit_law<3>(
        stems, {"ln_c", "p", "q"},
        [](const Stem& s) {
            return std::array{1.0, std::log(s.youngs_modulus), std::log(s.damping)};
        },
        [](const Stem& s) { return std::log(s.limit); },
        [](const Coefficients& c, const Stem& s) {
            return std::exp(c[0].value + c[1].value * std::log(s.youngs_modulus) +
                            c[2].value * std::log(s.damping));
        });
}

} // namespace

TimestepRegression regress_timesteps(const TimestepPoints& points) {
    const std::vector<Stem> stems = usable(points);
    TimestepRegression regression;
    regression.points_used = stems.size();
    regression.points_excluded = points.limit.size() - stems.size();
    regression.damped_oscillator = fit_damped_oscillator(stems);
    regression.rule_form = fit_rule_form(stems);
    regression.power_law = fit_power_law(stems);
    return regression;
}

} // namespace culm::reduce
