#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# shellcheck disable=SC2317 # `stage` and `unless` call the functions
# From a fresh clone to results on this machine: installs packages, builds, runs a study on all
# cores, tracks and calibrates a rendered video of a stem, finds the effect that a recording hides,
# and writes all of it as one page. Stages that are complete are not repeated.
#
#   jobs/local.sh [--ranks N] [--study FILE] [--output DIR] [--study-only]
#
#   --ranks N      processes; default: one for each physical core
#   --study FILE   default: config/schramm2019.toml
#   --output DIR   default: results/<name of the study file>
#   --study-only   without the video and the recording
#
# Prints a line per stage; DIR/local.log contains what the stages print. Exit codes are those of
# culm: 0 done, 2 bad input, 3 some points failed, 75 stopped early (start the same command again).
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
            sed -n '4,/^set/{/^set/d;s/^# \{0,1\}//;p}' "${BASH_SOURCE[0]}"
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
recording=$root/tests/data/hidden-effect/T2-quadratic_drag
mkdir -p "$output"
log=$output/local.log
: >"$log"

# stage TEXT COMMAND...: a line with the time it took. Ends the script if the command fails.
stages=$([[ -n $with_demos ]] && echo 8 || echo 4)
stage_number=0
stage() {
    local start=$SECONDS status=0
    stage_number=$((stage_number + 1))
    printf '[%d/%d] %-58s' "$stage_number" "$stages" "$1"
    shift
    printf '\n$ %s\n' "$*" >>"$log"
    "$@" </dev/null >>"$log" 2>&1 || status=$?
    printf '%5d s\n' $((SECONDS - start))
    if ((status != 0)); then
        tail -n 15 "$log" >&2
        ((status != 75)) || echo "Stopped early; the same command continues from here." >&2
        exit "$status"
    fi
}

stage "install missing Debian packages" "$root"/jobs/install-packages.sh build run figures report
stage "build (some minutes on two cores, once)" "$root"/jobs/build.sh src/cli/all

# A single process refuses a wrong study in one sentence, without mpirun's messages.
"$culm" run "$study" -o "$output" --dry-run </dev/null >>"$log"
# Without a number mpirun starts one process for each core. A number that the user chose is not
# bound to cores: two runs next to each other would share the first ones.
placement=(--bind-to core:if-supported)
[[ -n $ranks ]] && placement=(-n "$ranks" --bind-to none --oversubscribe)
# Open MPI refuses to start as root, the only user of many containers, without these two.
((EUID == 0)) && export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
export CULM_PYTHON=/usr/bin/python3 # the one for which install-packages.sh installs

study_status=0
run_study() {
    mpirun "${placement[@]}" "$culm" run "$study" -o "$output" --resume || study_status=$?
    # With 3 the archive is complete; the failed points are listed in it.
    ((study_status == 0 || study_status == 3)) || return "$study_status"
    "$CULM_PYTHON" "$root/postprocess/figures.py" "$output" -o "$output/figures"
}

# The motion of a stem by a beam model that is not culm's chain, as a video.
track_video() {
    "$CULM_PYTHON" "$root/postprocess/render_video.py" "$root/tests/data/demo-beam" \
        -o "$output/demo-video" &&
        "$culm" track "$output/demo-video/video.toml" -o "$output/recording"
}

# unless FILE COMMAND...: nothing if the file exists already.
unless() {
    local file=$1
    shift
    [[ -f $file ]] || "$@"
}

stage "study: $(basename "$study")" run_study
if [[ -n $with_demos ]]; then
    stage "video of a stem: deflections" \
        unless "$output/recording/deflection.csv" track_video
    stage "the stem's Y and beta" unless "$output/calibration/calibration.json" \
        "$culm" calibrate "$output/recording" --check -o "$output/calibration"
    stage "a recording with a hidden effect: diagnosis" \
        unless "$output/diagnosis/diagnosis.json" \
        mpirun "${placement[@]}" "$culm" diagnose "$recording" -o "$output/diagnosis"
    effects=$("$CULM_PYTHON" "$root/postprocess/key_results.py" --effects "$output")
    stage "the recording against the chain${effects:+ with $effects}" \
        unless "$output/comparison/comparison.json" \
        "$culm" compare "$recording" ${effects:+--with "$effects"} -o "$output/comparison"
fi
stage "one page with all results" "$culm" report "$output" -o "$output/report.html"

printf 'Done in %d s; what the stages printed is in %s\n\n' "$SECONDS" "$log"
"$CULM_PYTHON" "$root/postprocess/key_results.py" "$output"
printf '\n%s\n' "$output/report.html"
exit "$study_status"
