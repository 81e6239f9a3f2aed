#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# Every table of docs/performance.md, one file each, in the page's order. Half an hour on an idle
# machine with two cores; on a busy one the efficiencies are meaningless.
#
#   bench/all.sh BUILD_FOLDER OUTPUT_FOLDER
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
if [[ $# -ne 2 ]]; then
    sed -n '6s/^# *//p' "${BASH_SOURCE[0]}" >&2
    exit 2
fi
build=$1
output=$2
mkdir -p "$output"
launch=(mpirun --oversubscribe)
if [[ $(id -u) -eq 0 ]]; then
    launch+=(--allow-run-as-root)
fi

# table NAME COMMAND...: its output, between the load averages before and after.
table() {
    local name=$1
    shift
    printf '%s\n' "$name" >&2
    {
        printf 'load average %s\n\n' "$(cut -d' ' -f1-3 /proc/loadavg)"
        "$@"
        printf '\nload average %s\n' "$(cut -d' ' -f1-3 /proc/loadavg)"
    } >"$output/$name.md"
}
# Wall time and largest resident set of a rank: the published study, 200 replicate stems, and the
# published design over 0.2 s.
memory() {
    local study scratch
    printf '| study | ranks | wall, s | largest resident set of a rank, MB |\n|---|---:|---:|---:|\n'
    for study in schramm2019 replicates reproduction-schramm2019; do
        scratch=$(mktemp -d)
        # shellcheck disable=SC2016 # the inner shell expands
        "${launch[@]}" -n 2 bash -c '/usr/bin/time -f "%e %M" -o "$1/time.$OMPI_COMM_WORLD_RANK" \
            "$2" run "$3" -o "$1/study" --quiet >"$1/out"' \
            bash "$scratch" "$build/src/cli/culm" "$root/config/$study.toml"
        cat "$scratch"/time.* | awk -v name="$study" '
            $1 > wall { wall = $1 } $2 > memory { memory = $2 }
            END { printf "| %s | %d | %.2f | %.0f |\n", name, NR, wall, memory * 1.024e-3 }'
        rm -rf "$scratch"
    done
}

table explicit_step "$build/bench/bench_explicit_step"
table implicit_tolerance "$build/bench/bench_implicit_tolerance"
table implicit_methods "$build/bench/bench_implicit_methods"
table implicit_phases "$build/bench/bench_implicit_phases"
table implicit_batches "$build/bench/bench_implicit_batches"
table cost_estimates "$build/bench/bench_cost_estimates"
table study_methods "$root/bench/study_methods.sh" "$build"
table study_overhead "$root/bench/study_overhead.sh" "$build"
table memory memory
table farm "$root/bench/farm.sh" "$build"
