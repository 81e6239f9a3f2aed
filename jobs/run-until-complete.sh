# SPDX-License-Identifier: BSD-3-Clause
# shellcheck shell=bash
# For job scripts of Slurm and PBS, which source it: runs a command that ends with culm's exit codes,
# and has the job start again until nothing is missing.
#
#   run_until_complete SECONDS COMMAND...
#
# SECONDS is the time limit of the job, counted from the start of the script: the words --walltime
# and TIME are added to COMMAND, so that it ends before the walltime. 0: COMMAND is left to ask
# the batch system (Slurm).
# Uses: SECONDS (bash counts it from the script's start), CULM_MAX_RESTARTS (default 1000).
# Exit codes: 0 complete; 3 complete, some points failed; 2 bad input; 75 stopped on request; others
# as the command left them.

# Ends the job and puts it into the queue again.
culm_start_job_again() {
    local restarts=${SLURM_RESTART_COUNT:-${CULM_RESTARTS:-0}}
    if ((restarts >= ${CULM_MAX_RESTARTS:-1000})); then
        echo "Started again $restarts times already; submit the job by hand to go on." >&2
        exit 75
    fi
    echo "$(date '+%F %T') not complete: the job starts again (restart $((restarts + 1)))"
    if [[ -n ${SLURM_JOB_ID:-} ]]; then
        # An element of a job array is named by both numbers.
        local job=$SLURM_JOB_ID
        [[ -n ${SLURM_ARRAY_JOB_ID:-} ]] && job=${SLURM_ARRAY_JOB_ID}_$SLURM_ARRAY_TASK_ID
        if scontrol requeue "$job"; then
            sleep 60 # Slurm ends this script meanwhile
            exit 75
        fi
        # Where jobs may not be requeued a new one is submitted with the same script; a single
        # element of an array cannot be.
        [[ -n ${SLURM_ARRAY_JOB_ID:-} ]] || { sbatch "$0" && exit 0; }
    elif [[ -n ${PBS_JOBID:-} ]]; then
        qsub -v "CULM_RESTARTS=$((restarts + 1))" "$0" && exit 0
    fi
    echo "The job could not be started again; submit it by hand to go on." >&2
    exit 75
}

run_until_complete() {
    local limit=$1 status=0 deaths=0 child='' stopped='' cancelled=''
    local -a walltime=()
    shift
    # USR1 comes from the batch system before the limit or a pre-emption (#SBATCH --signal): mpirun
    # and srun pass it on to culm, which keeps what it has and ends. TERM means scancel or qdel: the
    # job is not wanted any more.
    trap 'stopped=yes; [[ -n $child ]] && kill -USR1 "$child" 2>/dev/null' USR1
    trap 'cancelled=yes; [[ -n $child ]] && kill -USR1 "$child" 2>/dev/null' TERM INT
    while :; do
        if ((limit > 0)); then
            ((limit > SECONDS)) || culm_start_job_again
            walltime=(--walltime "$((limit - SECONDS))s")
        fi
        # In the background, because bash runs traps only between commands.
        "$@" "${walltime[@]}" &
        child=$!
        while :; do
            status=0
            wait "$child" || status=$?
            # A trapped signal ends wait early, with 128 and the number of the signal.
            kill -0 "$child" 2>/dev/null || break
        done
        child=''
        echo "$(date '+%F %T') exit code $status"
        [[ -z $cancelled ]] || exit 75
        case $status in
            0 | 3 | 126 | 127) exit "$status" ;;
            2) # After a death this is about the little time that is left, else about the study.
                ((deaths > 0)) || exit "$status"
                culm_start_job_again
                ;;
            75) culm_start_job_again ;;
        esac
        [[ -z $stopped ]] || culm_start_job_again
        # A process has died; what was computed is kept. culm gives a point up that killed its
        # process five times, so the sixth attempt cannot end for the same reason.
        deaths=$((deaths + 1))
        ((deaths <= 6)) || exit "$status"
    done
}
