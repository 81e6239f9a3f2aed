#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Configures and builds the release preset into build/release; ccache is used where it is installed.
#
#   jobs/build.sh [TARGET...]    default: everything
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

if command -v ccache >/dev/null; then
    export CMAKE_C_COMPILER_LAUNCHER=ccache CMAKE_CXX_COMPILER_LAUNCHER=ccache
fi
# The program alone needs no test framework: a first build of it leaves the tests out, because
# their packages need not be installed. A build of everything takes them in.
tests=()
if (($#)); then
    [[ -f build/release/CMakeCache.txt ]] || tests=(-D CULM_BUILD_TESTS=OFF)
else
    tests=(-D CULM_BUILD_TESTS=ON)
fi
cmake --preset release "${tests[@]}"
cmake --build --preset release ${1:+--target "$@"}
