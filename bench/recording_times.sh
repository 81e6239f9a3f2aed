#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Wall times of culm calibrate (one process) and culm diagnose (two ranks, all effects) on the
# recordings of the repository, s; one run each.
#
#   bench/recording_times.sh BUILD_FOLDER
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
if [[ $# -ne 1 ]]; then
    sed -n '6s/^# *//p' "${BASH_SOURCE[0]}" >&2
    exit 2
fi
culm=$1/src/cli/culm
launch=(mpirun --oversubscribe -n 2)
if [[ $(id -u) -eq 0 ]]; then
    launch+=(--allow-run-as-root)
fi
# seconds COMMAND...
seconds() {
    local TIMEFORMAT=%R
    { time "$@" >/dev/null 2>&1 </dev/null; } 2>&1
}
printf '| recording | stems | calibrate, s | diagnose, s |\n|---|---:|---:|---:|\n'
for recording in "$root"/tests/data/{measurements/T1-null,hidden-effect/T?-*,lab-rig}; do
    stems=$(find "$recording" -name stem.toml | wc -l)
    printf '| %s | %d | %.1f | %.1f |\n' "$(basename "$recording")" "$stems" \
        "$(seconds "$culm" calibrate "$recording")" \
        "$(seconds "${launch[@]}" "$culm" diagnose "$recording")"
done
