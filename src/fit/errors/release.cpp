// SPDX-License-Identifier: BSD-3-Clause
#include "fit/errors/terms.hpp"
#include "fit/linear/scaled_solve.hpp"
#include "run/modes.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include <boost/math/special_functions/gamma.hpp>
#include <fmt/core.h>

namespace culm::fit {
namespace {

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
    std::vector<run::ShapedMode> modes = run::shaped_modes(computed_case(fit.model), most);
    const double rate =
        static_cast<double>(fit.times.size() - 1) / (fit.times.back() - fit.times.front());
    std::erase_if(modes, [rate](const run::ShapedMode& shaped) {
        return shaped.mode.frequency > resolved_share * rate;
    });
    return modes;
}

/// The readings of a mode that has the amplitude `size` (m at the tip), or the velocity `size`
/// times its angular frequency, at the time `start`.
ErrorTerm term_of(const run::ShapedMode& shaped, std::size_t number, bool is_velocity, double size,
                  double start, const measure::Measurement& measurement) {
    ErrorTerm term;
    term.kind = ErrorKind::Release;
    term.id = fmt::format("{} of mode {} at the release of {}",
                          is_velocity ? "velocity" : "amplitude", number, measurement.stem.id);
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
std::vector<ErrorTerm> terms_of(const std::vector<run::ShapedMode>& modes,
                                const std::vector<double>& sizes, double start,
                                const measure::Measurement& measurement) {
    std::vector<ErrorTerm> terms;
    for (std::size_t k = 1; k < modes.size(); ++k)
        for (const bool is_velocity : {false, true})
            terms.push_back(term_of(modes[k], k + 1, is_velocity, sizes[k], start, measurement));
    return terms;
}

/// Scale of the departures, m at the tip, from the readings soon after the release in a fit with
/// all other parameters and error terms; 0 if they show none.
double scale_of(const Fit& fit, const std::vector<ErrorTerm>& units,
                const ObservedRecording& recording) {
    const RecordingFit& part = fit.parts.front();
    const auto from = std::ranges::find_if(part.times, [](double time) { return time >= 0.0; });
    const double end = early_periods / run::first_mode(part.model.spec).frequency;
    const std::size_t rows = part.prediction.rows;
    std::vector<Eigen::Index> places;
    for (auto i = static_cast<std::size_t>(from - part.times.begin());
         i < part.times.size() && part.times[i] < end; ++i)
        for (std::size_t j = 0; j < rows; ++j)
            if (!std::isnan(part.residuals[i * rows + j]))
                places.push_back(static_cast<Eigen::Index>(i * rows + j));
    const WeightedSystem& system = fit.system;
    const auto wanted = static_cast<Eigen::Index>(units.size());
    if (static_cast<Eigen::Index>(places.size()) < 4 * (system.jacobian.cols() + wanted))
        return 0.0;
    for (Eigen::Index row = system.readings(); row < system.residual.size(); ++row)
        places.push_back(row); // the constraints
    Eigen::MatrixXd columns(system.residual.size(), system.jacobian.cols() + wanted);
    columns.leftCols(system.jacobian.cols()) = system.jacobian;
    for (Eigen::Index k = 0; k < system.jacobian.cols(); ++k)
        if (system.errors[static_cast<std::size_t>(k)] == ErrorKind::SecondMode)
            columns.col(k).setZero(); // it explains the departures, too
    columns.rightCols(wanted).setZero();
    for (Eigen::Index k = 0; k < wanted; ++k)
        columns.col(system.jacobian.cols() + k).head(system.readings()) =
            weighted_term(units[static_cast<std::size_t>(k)],
                          {part.model, recording, part.prediction, part.noise, part.terms});
    const Eigen::MatrixXd seen = columns(places, Eigen::all);
    const ScaledSpectrum information(seen.transpose() * seen);
    const Eigen::VectorXd found =
        information.solve(seen.transpose() * system.residual(places)).col(0).tail(wanted);
    const Eigen::MatrixXd own = information.inverse().bottomRightCorner(wanted, wanted);
    const double square = found.dot(ScaledSpectrum(own).solve(found).col(0));
    if (!(boost::math::gamma_q(0.5 * static_cast<double>(wanted), 0.5 * square) < departure_level))
        return 0.0;
    // The mean square of the departures is that of the estimates less their errors'.
    const double mean = (found.squaredNorm() - own.trace()) / static_cast<double>(wanted);
    return std::sqrt(std::max(mean, 0.0));
}

} // namespace

std::vector<ErrorTerm> release_terms(const Fit& fit, const ObservedRecording& recording) {
    const RecordingFit& part = fit.parts.front();
    const std::vector<run::ShapedMode> modes = resolved_modes(part);
    if (modes.size() < 2 || recording.release == measure::ReleaseKind::Moving)
        return {};
    // Tip deflection and release time already fit amplitude and phase of the first mode.
    const double pull = std::abs(part.model.spec.tip_deflection);
    const double start = part.model.release_time;
    const double scale =
        scale_of(fit, terms_of(modes, std::vector(modes.size(), 1.0), start, recording), recording);
    if (!(scale > 0.0))
        return {};
    // A hand that holds the stem a tenth of its length below the tip changes the amplitude of the
    // second mode by half. Larger departures are not due to the release.
    std::vector<double> sizes;
    sizes.reserve(modes.size());
    for (const run::ShapedMode& shaped : modes)
        sizes.push_back(std::min(scale, largest_share * pull * shaped.pull_share));
    return terms_of(modes, sizes, start, recording);
}

} // namespace culm::fit
