#!/bin/sh
# Runs the shards of a run over GNU parallel and ssh, one at a time on each machine.
#   sh run.sh         all shards
#   sh run.sh 3 7 12  these shards
set -eu
run={{run}}
hosts={{hosts}}
if [ "$#" -eq 0 ]; then set -- $(seq 1 {{shards}}); fi

program=
stopped=
# The first signal asks GNU parallel to start no more, the second one to end.
pass_on() {
    stopped=yes
    if [ -n "$program" ]; then kill -TERM "$program" 2>/dev/null || :; fi
}
trap pass_on TERM INT HUP

# on_all SCRIPT NUMBER...: runs the script for each number. What fails is tried again elsewhere.
on_all() {
    script=$1
    shift
    parallel --sshloginfile "$hosts" --jobs 1 --retries 4 --joblog "$run/parallel/$script.log" \
        sh '{1}' '{2}' ::: "$run/parallel/$script.sh" ::: "$@" &
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

# Shards that resolve a verdict map first; none without a map. What is missing of it is resolved by the others.
map_shards={{map_shards}}
if [ -n "$map_shards" ]; then on_all map $(seq 1 "$map_shards"); fi
on_all shard "$@"
exit "$code"
