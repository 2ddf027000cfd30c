#!/bin/sh
# A run over GNU parallel and ssh, one shard at a time on each machine.
#   sh run.sh               all shards, after the verdict map if there is one
#   sh run.sh map|shard I   a share of the map, or a shard, as GNU parallel calls it
set -eu
stickslip={{program}}
run={{run}}

if [ "$#" -eq 2 ]; then
    option=
    if [ "$1" = map ]; then option=--map-only; fi
    exec "$stickslip" submit "$run/job.toml" --out "$run" --shard "$2/{{shards}}" {{threads}} {{maps}} $option
fi

program=
stopped=
# GNU parallel may not listen yet, or wait for its jobs: whoever sends a signal repeats it until this script has ended.
pass_on() {
    stopped=yes
    if [ -n "$program" ]; then kill -TERM "$program" 2>/dev/null || :; fi
}
trap pass_on TERM INT HUP QUIT

# on_all STEP: what fails is tried again elsewhere.
on_all() {
    # There may be more numbers than words of a command.
    seq 1 {{shards}} | parallel --sshloginfile {{hosts}} --jobs 1 --retries 4 --joblog "$run/parallel/$1.log" \
        sh '{1}' '{2}' '{3}' ::: "$run/parallel/run.sh" ::: "$1" :::: - &
    program=$!
    code=0
    wait "$program" || code=$?
    # A signal ends the waiting, not the program.
    while kill -0 "$program" 2>/dev/null; do
        code=0
        wait "$program" || code=$?
    done
    if [ -n "$stopped" ]; then exit 143; fi
}

# What is missing of the map is resolved by the shards.
if [ {{has_map}} = true ]; then on_all map; fi
on_all shard
exit "$code"
