// SPDX-License-Identifier: BSD-3-Clause
#include "calibrate/chain_fit.hpp"

#include "calibrate/joint_fit.hpp"

#include <algorithm>
#include <utility>

namespace culm::calibrate {
namespace {

ChainFit only_part(const StemModel& model, const measure::Measurement& measurement,
                   const JointOptions& options) {
    return std::move(fit_jointly({&model, 1}, {&measurement, 1}, options).parts.front());
}

} // namespace

const FittedParameter* ChainFit::find(const std::string& name) const {
    const auto found = std::ranges::find(parameters, name, &FittedParameter::name);
    return found == parameters.end() ? nullptr : &*found;
}

ChainFit fit_chain(const StemModel& model, const measure::Measurement& measurement,
                   const ChainFitOptions& options) {
    return only_part(model, measurement, {options, {}, {}, {}});
}

ChainFit fit_chain_with_held(const StemModel& model, const measure::Measurement& measurement,
                             const std::vector<bool>& is_held, const ChainFitOptions& options) {
    JointOptions held{options, {}, is_held, {}};
    held.chain.is_first_guess = false;
    return only_part(model, measurement, held);
}

StemModel started_from(StemModel model, const ChainFit& fit) {
    for (const FreeParameter& parameter : model.parameters)
        if (const FittedParameter* found = fit.find(parameter.access.name))
            parameter.access.set(model.spec, found->value);
    model.release_time = fit.model.release_time;
    return model;
}

} // namespace culm::calibrate
