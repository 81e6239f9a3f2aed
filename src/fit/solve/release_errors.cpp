// SPDX-License-Identifier: BSD-3-Clause
#include "fit/solve/reading_errors.hpp"
#include "fit/solve/residual_statistics.hpp"
#include "run/modes.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include <Eigen/QR>
#include <boost/math/special_functions/gamma.hpp>
#include <fmt/core.h>

namespace culm::fit {
namespace {

using Term = ReadingErrors::Term;

constexpr std::size_t most_modes = 3;
/// Share of the frame rate above which modes are not resolved.
constexpr double resolved_share = 0.4;
/// Periods of the first mode after the release in which departures are visible. Later they have
/// decayed, and the effect of missing physics has grown.
constexpr double early_periods = 2.0;
/// Significance level: an exact release shows departures with this probability.
constexpr double departure_level = 1e-3;
constexpr double largest_share = 0.5; ///< of the amplitude that a pull at the tip gives a mode

/// The shapes of the modes that the recording resolves: at most one per height of a camera, whose
/// heights distinguish the modes. A sensor distinguishes them by their frequencies.
std::vector<run::ShapedMode> resolved_modes(const RecordingFit& fit) {
    const std::size_t most =
        fit.model.spec.sensors.empty() ? std::min(most_modes, fit.prediction.rows) : most_modes;
    std::vector<run::ShapedMode> modes = run::shaped_modes(case_beside_errors(fit.model), most);
    const double rate =
        static_cast<double>(fit.times.size() - 1) / (fit.times.back() - fit.times.front());
    std::erase_if(modes, [rate](const run::ShapedMode& shaped) {
        return shaped.mode.frequency > resolved_share * rate;
    });
    return modes;
}

/// The readings of a mode that has the amplitude `size` (m at the tip), or the velocity `size`
/// times its angular frequency, at the time `start`.
Term term_of(const run::ShapedMode& shaped, std::size_t number, bool is_velocity, double size,
             double start, const measure::Measurement& measurement) {
    Term term;
    term.is_in_every_model = measurement.release == measure::ReleaseKind::Moving;
    term.name =
        fmt::format("{} of mode {} at the {} of {}", is_velocity ? "velocity" : "amplitude", number,
                    measurement.release == measure::ReleaseKind::Moving ? "start" : "release",
                    measurement.stem.id);
    const std::complex<double> rate(shaped.mode.decay_rate,
                                    2.0 * std::numbers::pi * shaped.mode.frequency);
    for (const double time : measurement.times) {
        const double since = time - start;
        // Before the release a deflection is constant and a velocity has no effect.
        const std::complex<double> motion = (is_velocity ? std::complex<double>(0.0, -1.0) : 1.0) *
                                            (since < 0.0 ? 1.0 : std::exp(rate * since));
        for (std::size_t j = 0; j < shaped.reading.size(); ++j) {
            const int order = measurement.time_derivatives_at(j);
            const bool is_still = since < 0.0 && order > 0;
            term.readings.push_back(is_still ? 0.0
                                             : size * (motion * std::pow(rate, order)).real() *
                                                   shaped.reading[j]);
        }
    }
    return term;
}

/// The terms of all modes but the first, with their `sizes`, (modes).
std::vector<Term> terms_of(const std::vector<run::ShapedMode>& modes,
                           const std::vector<double>& sizes, double start,
                           const measure::Measurement& measurement) {
    std::vector<Term> terms;
    for (std::size_t k = 1; k < modes.size(); ++k)
        for (const bool is_velocity : {false, true})
            terms.push_back(term_of(modes[k], k + 1, is_velocity, sizes[k], start, measurement));
    return terms;
}

/// Scale of the departures, m at the tip, from the readings soon after the release in a fit with
/// all other parameters; 0 if they show none.
double scale_of(const RecordingFit& fit, const std::vector<Term>& units,
                const std::vector<Term>& others) {
    const auto from = std::ranges::find_if(fit.times, [](double time) { return time >= 0.0; });
    const double end = early_periods / run::first_mode(fit.model.spec).frequency;
    const Eigen::MatrixXd jacobian = whitened_jacobian(fit);
    const std::size_t rows = fit.prediction.rows;
    std::vector<Eigen::Index> places;
    for (auto i = static_cast<std::size_t>(from - fit.times.begin());
         i < fit.times.size() && fit.times[i] < end; ++i)
        for (std::size_t j = 0; j < rows; ++j)
            if (!std::isnan(fit.residuals[i * rows + j]))
                places.push_back(static_cast<Eigen::Index>(i * rows + j));
    const Eigen::Index fitted = jacobian.cols();
    const auto constrained = static_cast<Eigen::Index>(others.size());
    const auto wanted = static_cast<Eigen::Index>(units.size());
    if (static_cast<Eigen::Index>(places.size()) < 4 * (fitted + constrained + wanted))
        return 0.0;
    Eigen::MatrixXd columns(jacobian.rows(), fitted + constrained + wanted);
    columns.leftCols(fitted) = jacobian;
    Eigen::Index column = fitted;
    for (const std::vector<Term>* terms : {&others, &units})
        for (const Term& term : *terms)
            columns.col(column++) = whitened_term(term, fit, jacobian);
    const Eigen::MatrixXd residuals = whitened_residuals(fit).transpose(); // a row is a frame
    const Eigen::VectorXd right = residuals.reshaped();
    const LinearStep step =
        linear_step(columns(places, Eigen::all), right(places), fitted, constrained);
    const Eigen::VectorXd found = step.change.tail(wanted);
    const Eigen::MatrixXd own = step.covariance.bottomRightCorner(wanted, wanted);
    const double square = found.dot(own.completeOrthogonalDecomposition().solve(found));
    if (!(boost::math::gamma_q(0.5 * static_cast<double>(wanted), 0.5 * square) < departure_level))
        return 0.0;
    // The mean square of the departures is that of the estimates less their errors'.
    const double mean = (found.squaredNorm() - own.trace()) / static_cast<double>(wanted);
    return std::sqrt(std::max(mean, 0.0));
}

} // namespace

std::vector<Term> release_errors(const RecordingFit& fit, const measure::Measurement& measurement,
                                 const std::vector<Term>& others) {
    const std::vector<run::ShapedMode> modes = resolved_modes(fit);
    if (modes.size() < 2)
        return {};
    // Tip deflection and release time already fit amplitude and phase of the first mode.
    const double pull = std::abs(fit.model.spec.tip_deflection);
    if (measurement.release == measure::ReleaseKind::Moving)
        return terms_of(modes, std::vector(modes.size(), pull), 0.0, measurement);
    const double start = fit.model.release_time;
    const double scale =
        scale_of(fit, terms_of(modes, std::vector(modes.size(), 1.0), start, measurement), others);
    if (!(scale > 0.0))
        return {};
    // A hand that holds the stem a tenth of its length below the tip changes the amplitude of the
    // second mode by half. Larger departures are not due to the release.
    std::vector<double> sizes;
    sizes.reserve(modes.size());
    for (const run::ShapedMode& shaped : modes)
        sizes.push_back(std::min(scale, largest_share * pull * shaped.pull_share));
    return terms_of(modes, sizes, start, measurement);
}

} // namespace culm::fit
