// SPDX-License-Identifier: BSD-3-Clause
#include "fit/coarse_image.hpp"

#include "core/error.hpp"
#include "fit/start/starts.hpp"
#include "run/modes.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace culm::fit {
namespace {

constexpr int coarse_spheres = 16;
/// Chains with fewer bonds than this many times the coarse one's are not worth an image.
constexpr double worthwhile = 1.4;

bool is_fine(const RecordingFit& part) {
    const int spheres = part.model.spec.stem.sphere_count;
    return searched_spheres(spheres) < spheres;
}

void scale(const physics::ParameterId& id, double factor,
           std::vector<FittedParameter>& parameters) {
    for (FittedParameter& parameter : parameters)
        if (parameter.id == id) {
            parameter.value *= factor;
            parameter.standard_error *= factor;
        }
}

void scale_material(double modulus, double damping, std::vector<FittedParameter>& parameters) {
    scale(physics::bond_youngs_modulus, modulus, parameters);
    scale(physics::bond_damping, damping, parameters);
}

} // namespace

// Readings of the image are the measured ones shifted by the difference of the two chains at the
// present model: the coarse chain then has the residuals of the fine one, and its own
// discretisation error cancels to first order in the change of the model.
int searched_spheres(int spheres) {
    return spheres - 1 > worthwhile * (coarse_spheres - 1) ? coarse_spheres : spheres;
}

CoarseImage::CoarseImage(const Fit& fine, std::span<const ObservedRecording> recordings,
                         const FitOptions& options)
    : fine_(fine), fine_recordings_(recordings) {
    if (fine.failed() || !std::ranges::all_of(fine.parts, is_fine))
        return;
    for (std::size_t m = 0; m < recordings.size(); ++m)
        if (!can_move(fine.parts[m].model, recordings[m]))
            return;
    fit_ = fine;
    try {
        match_first_mode();
        for (std::size_t m = 0; m < recordings.size(); ++m)
            add_part(m, options.heartbeat);
    } catch (const core::NumericalError&) {
        recordings_.clear();
        modulus_ratio_ = 1.0;
        return;
    }
    damping_ratio_ = fit_.parts.front().model.spec.stem.bond_damping /
                     fine.parts.front().model.spec.stem.bond_damping;
    scale_material(modulus_ratio_, damping_ratio_, fit_.parameters);
}

/// Of the first recording; a material that is shared has one ratio.
void CoarseImage::match_first_mode() {
    const StemModel& fine = fine_.parts.front().model;
    StemModel coarse = fine;
    coarse.spec = with_spheres(std::move(coarse.spec), coarse_spheres);
    // with_spheres keeps the damping time of the stem. The first mode of a coarse chain still
    // decays a little differently, which keep_first_mode corrects.
    const double same_time = coarse.spec.stem.bond_damping;
    if (const auto modes = run::chain_modes(fine.spec, 1); !modes.empty())
        keep_first_mode(modes.front(), coarse);
    modulus_ratio_ = coarse.spec.stem.bond_youngs_modulus / fine.spec.stem.bond_youngs_modulus;
    decay_ratio_ = coarse.spec.stem.bond_damping / same_time;
}

void CoarseImage::add_part(std::size_t m, const run::Heartbeat& heartbeat) {
    RecordingFit& part = fit_.parts[m];
    physics::StemParameters<double>& stem = part.model.spec.stem;
    const double fine_damping = stem.bond_damping;
    part.model.spec = with_spheres(std::move(part.model.spec), coarse_spheres);
    stem.bond_youngs_modulus *= modulus_ratio_;
    stem.bond_damping *= decay_ratio_;
    scale_material(modulus_ratio_, stem.bond_damping / fine_damping, part.parameters);
    const std::vector<double>& fine = fine_.parts[m].prediction.readings;
    part.prediction = predict_readings(part.model, part.times, heartbeat);
    ObservedRecording shifted = fine_recordings_[m];
    for (std::size_t k = 0; k < fine.size(); ++k)
        // Both chains then have the same residuals at this model, so that a test or a fit on the
        // coarse one starts from the same misfit.
        if (const double shift = part.prediction.readings[k] - fine[k]; std::isfinite(shift))
            shifted.deflections[k] += shift;
    recordings_.push_back(std::move(shifted));
}

FitOptions CoarseImage::options(FitOptions options) const {
    if (is_coarser())
        options.chain.spheres = coarse_spheres;
    return options;
}

Fit CoarseImage::as_fine(Fit coarse) const {
    scale_material(1.0 / modulus_ratio_, 1.0 / damping_ratio_, coarse.parameters);
    return coarse;
}

Fit CoarseImage::as_coarse(Fit fine) const {
    scale_material(modulus_ratio_, damping_ratio_, fine.parameters);
    return fine;
}

} // namespace culm::fit
