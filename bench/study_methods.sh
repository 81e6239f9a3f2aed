#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# The published design by RODAS5 and by SUNDIALS, in turn on two ranks: wall time with mpirun and
# archive, time in the map per point and per step, and ratios to RODAS5. Least of five rounds.
#
#   bench/study_methods.sh BUILD_FOLDER
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
if [[ $# -ne 1 ]]; then
    sed -n '6s/^# *//p' "${BASH_SOURCE[0]}" >&2
    exit 2
fi
scratch=$(mktemp -d "${TMPDIR:-/tmp}/culm-methods.XXXXXX")
trap 'rm -rf "$scratch"' EXIT
launch=(mpirun --oversubscribe -n 2)
if [[ $(id -u) -eq 0 ]]; then
    launch+=(--allow-run-as-root)
fi
cp "$root/config/schramm2019.toml" "$scratch/implicit.toml"
cp "$root/config/schramm2019-sundials.toml" "$scratch/arkode.toml"
for round in 1 2 3 4 5; do
    for method in implicit arkode; do
        rm -rf "$scratch/$method"
        /usr/bin/time -f "$method %e" -a -o "$scratch/wall" \
            "${launch[@]}" "$1/src/cli/culm" run "$scratch/$method.toml" -o "$scratch/$method" \
            --quiet </dev/null >/dev/null
        cp "$scratch/$method/summary.json" "$scratch/$method-$round.json"
    done
done
/usr/bin/python3 - "$scratch" <<'PYTHON'
import json, sys
from pathlib import Path
scratch = Path(sys.argv[1])
walls = [line.split() for line in (scratch / "wall").read_text().splitlines()]
print("| method | wall, s | in the map, ms a point | steps a point | µs a step | map / RODAS5 |\n"
      "|---|---:|---:|---:|---:|---:|")
first = None
for method in ("implicit", "arkode"):
    runs = [json.loads(path.read_text()) for path in scratch.glob(f"{method}-*.json")]
    points = runs[0]["points"]
    steps = runs[0]["integrator"]["work"]["steps"]
    seconds = 2 * min(run["wall_s"] for run in runs)  # of two ranks
    first = first or seconds
    wall = min(float(time) for name, time in walls if name == method)
    print(f"| {method} | {wall:.2f} | {1e3 * seconds / points:.1f} | {steps / points:.0f} "
          f"| {1e6 * seconds / steps:.1f} | {seconds / first:.1f} |")
PYTHON
