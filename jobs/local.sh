#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# From a fresh clone to results on this machine: installs packages, builds, runs a study on all
# cores, tracks and calibrates a rendered video of a stem, finds the physics that a recording hides,
# and writes all of it as one page. What is there already is not done again.
#
#   jobs/local.sh [--ranks N] [--study FILE] [--output DIR] [--study-only]
#
#   --ranks N      processes; default: one for each physical core
#   --study FILE   default: config/schramm2019.toml
#   --output DIR   default: results/<name of the study file>
#   --study-only   without the video and the recording
#
# Exit codes are those of culm: 0 done, 2 bad input, 3 some points failed, 75 stopped early (start
# the same command again).
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

fail() {
    echo "local.sh: $1" >&2
    exit 2
}

ranks=
study=$root/config/schramm2019.toml
output=
with_demos=yes
while (($#)); do
    case $1 in
        -h | --help)
            sed -n '3,/^set/{/^set/d;s/^# \{0,1\}//;p}' "${BASH_SOURCE[0]}"
            exit 0
            ;;
        --ranks | --study | --output)
            [[ -n ${2:-} ]] || fail "$1 needs a value"
            declare "${1#--}=$2"
            shift 2
            ;;
        --study-only)
            with_demos=
            shift
            ;;
        *) fail "unknown option '$1'; see --help" ;;
    esac
done
[[ $ranks =~ ^([1-9][0-9]*)?$ ]] || fail "--ranks must be a whole number from 1 up, not '$ranks'"
[[ -f $study ]] || fail "there is no study file '$study'"
output=$(realpath --canonicalize-missing "${output:-$root/results/$(basename "$study" .toml)}")
culm=$root/build/release/src/cli/culm

"$root"/jobs/install-packages.sh build run figures report
[[ -x $culm ]] || echo "Building culm: some ten minutes on two cores, once."
"$root"/jobs/build.sh src/cli/all

# Alone first: a wrong study is refused here in one sentence, without mpirun's words around it.
"$culm" run "$study" -o "$output" --dry-run </dev/null

# Without a number mpirun starts one process for each core. A number that the user chose is not
# bound to cores: two runs side by side would share the first ones.
placement=(--bind-to core:if-supported)
[[ -n $ranks ]] && placement=(-n "$ranks" --bind-to none --oversubscribe)
# Open MPI refuses to start as root, the only user of many containers, without these two.
((EUID == 0)) && export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1

status=0
mpirun "${placement[@]}" "$culm" run "$study" -o "$output" --resume </dev/null || status=$?
case $status in
    0 | 3) ;; # the archive is complete; failed points are listed in it
    75)
        echo "Stopped early; the same command goes on from here."
        exit 75
        ;;
    *) exit "$status" ;;
esac
export CULM_PYTHON=/usr/bin/python3 # the one for which install-packages.sh installs
"$CULM_PYTHON" "$root/postprocess/figures.py" "$output" -o "$output/figures"

# A stem whose Y and beta are known is filmed, so to speak, and calibrated.
track_and_calibrate() {
    local video=$output/demo-video
    echo
    echo "A rendered video of a stem with Y = 1.9 GPa and beta = 90, tracked and calibrated:"
    "$culm" run "$root/config/demo-stem.toml" -o "$video/stem" --resume --quiet </dev/null >/dev/null
    "$CULM_PYTHON" "$root/postprocess/render_video.py" "$video/stem" -o "$video" >/dev/null
    "$culm" track "$video/video.toml" -o "$output/recording"
    "$culm" calibrate "$output/recording" --check -o "$output/calibration"
}

# A recording with physics that the published chain lacks: what is missing is found, and added.
find_hidden_effect() {
    local recording=$root/tests/data/hidden-effect/T2-quadratic_drag found
    echo
    echo "What does the recording ${recording##*/} hide? (half a minute on two cores)"
    mpirun "${placement[@]}" "$culm" diagnose "$recording" -o "$output/diagnosis" </dev/null
    found=$("$CULM_PYTHON" -c 'import json, sys
print(",".join(json.load(open(sys.argv[1], encoding="utf-8"))["effects"]))' \
        "$output/diagnosis/diagnosis.json")
    echo
    echo "The recording against the published chain, and with ${found:-nothing more}:"
    "$culm" compare "$recording" ${found:+--with "$found"} -o "$output/comparison"
}

if [[ -n $with_demos ]]; then
    [[ -f $output/calibration/calibration.json ]] || track_and_calibrate
    [[ -f $output/comparison/comparison.json ]] || find_hidden_effect
fi

echo
echo "Everything is in $output; to open:"
"$culm" report "$output" -o "$output/report.html"
exit "$status"
