#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Measures everything that README.md and docs quote and writes it into the pages. Takes about 75
# minutes on two idle cores; only what the sources changed is measured again. With SECONDS it stops
# after that time (exit code 75), and the same command continues.
#
#   bench/publish.sh BUILD_FOLDER [SECONDS]
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
if [[ $# -lt 1 || $# -gt 2 ]]; then
    sed -n '7s/^# *//p' "${BASH_SOURCE[0]}" >&2
    exit 2
fi
cmake -S "$root" -B "$1" -G Ninja -DCULM_BUILD_BENCHMARKS=ON >/dev/null
cmake --build "$1" --target culm_benchmarks culm
/usr/bin/python3 "$root/bench/measure.py" "$1" ${2:+--seconds "$2"}
/usr/bin/python3 "$root/bench/publish.py"
