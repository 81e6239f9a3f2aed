// SPDX-License-Identifier: BSD-3-Clause
// Commands whose work is done by a Python program of postprocess/.
#pragma once

#include <string>
#include <vector>

namespace culm::cli {

/// Replaces this process by `python3 share/culm/postprocess/NAME arguments...`; the variable
/// CULM_PYTHON names another Python. `needs` says in the error message what the program requires.
/// Throws core::StorageError if the program is missing or cannot be run.
[[noreturn]] void run_python_program(const std::string& name,
                                     const std::vector<std::string>& arguments,
                                     const std::string& needs);

} // namespace culm::cli
