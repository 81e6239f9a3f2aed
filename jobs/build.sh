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
cmake --preset release
cmake --build --preset release ${1:+--target "$@"}
