// SPDX-License-Identifier: BSD-3-Clause
// The differences between SUNDIALS 6.4 (Debian 12) and 7.x (Debian 13), in one place.
#pragma once

#include "core/error.hpp"

#include <memory>
#include <type_traits>

#include <arkode/arkode.h>
#include <arkode/arkode_arkstep.h>
#include <sundials/sundials_config.h>
#include <sundials/sundials_context.h>
#include <sundials/sundials_types.h>
#if SUNDIALS_VERSION_MAJOR >= 7
#include <sunadaptcontroller/sunadaptcontroller_soderlind.h>
#endif

/// ARKODE's functions have one name for all of its steppers from 7.1 on.
#if SUNDIALS_VERSION_MAJOR > 7 || (SUNDIALS_VERSION_MAJOR == 7 && SUNDIALS_VERSION_MINOR >= 1)
#define CULM_ARKODE(function) ARKode##function
#else
#define CULM_ARKODE(function) ARKStep##function
#endif

namespace culm::integrate::sundials {

using Real = sunrealtype;
using Boolean = sunbooleantype;

template <auto Free>
struct Deleter {
    template <class T>
    void operator()(T* object) const {
        Free(object);
    }
};

/// A context of this process alone, freed after all objects that were created in it.
class Context {
  public:
    Context() {
#if SUNDIALS_VERSION_MAJOR >= 7
        const int flag = SUNContext_Create(SUN_COMM_NULL, &context_);
        // culm reports failures as exceptions; without this every rank would also write to stderr.
        if (flag == 0)
            SUNContext_ClearErrHandlers(context_);
#else
        const int flag = SUNContext_Create(nullptr, &context_);
#endif
        if (flag != 0)
            throw core::NumericalError(core::FailureKind::SolverFailed, "SUNDIALS gave no context");
    }
    ~Context() {
        SUNContext_Free(&context_);
    }
    Context(const Context&) = delete;
    Context& operator=(const Context&) = delete;
    [[nodiscard]] SUNContext get() const {
        return context_;
    }

  private:
    SUNContext context_ = nullptr;
};

/// Keeps ARKODE from writing to stderr; in 7.x the context already does.
inline int silence_arkode([[maybe_unused]] void* arkode) {
#if SUNDIALS_VERSION_MAJOR >= 7
    return 0;
#else
    return ARKStepSetErrHandlerFn(
        arkode, [](int, const char*, const char*, char*, void*) {}, nullptr);
#endif
}

/// The step control that ARKODE has by default up to 7.2, stated so that every version takes the
/// same steps: Söderlind's PID controller, a safety factor, and a bias of the estimated error.
class StepControl {
  public:
    StepControl() = default;
    explicit StepControl([[maybe_unused]] SUNContext context) {
#if SUNDIALS_VERSION_MAJOR >= 7
        controller_.reset(SUNAdaptController_PID(context));
        SUNAdaptController_SetParams_PID(controller_.get(), parameters[0], parameters[1],
                                         parameters[2]);
        SUNAdaptController_SetErrorBias(controller_.get(), error_bias);
#endif
    }

    /// Returns SUNDIALS' flag.
    [[nodiscard]] int attach_to(void* arkode) {
        if (const int flag = CULM_ARKODE(SetSafetyFactor)(arkode, safety_factor); flag < 0)
            return flag;
#if SUNDIALS_VERSION_MAJOR >= 7
        return CULM_ARKODE(SetAdaptController)(arkode, controller_.get());
#else
        constexpr int with_parameters = 0;
        constexpr int order_of_embedding = 0;
        Real values[] = {parameters[0], parameters[1], parameters[2]};
        const int flag = ARKStepSetAdaptivityMethod(arkode, ARK_ADAPT_PID, with_parameters,
                                                    order_of_embedding, values);
        return flag < 0 ? flag : ARKStepSetErrorBias(arkode, error_bias);
#endif
    }

  private:
    static constexpr Real parameters[] = {0.58, 0.21, 0.1};
    static constexpr Real safety_factor = 0.96;
    static constexpr Real error_bias = 1.5;
#if SUNDIALS_VERSION_MAJOR >= 7
    std::unique_ptr<std::remove_pointer_t<SUNAdaptController>, Deleter<SUNAdaptController_Destroy>>
        controller_;
#endif
};

} // namespace culm::integrate::sundials
