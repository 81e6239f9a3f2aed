// SPDX-License-Identifier: BSD-3-Clause
// Free parameters that several models share, and what readings determine of them.
#pragma once

#include "fit/chain/observed_recording.hpp"
#include "fit/chain/stem_model.hpp"

#include <cstddef>
#include <span>
#include <vector>

namespace culm::fit {

/// Has the parameter a value for each recording: tip deflection, release time, and those of effects
/// that belong to a recording?
[[nodiscard]] bool belongs_to_recording(const physics::ParameterId& parameter);

/// The free parameters of several models in one list: those of the first model, then the additional
/// ones of the others.
struct JointLayout {
    /// A free parameter of one of the models.
    struct Share {
        std::size_t place = 0; ///< in the joint list
        double factor = 1.0;   ///< the model's value over the joint one
    };
    /// The parameter that gives the joint value and its transformation.
    struct Owner {
        std::size_t model = 0;
        std::size_t parameter = 0; ///< among the model's free ones
    };

    std::vector<physics::ParameterId> ids;  ///< of the joint list
    std::vector<Owner> owners;              ///< (ids) the first model that has it
    std::vector<std::vector<Share>> shares; ///< (models)(free parameters)
};

/// Parameters of the same name are one, unless they belong to the recording. Damping is shared as
/// the material's time τ, M = E I (κ + τ κ̇): β depends on the chain and is that of the first model
/// times a factor (1 for equal chains). Recordings of the same id get the suffix ":2", …. A single
/// recording keeps its names.
[[nodiscard]] JointLayout joint_layout(std::span<const StemModel> models,
                                       std::span<const ObservedRecording> measurements);

/// The models with every shared parameter at its first owner's value and within the bounds of all
/// models. Throws core::NumericalError (FitFailed) if no value is within all bounds.
[[nodiscard]] std::vector<StemModel> reconciled(std::vector<StemModel> models,
                                                const JointLayout& layout);

} // namespace culm::fit
