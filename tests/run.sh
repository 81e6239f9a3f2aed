#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Installs packages, builds everything and runs all tests; ends with ctest's summary and exit code.
#
#   tests/run.sh [CTEST OPTION...]    for example: tests/run.sh -R farm, tests/run.sh -L style
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

jobs/install-packages.sh build run figures report test
jobs/build.sh

# Open MPI refuses to start as root, the only user of many containers, without these two.
((EUID == 0)) && export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
# One test more than cores: some wait most of their time, for Slurm, a walltime or a killed rank.
exec ctest --preset release --parallel "$(($(nproc) + 1))" --no-tests=error "$@" </dev/null
