#!/bin/sh
{{header}}# Writes the surface of the run, after its shards. If some are missing, they are submitted again, a few times.
#   merge.sh ROUND ARRAY
set -u
stickslip={{program}}
run={{run}}
round=$1
array=$2

attempt=1
while :; do
    "$stickslip" merge "$run" --wait 0
    code=$?
    # 75: a task that Slurm believes to be lost is still at work.
    if [ "$code" -ne 75 ] || [ "$attempt" -ge 60 ]; then break; fi
    attempt=$((attempt + 1))
    sleep 10
done
if [ "$code" -ne 65 ]; then exit "$code"; fi
missing=$("$stickslip" status "$run" --missing --format slurm) || exit
if [ -z "$missing" ]; then exit "$code"; fi
if scontrol show job "$array" --oneliner 2>/dev/null | grep -q JobState=CANCELLED; then
    why="tasks were cancelled"
elif [ "$round" -ge 3 ]; then
    why="this was round $round"
else
    echo "submitting shards $missing again"
    sh "$run/slurm/submit.sh" "$missing" "$((round + 1))"
    exit
fi
echo "shards $missing are missing, and $why. Submit them again with"
printf '%s\n' {{again}}" $missing"
exit "$code"
