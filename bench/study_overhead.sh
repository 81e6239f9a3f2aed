#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# The cost of a study beyond its bare computation: mpirun's start, the farm, the archive, the
# regression. Every repeat runs all variants in turn, so that they share the machine's state.
#
#   bench/study_overhead.sh BUILD_FOLDER [STUDY.toml [REPEATS]]
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
if [[ $# -lt 1 || $# -gt 3 ]]; then
    sed -n '6s/^# *//p' "${BASH_SOURCE[0]}" >&2
    exit 2
fi
culm=$1/src/cli/culm
bare=$1/bench/bench_study_compute
study=${2:-$root/config/schramm2019.toml}
repeats=${3:-5}

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
launch=(mpirun --oversubscribe)
if [[ $(id -u) -eq 0 ]]; then
    launch+=(--allow-run-as-root)
fi

# measure NAME COMMAND...: appends "wall processor" seconds to the file of that name.
measure() {
    local name=$1 wall user system
    shift
    { TIMEFORMAT='%R %U %S'; time "$@" >"$work/out" 2>"$work/err"; } 2>"$work/time" || {
        cat "$work/err" >&2
        exit 1
    }
    read -r wall user system <"$work/time"
    awk -v w="$wall" -v u="$user" -v s="$system" 'BEGIN { print w, u + s }' >>"$work/$name"
}
# column NAME COLUMN: "median least".
column() {
    awk -v c="$2" '{ print $c }' "$work/$1" | sort -g | awk '{ v[NR] = $1 }
        END { print (NR % 2 ? v[(NR + 1) / 2] : (v[NR / 2] + v[NR / 2 + 1]) / 2), v[1] }'
}

for ((k = 0; k < repeats; ++k)); do
    measure bare "$bare" "$study"
    cat "$work/out" >>"$work/split"
    measure alone "$culm" run "$study" -o "$work/alone.$k" --quiet
    measure ranks1 "${launch[@]}" -n 1 "$culm" run "$study" -o "$work/ranks1.$k" --quiet
    measure ranks2 "${launch[@]}" -n 2 "$culm" run "$study" -o "$work/ranks2.$k" --quiet
    measure start "${launch[@]}" -n 2 "$culm" run "$study" --dry-run
done

read -r load _ < <(column split 1)
read -r simulate _ < <(column split 2)
read -r fit _ < <(column split 3)
read -r bare_wall _ < <(column bare 1)
read -r bare_cpu _ < <(column bare 2)
printf '%s, %d repeats, medians, s; load average %s\n\n' "$(basename "$study")" "$repeats" \
    "$(cut -d' ' -f1-3 /proc/loadavg)"
printf 'bare computation: load %s, simulate %s, fit Eq. 1 %s (processor time)\n\n' \
    "$load" "$simulate" "$fit"
printf '| variant | wall | least | processor | least | wall / bare | processor / bare | compute share |\n'
printf '|---|---:|---:|---:|---:|---:|---:|---:|\n'
row() {
    local wall least cpu least_cpu
    read -r wall least < <(column "$2" 1)
    read -r cpu least_cpu < <(column "$2" 2)
    awk -v name="$1" -v w="$wall" -v lw="$least" -v c="$cpu" -v lc="$least_cpu" \
        -v bw="$bare_wall" -v bc="$bare_cpu" -v compute="$simulate" 'BEGIN {
            printf "| %s | %.2f | %.2f | %.2f | %.2f | %.3f | %.3f | %.1f %% |\n",
                name, w, lw, c, lc, w / bw, c / bc, 100 * compute / c }'
}
row 'bare computation' bare
row 'culm run' alone
row 'mpirun -n 1 culm run' ranks1
row 'mpirun -n 2 culm run' ranks2
row 'mpirun -n 2 culm run --dry-run' start | sed 's/| [^|]* |$/| |/'
printf '\ncompute share: simulation alone over all processor time of the command.\n'
