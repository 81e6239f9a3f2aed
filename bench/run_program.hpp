// SPDX-License-Identifier: BSD-3-Clause
// The outermost frame of a measuring program: an error becomes a line on stderr and an exit code.
#pragma once

#include <cstdio>
#include <exception>

namespace culm::bench {

/// Runs `program`; the exit code is 0, or 1 if it threw.
template <class Program>
[[nodiscard]] int run_program(Program&& program) noexcept {
    try {
        program();
        return 0;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "%s\n", error.what());
    } catch (...) {
        std::fputs("stopped by something that is not a std::exception\n", stderr);
    }
    return 1;
}

} // namespace culm::bench
