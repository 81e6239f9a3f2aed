#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Kills studies and laboratories at random and counts what was lost, which must be nothing.
#
#   bench/kill_counts.sh BUILD_FOLDER
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
if [[ $# -ne 1 ]]; then
    sed -n '5s/^# *//p' "${BASH_SOURCE[0]}" >&2
    exit 2
fi
export CULM_PROGRAM=$1/src/cli/culm CULM_MPIEXEC=${CULM_MPIEXEC:-mpirun}
# counted LABEL PROGRAM...: the label and the last line that the program prints.
counted() {
    local label=$1 printed
    shift
    printed=$(/usr/bin/python3 "$root/tests/faults/$1" "${@:2}")
    printf '%s: %s\n' "$label" "$(tail -n 1 <<<"$printed")"
}
counted 'Studies' kill_study.py --kills 50 --seed 7
counted 'Studies with SUNDIALS' kill_study.py --kills 15 --seed 11 --method sundials
counted 'Laboratories' kill_laboratory.py \
    "$root/tests/data/hidden-effect/T2-quadratic_drag" --kills 15 --seed 7
counted 'Random disturbances' soak.py --minutes 1 --seed 1
