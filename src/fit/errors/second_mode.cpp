// SPDX-License-Identifier: BSD-3-Clause
#include "fit/chain/higher_modes.hpp"
#include "fit/errors/terms.hpp"
#include "run/case_model.hpp"
#include "run/modes.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <string>
#include <utility>

#include <Eigen/Core>

namespace culm::fit {
namespace {

using Complex = std::complex<double>;

/// Length of a term, over the noise, that no test of all readings notices.
constexpr double negligible_length = 0.3;
constexpr double log_loss_uncertainty = 0.405465108108164; // ln 1.5
constexpr double step = 1e-5; ///< of ln f₂ and ln δ₂, for central differences

/// E''/E' of the bonds at the angular frequency, with the branches of the case's effects.
double bond_loss_factor(const run::CaseSpec& spec, double omega) {
    double loss = 2.0 * run::first_mode(spec).damping_ratio();
    for (const physics::MaxwellBranch<double>& branch : run::case_model(spec).chain.branches) {
        const double phase = omega * branch.relaxation_time;
        loss += branch.relative_stiffness * phase / (1.0 + phase * phase);
    }
    return loss;
}

Complex rate_of(const integrate::VibrationMode& mode) {
    return {mode.decay_rate, 2.0 * std::numbers::pi * mode.frequency};
}

/// A second mode of this rate after a release at rest; (frames, heights), row-major.
Eigen::VectorXd second_mode(const run::ShapedMode& shaped, Complex rate, const RecordingFit& fit,
                            const measure::Measurement& measurement) {
    const Complex amplitude =
        shaped.pull_share * fit.model.spec.tip_deflection * Complex(1.0, rate.real() / rate.imag());
    const auto rows = static_cast<Eigen::Index>(shaped.reading.size());
    Eigen::VectorXd readings =
        Eigen::VectorXd::Zero(static_cast<Eigen::Index>(fit.times.size()) * rows);
    for (Eigen::Index k = 0; k < readings.size(); ++k) {
        const auto j = static_cast<std::size_t>(k % rows);
        const double since = fit.times[static_cast<std::size_t>(k / rows)] - fit.model.release_time;
        if (since >= 0.0)
            readings[k] = shaped.reading[j] * (amplitude * std::exp(rate * since) *
                                               std::pow(rate, measurement.time_derivatives_at(j)))
                                                  .real();
    }
    return readings;
}

/// The change of the readings by one standard uncertainty, between two rates that are 2 · `step`
/// apart in ln f₂ or ln δ₂.
ErrorTerm term_of(std::string name, const run::ShapedMode& shaped, Complex lower, Complex upper,
                  double uncertainty, const RecordingFit& fit,
                  const measure::Measurement& measurement) {
    const Eigen::VectorXd change = uncertainty / (2.0 * step) *
                                   (second_mode(shaped, upper, fit, measurement) -
                                    second_mode(shaped, lower, fit, measurement));
    return {ErrorKind::SecondMode, std::move(name), {change.begin(), change.end()}};
}

/// Length of the term's readings over the noise.
double length_over_noise(const ErrorTerm& term, std::span<const double> noise) {
    double sum = 0.0;
    for (std::size_t at = 0; at < term.readings.size(); ++at)
        sum += std::pow(term.readings[at] / noise[at % noise.size()], 2);
    return std::sqrt(sum);
}

} // namespace

std::vector<ErrorTerm> second_mode_terms(const RecordingFit& fit,
                                         const measure::Measurement& measurement) {
    const run::CaseSpec computed = computed_case(fit.model);
    // After an unrecorded release they are parameters (fit/chain/higher_modes.hpp).
    if (computed.tip_deflection == 0.0 || computed.release == run::Release::FirstMode)
        return {};
    const std::vector<run::ShapedMode> modes = run::shaped_modes(computed, 2);
    if (modes.size() < 2)
        return {};
    const run::ShapedMode& second = modes.back();
    const Complex rate = rate_of(second.mode);
    const double first = rate_of(modes.front().mode).imag();
    const double log_frequency = log_frequency_uncertainty(
        bond_loss_factor(computed, first), rate.imag() / first, computed.stem.sphere_count);
    const std::string owner = " of mode 2 of " + measurement.specimen_name();
    const double decay = rate.real();
    const auto faster = [&](double factor) { return Complex(decay, factor * rate.imag()); };
    const auto softer = [&](double factor) { // the natural frequency stays
        return Complex(factor * decay, std::sqrt(std::norm(rate) - std::pow(factor * decay, 2)));
    };
    std::vector<ErrorTerm> terms{term_of("frequency" + owner, second, faster(1.0 - step),
                                         faster(1.0 + step), log_frequency, fit, measurement),
                                 term_of("loss" + owner, second, softer(1.0 - step),
                                         softer(1.0 + step), log_loss_uncertainty, fit,
                                         measurement)};
    std::erase_if(terms, [&](const ErrorTerm& term) {
        return !(length_over_noise(term, fit.noise) >=
                 negligible_length); // or the chain is unstable
    });
    return terms;
}

} // namespace culm::fit
