#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# The farm on two ranks: trivial points per second, share of writing in a study, efficiency.
#
#   bench/farm.sh BUILD_FOLDER [SCRATCH_FOLDER]
set -euo pipefail
if [[ $# -lt 1 || $# -gt 2 ]]; then
    sed -n '5s/^# *//p' "${BASH_SOURCE[0]}" >&2
    exit 2
fi
programs=$1/bench
scratch=$(mktemp -d "${2:-${TMPDIR:-/tmp}}/culm-farm.XXXXXX")
trap 'rm -rf "$scratch"' EXIT
launch=(mpirun --oversubscribe -n 2)
if [[ $(id -u) -eq 0 ]]; then
    launch+=(--allow-run-as-root)
fi


for what in scheduler archive shares efficiency; do
    "${launch[@]}" "$programs/bench_farm" "$what" "$scratch"
done
