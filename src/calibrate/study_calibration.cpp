// SPDX-License-Identifier: BSD-3-Clause
#include "calibrate/study_calibration.hpp"

#include "core/error.hpp"
#include "fit/chain/stem_chain.hpp"

#include <cmath>
#include <utility>

#include <fmt/format.h>

namespace culm::calibrate {
namespace {

/// Length of the beam that a chain represents: a whole sphere at the tip adds half a bond length to
/// a chain that ends at its centre. (A mass there and a longer beam lower the
/// frequency alike, each by 4 l/(2L) of its square.)
double beam_length(const run::CaseSpec& spec) {
    return spec.stem.free_length() + (spec.stem.tip_mass_share - 0.5) * spec.stem.bond_length;
}

/// The regressions are valid for one stem: b2 scales as √(EI/m')/L², b1 with β and the bond length.
std::vector<std::string> differences(const run::CaseSpec& measured, const run::CaseSpec& study) {
    std::vector<std::string> texts;
    // A relative difference of more than `tolerance` is reported. For length, section and mass such
    // a difference changes Y by 0.4 %, while a larger deflection changes b1 and b2 little.
    const auto compare = [&](const char* name, const char* unit, double scale, double tolerance,
                             const auto& get) {
        const double here = scale * get(measured);
        const double there = scale * get(study);
        if (std::abs(here / there - 1.0) > tolerance)
            texts.push_back(fmt::format("{} {:.4g} {} against {:.4g}", name, here, unit, there));
    };
    compare("length", "mm", 1e3, 1e-3, beam_length);
    compare("section's second moment", "mm^4", 1e12, 4e-3,
            [](const auto& spec) { return spec.stem.second_moment_of_area(); });
    compare("mass per length", "g/m", 1e3, 4e-3,
            [](const auto& spec) { return spec.stem.sphere_mass() / spec.stem.bond_length; });
    compare("tip deflection", "mm", 1e3, 0.5, std::mem_fn(&run::CaseSpec::tip_deflection));
    if (measured.stem.sphere_count != study.stem.sphere_count)
        texts.push_back(fmt::format("{} spheres against {} (beta goes with their square)",
                                    measured.stem.sphere_count, study.stem.sphere_count));
    return texts;
}

void warn_outside(const char* name, double value, const core::Interval& range, const char* unit,
                  std::vector<std::string>& warnings) {
    if (!range.contains(value))
        warnings.push_back(fmt::format("{} = {:.4g}{} lies outside what the study covers, {:.4g} … "
                                       "{:.4g}: the regression is EXTRAPOLATED",
                                       name, value, unit, range.low, range.high));
}

/// Height and fit of the highest row that can be fitted over the window.
std::pair<double, reduce::RingDownFit> read_highest_row(const measure::Measurement& measurement,
                                                        double window) {
    reduce::RingDownOptions options{.is_measured = true};
    options.window = window;
    std::string reason = "there are no rows";
    // From the top down: the regressions are for the tip's deflection, which is closest to that of
    // the highest row.
    for (std::size_t j = measurement.heights.size(); j-- > 0;) {
        options.noise = measurement.noise_at(j);
        try {
            return {measurement.heights[j],
                    reduce::fit_ring_down(measurement.times, measurement.history(j), options)};
        } catch (const core::NumericalError& error) {
            reason = error.what();
        }
    }
    throw core::NumericalError(core::FailureKind::FitFailed,
                               fmt::format("{}: Eq. 1 cannot be fitted over the study's window of "
                                           "{:.4g} s: {}",
                                           measurement.stem.id, window, reason));
}

} // namespace

StudyCalibration calibrate_by_study(const measure::Measurement& measurement,
                                    const StudyForCalibration& study) {
    StudyCalibration result;
    result.window = study.window.value_or(study.base.duration);
    const auto [height, fit] = read_highest_row(measurement, result.window);
    result.height = height;
    const auto read = [](const reduce::Estimate& of) {
        return reduce::normal_estimate(of.value, of.standard_error);
    };
    result.reading = {read(fit.decay_per_cycle), read(fit.frequency)};
    result.prediction = reduce::predict_stem(study.regression, result.reading);

    warn_outside("b2", result.reading.frequency.value, study.regression.frequency, " Hz",
                 result.warnings);
    warn_outside("b1 per cycle", result.reading.decay_per_cycle.value,
                 study.regression.decay_per_cycle, "", result.warnings);
    if (const auto& modulus = result.prediction.bond_youngs_modulus.by_single_law)
        warn_outside("Y", modulus->value * 1e-9,
                     {study.bond_youngs_modulus.low * 1e-9, study.bond_youngs_modulus.high * 1e-9},
                     " GPa", result.warnings);
    if (const auto& damping = result.prediction.bond_damping.by_single_law)
        warn_outside("beta", damping->value, study.bond_damping, "", result.warnings);
    run::CaseSpec chain =
        fit::chain_of(measurement, {study.base.stem.sphere_count, study.base.law}).spec;
    chain.tip_deflection = fit.largest_deflection;
    if (const std::vector<std::string> texts = differences(chain, study.base); !texts.empty())
        result.warnings.push_back(fmt::format("the study {} is about ANOTHER STEM: {}; Y and beta "
                                              "by its regressions are not this stem's",
                                              study.name, fmt::join(texts, ", ")));
    if (!study.factors.empty())
        result.warnings.push_back(fmt::format("the study {} varies {} too, which its regressions "
                                              "average over",
                                              study.name, fmt::join(study.factors, ", ")));
    return result;
}

} // namespace culm::calibrate
