// SPDX-License-Identifier: BSD-3-Clause
// Refuses a processor that lacks the instructions which this binary was built with.
#pragma once

namespace culm::cli {

inline constexpr const char* unsuitable_processor_message =
    "culm: this binary was built for another processor (its vector instructions are missing here). "
    "Build it on this machine, or with a lower -DCULM_ARCHITECTURE=..., for example x86-64-v3.\n";

/// Whether this processor has the widest vector instructions that the compiler was allowed to use.
[[nodiscard]] inline bool processor_is_suitable() {
#if defined(__AVX512F__)
    return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
           __builtin_cpu_supports("avx512vl");
#elif defined(__AVX2__)
    return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
#else
    return true;
#endif
}

} // namespace culm::cli
