#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Benches of farm and archive: trivial points per second, share of the archive in a study,
# efficiency of two ranks, cost of a point in the archive, efficiency predicted for many ranks.
#
#   bench/farm.sh BUILD_FOLDER [SCRATCH_FOLDER]
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
if [[ $# -lt 1 || $# -gt 2 ]]; then
    sed -n '6s/^# *//p' "${BASH_SOURCE[0]}" >&2
    exit 2
fi
programs=$1/bench
scratch=$(mktemp -d "${2:-${TMPDIR:-/tmp}}/culm-farm.XXXXXX")
trap 'rm -rf "$scratch"' EXIT
launch=(mpirun --oversubscribe -n 2)
if [[ $(id -u) -eq 0 ]]; then
    launch+=(--allow-run-as-root)
fi

printf 'load average at the start %s\n' "$(cut -d' ' -f1-3 /proc/loadavg)"
for what in scheduler archive shares efficiency; do
    "${launch[@]}" "$programs/bench_farm" "$what" "$scratch"
done
printf '\n## A point in the archive\n\n'
"$programs/bench_archive_throughput" "$scratch"
printf '\n## A study of a million points\n\n'
"$programs/bench_large_study" 1000000 "$scratch"
printf '\n## Fits of Eq. 1\n\n'
"$1/src/cli/culm" run "$root/config/schramm2019.toml" -o "$scratch/fits" --quiet >/dev/null
"$programs/bench_ring_down_fits" "$scratch/fits"
printf '\n## Many ranks, predicted\n\n'
"$programs/bench_farm_prediction" "$root/config/schramm2019.toml"
printf '\n'
"$programs/bench_farm_prediction" "$root/config/schramm2019.toml" 2 1
printf '\nload average at the end %s\n' "$(cut -d' ' -f1-3 /proc/loadavg)"
