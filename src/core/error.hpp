// SPDX-License-Identifier: BSD-3-Clause
// The kinds of failure of culm, with their exit codes.
#pragma once

#include <array>
#include <cstddef>
#include <stdexcept>
#include <string>

namespace culm::core {

/// Exit codes of every command (docs/cli.md).
enum class ExitCode : int {
    Done = 0,
    BadInput = 2,
    PointsFailed = 3,
    StoppedEarly = 75, ///< everything computed so far is kept; --resume continues
};

/// The user's input is wrong. The text names file, key or line, the value found and what is
/// allowed.
class InputError : public std::runtime_error {
  public:
    using std::runtime_error::runtime_error;
};

/// A file could not be written or read, or its content is damaged.
class StorageError : public std::runtime_error {
  public:
    using std::runtime_error::runtime_error;
};

/// Why the computation of one case failed; recorded with the point, never fatal to a study. The
/// order is that of the names in to_string().
enum class FailureKind {
    Instability,    ///< the explicit step is too large: the motion grew without bound
    NotANumber,     ///< a NaN or an infinity appeared
    StepLimit,      ///< the solver used up its steps
    SolverFailed,   ///< Newton iteration or error test failed repeatedly
    StaticFailed,   ///< no static equilibrium was found for the prescribed tip deflection
    FitFailed,      ///< Eq. 1 could not be fitted to the history
    UserExpression, ///< the value of a user's formula is not a number
};

/// Short stable name of a failure kind, as it is written to the archive.
[[nodiscard]] inline const char* to_string(FailureKind kind) {
    constexpr std::array names{"instability",   "not_a_number", "step_limit",     "solver_failed",
                               "static_failed", "fit_failed",   "user_expression"};
    return names[static_cast<std::size_t>(kind)];
}

/// A case could not be computed.
class NumericalError : public std::runtime_error {
  public:
    NumericalError(FailureKind kind, const std::string& text)
        : std::runtime_error(text), kind_(kind) {}
    [[nodiscard]] FailureKind kind() const { return kind_; }

  private:
    FailureKind kind_;
};

} // namespace culm::core
