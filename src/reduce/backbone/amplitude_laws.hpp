// SPDX-License-Identifier: BSD-3-Clause
// How damping and frequency of a mode depend on its amplitude, also in the terms of simulators.
//
//     ζ(A) = c/A + ζ0 + ζ1 A^p,     f(A) = f0 (1 − ε A^q).
//
// The P–Q form is the relative decrement per cycle P + Q A of the same points.
//
// c/A is Coulomb friction (a loss ~ A), ζ0 a linear loss (~ A²), ζ1 A^p one that grows faster
// (p = 1: quadratic drag). For a fixed power the laws are linear in the other numbers, so the power
// is scanned. Of the laws with some of the terms the one with the smallest χ² + k log n is taken,
// χ² scaled to the scatter about the best law.
//
// Traps. Windows that overlap by half are not independent: their errors are enlarged by √2. Over
// a range of amplitudes of 2:1 the powers 2/3 and 1 are hardly distinguishable; the interval says
// so.
#pragma once

#include "reduce/distributions.hpp"

#include <optional>
#include <span>
#include <string>

namespace culm::reduce {

struct BackbonePoint {
    double amplitude = 0.0;
    double damping_ratio = 0.0;
    double damping_error = 0.0; ///< standard error
    double frequency = 0.0;     ///< Hz
    double frequency_error = 0.0;
    double time = 0.0; ///< middle of its window, s
};

template <class To>
void describe(To& to, const BackbonePoint& point) {
    to("time_s", point.time);
    to("amplitude_mm", point.amplitude);
    to("damping_ratio", point.damping_ratio);
    to("damping_ratio_stderr", point.damping_error);
    to("frequency_hz", point.frequency);
    to("frequency_stderr_hz", point.frequency_error);
}

/// The laws of one mode; amplitudes are relative to `reference`. A term that is absent is empty.
struct AmplitudeLaws {
    double reference = 1.0;          ///< largest amplitude, in its unit
    std::optional<Estimate> coulomb; ///< c over the reference
    std::optional<Estimate> linear;  ///< ζ0
    std::optional<Estimate> power;   ///< ζ1 times the reference^p
    std::optional<Estimate> power_exponent;
    Estimate decrement;                ///< P
    Estimate quadratic_decrement;      ///< Q times the reference
    Estimate frequency;                ///< f0, Hz
    std::optional<Estimate> softening; ///< ε times the reference^q
    std::optional<Estimate> softening_exponent;

    [[nodiscard]] double damping_at(double amplitude) const;
    [[nodiscard]] double frequency_at(double amplitude) const;
};

template <class To>
void describe(To& to, const AmplitudeLaws& laws) {
    to("reference_amplitude_mm", laws.reference);
    to("coulomb", laws.coulomb);
    to("linear", laws.linear);
    to("power", laws.power);
    to("power_exponent", laws.power_exponent);
    to("decrement_p", laws.decrement);
    to("decrement_q", laws.quadratic_decrement);
    to("frequency_hz", laws.frequency);
    to("softening", laws.softening);
    to("softening_exponent", laws.softening_exponent);
}

/// Needs five points at least and a range of amplitudes of 1.2; empty otherwise.
[[nodiscard]] std::optional<AmplitudeLaws> amplitude_laws(std::span<const BackbonePoint> points);

/// Classes of effects by their signature; in the order of to_string().
enum class AmplitudeClass {
    Linear,    ///< neither depends on the amplitude
    Friction,  ///< the damping ratio falls with the amplitude
    Drag,      ///< the damping ratio grows, the frequency stays
    EdgesSlip, ///< the damping ratio grows and the frequency falls
    Stiffness, ///< the frequency changes, the damping ratio stays
    Beat       ///< the amplitude grows in between, or the frequency goes up and down
};
/// "linear", "friction", "drag", "edges or slip", "stiffness", "beat".
[[nodiscard]] std::string to_string(AmplitudeClass of);
/// One sentence: which effects have such a signature.
[[nodiscard]] std::string sentence(AmplitudeClass of);

/// The class of the points with these laws. `negligible_shift`: relative change of the frequency
/// that the geometry of a large swing explains.
[[nodiscard]] AmplitudeClass amplitude_class(std::span<const BackbonePoint> points,
                                             const AmplitudeLaws& laws, double negligible_shift);

} // namespace culm::reduce
