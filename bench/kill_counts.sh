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
/usr/bin/python3 "$root/tests/faults/kill_study.py" --kills 100 --seed 7 | tail -n 2
/usr/bin/python3 "$root/tests/faults/kill_study.py" --kills 30 --seed 11 --method sundials | tail -n 2
/usr/bin/python3 "$root/tests/faults/kill_laboratory.py" \
    "$root/tests/data/hidden-effect/T2-quadratic_drag" --kills 30 --seed 7 | tail -n 2
/usr/bin/python3 "$root/tests/faults/soak.py" --minutes 1.5 --seed 1 | tail -n 3
