#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Measures everything that README.md and docs quote and writes it into the pages. Only what the
# sources changed is measured again; `measure.py BUILD --list` says what, and how long it takes. With
# SECONDS it stops after that time (exit code 75), and the same command continues.
# LIGGGHTS names the authors' program, CULM_OPTIONAL_DATA recordings that are not in the repository;
# what needs them is left out without them.
#
#   bench/publish.sh BUILD_FOLDER [SECONDS]
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
if [[ $# -lt 1 || $# -gt 2 ]]; then
    sed -n '9s/^# *//p' "${BASH_SOURCE[0]}" >&2
    exit 2
fi
cmake -S "$root" -B "$1" -G Ninja -DCULM_BUILD_BENCHMARKS=ON >/dev/null
cmake --build "$1" --target culm_benchmarks culm
/usr/bin/python3 "$root/bench/measure.py" "$1" ${2:+--seconds "$2"}
/usr/bin/python3 "$root/bench/publish.py"
