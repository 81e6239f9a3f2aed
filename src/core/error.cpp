// SPDX-License-Identifier: BSD-3-Clause
#include "core/error.hpp"

namespace culm::core {

const char* to_string(FailureKind kind) {
    switch (kind) {
    case FailureKind::Instability:
        return "instability";
    case FailureKind::NotANumber:
        return "not_a_number";
    case FailureKind::StepLimit:
        return "step_limit";
    case FailureKind::SolverFailed:
        return "solver_failed";
    case FailureKind::StaticFailed:
        return "static_failed";
    case FailureKind::FitFailed:
        return "fit_failed";
    case FailureKind::UserExpression:
        return "user_expression";
    }
    return "unknown";
}

} // namespace culm::core
