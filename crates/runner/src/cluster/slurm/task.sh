#!/bin/sh
{{header}}# {{what}}: a task of a job array of Slurm.
set -u
stickslip={{program}}
run={{run}}
program=
at_limit=no
stop() {
    if [ -n "$program" ]; then kill -TERM "$program" 2>/dev/null; fi
}
# USR1 means that the time limit is near. TERM comes with scancel, and is obeyed.
trap 'at_limit=yes; stop' USR1
trap stop TERM

"$stickslip" submit "$run/job.toml" --out "$run" --shard "$SLURM_ARRAY_TASK_ID/{{shards}}" --threads "$SLURM_CPUS_PER_TASK"{{options}} &
program=$!
wait "$program"
code=$?
# A signal ends the waiting, not the program.
while kill -0 "$program" 2>/dev/null; do
    wait "$program"
    code=$?
done
if [ "$at_limit" = yes ] && [ "$code" -eq 143 ] && [ "${SLURM_RESTART_COUNT:-0}" -lt {{restarts}} ]; then
    # What is finished is saved, and the task goes on from there.
    scontrol requeue "${SLURM_ARRAY_JOB_ID}_$SLURM_ARRAY_TASK_ID"
fi
exit "$code"
