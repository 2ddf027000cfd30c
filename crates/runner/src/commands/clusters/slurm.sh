#!/bin/sh
# A run as an array of tasks of Slurm, and the merge after them.
#   sh run.sh submit    submits them, and prints the numbers of the jobs
# Slurm calls it with other words.
set -u
stickslip={{program}}
run={{run}}
script=$run/slurm/run.sh

# submitted STEP WORDS OPTION...: the number of a job that calls this script with STEP and WORDS. Of two options of one name
# the last counts: the user may replace what stands before theirs.
submitted() {
    step=$1
    words=$2
    shift 2
    job=$(sbatch --job-name="stickslip-{{name}}-$step" --open-mode=append --requeue --cpus-per-task={{threads}} \
        --signal=B:USR1@60 {{options}} --parsable --chdir="$run" "$@" "$script" "$step" $words) || exit
    # A federation adds the name of the cluster.
    echo "${job%%;*}"
}

case $1 in
submit)
    tasks=--array=1-{{shards}}
    jobs=
    # All are taken, or none.
    fail() {
        if [ -n "$jobs" ]; then scancel $jobs; fi
        exit 1
    }
    after=
    if [ {{has_map}} = true ]; then
        jobs=$(submitted map "" $tasks --output=slurm/map-%a.log) || fail
        after=--dependency=afterany:$jobs
    fi
    # What the tasks leave of the map is resolved by the shards.
    shards=$(submitted shard "" $tasks --output=slurm/shard-%a.log $after) || fail
    jobs="$jobs $shards"
    merge=$(submitted merge "${2:-1} $shards" --output=slurm/merge.log --dependency="afterany:$shards") || fail
    echo $jobs "$merge"
    ;;
map | shard)
    program=
    at_limit=no
    stop() {
        if [ -n "$program" ]; then kill -TERM "$program" 2>/dev/null; fi
    }
    # USR1 means that the time limit is near. TERM comes with scancel, and is obeyed.
    trap 'at_limit=yes; stop' USR1
    trap stop TERM
    option=
    if [ "$1" = map ]; then option=--map-only; fi
    "$stickslip" submit "$run/job.toml" --out "$run" --shard "$SLURM_ARRAY_TASK_ID/{{shards}}" \
        --threads "$SLURM_CPUS_PER_TASK" {{maps}} $option &
    program=$!
    wait "$program"
    code=$?
    # A signal ends the waiting, not the program.
    while kill -0 "$program" 2>/dev/null; do
        wait "$program"
        code=$?
    done
    # What is finished is saved, and the task goes on from there, unless it never gets further.
    if [ "$at_limit" = yes ] && [ "$code" -eq 143 ] && [ "${SLURM_RESTART_COUNT:-0}" -lt 100 ]; then
        scontrol requeue "${SLURM_ARRAY_JOB_ID}_$SLURM_ARRAY_TASK_ID"
    fi
    exit "$code"
    ;;
merge)
    # A warning of the time limit is of no use to it.
    trap '' USR1
    # It waits for a task that Slurm believes to be lost.
    "$stickslip" merge "$run" --wait 600 {{asked}}
    code=$?
    # It has failed for another reason than missing samples, or not at all.
    if ! "$stickslip" status "$run" --json | grep -q '"state": "unfinished"'; then exit "$code"; fi
    # A shard that is finished ends at once when it is submitted again.
    if scontrol show job "$3" --oneliner 2>/dev/null | grep -q JobState=CANCELLED; then
        why="tasks were cancelled"
    elif [ "$2" -ge 3 ]; then
        why="this was round $2"
    else
        echo "submitting the shards again"
        exec sh "$script" submit "$(($2 + 1))"
    fi
    echo "samples are missing, and $why; submit the job again in the same way"
    exit "$code"
    ;;
esac
