#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# The numbers of docs/reproduction.md: the published design under both laws, fitted over four
# windows with b0 free and fixed. Usage: jobs/reproduction.sh [CULM] [OUTPUT]
set -euo pipefail
top=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
culm=${1:-$top/build/release/src/cli/culm}
output=${2:-$top/results/reproduction}
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1

mkdir -p "$output"
for law in schramm2019 consistent; do
    mpirun "$culm" run "$top/config/reproduction-$law.toml" -o "$output/$law" --resume \
        >"$output/$law.log"
    for window in 0.01 0.088 0.1 0.2; do
        for amplitude in free fixed; do
            "$culm" reduce "$output/$law" --window $window --amplitude $amplitude --keep \
                --json "$output/$law-$window-$amplitude.json" > /dev/null
        done
    done
done
/usr/bin/python3 "$top/postprocess/reproduction_table.py" "$output"
