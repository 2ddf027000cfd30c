#!/usr/bin/env bash
# Runs jobs on a cluster of Slurm on this machine: a controller and two nodes, on loopback, in a temporary directory. One
# run loses a node with its tasks, one only the daemon of a node, so that its tasks run twice, and in one the task
# reaches its time limit. Searches for rare events and verdict maps lose a node, too, and a search is warned of
# its time limit. Each surface must have the bytes of a run by a single process.
#
#   tests/engines/slurm.sh PROGRAM
set -euo pipefail
. "$(dirname "$0")/common.sh"

is_root "a cluster of Slurm"
# The supervisors of tasks are no family of the daemons, and have no environment.
before_clean_up() { kill -KILL $(tasks_of n1) $(tasks_of n2) 2>/dev/null || true; }
needs "a cluster of Slurm" slurm-wlm munge -- sbatch slurmctld slurmd munged

host=$(hostname -s)
port=$((20000 + RANDOM % 10000))
cat > "$place/slurm.conf" <<EOF
ClusterName=stickslip
SlurmctldHost=$host(127.0.0.1)
SlurmctldPort=$port
SlurmUser=root
MailProg=/bin/true
AuthType=auth/munge
AuthInfo=socket=$place/munge.sock,cred_expire=5
CommunicationParameters=NoCtldInAddrAny,NoInAddrAny
StateSaveLocation=$place/state
SlurmdSpoolDir=$place/spool.%n
SlurmctldPidFile=$place/slurmctld.pid
SlurmdPidFile=$place/slurmd.%n.pid
ProctrackType=proctrack/pgid
TaskPlugin=task/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SlurmdTimeout=5
KillWait=5
ReturnToService=2
SchedulerParameters=sched_interval=5,batch_sched_delay=0
SlurmdParameters=config_overrides
NodeName=n[1-2] NodeHostname=$host NodeAddr=127.0.0.1 Port=[$((port + 1))-$((port + 2))] CPUs=4 State=UNKNOWN
PartitionName=main Nodes=ALL Default=YES State=UP
EOF
export SLURM_CONF=$place/slurm.conf

# The daemon of a node.
start_node() { daemon "slurmd.$1" slurmd -D -N "$1"; }
# The processes of the tasks on a node, and those of Slurm that supervise them.
tasks_of() {
    local tasks parents
    tasks=$(with_variable "SLURMD_NODENAME=$1" $(started_here))
    if [ -n "$tasks" ]; then
        parents=$(ps -o ppid= -p "$(echo $tasks | tr ' ' ,)")
        echo $tasks $(ps -o pid=,comm= -p "$(echo $parents | tr ' ' ,)" | awk '$2 == "slurmstepd" { print $1 }')
    fi
}

mkdir "$place/state"
head -c 1024 /dev/urandom > "$place/munge.key"
chmod 600 "$place/munge.key"
daemon munged munged -F --force --key-file="$place/munge.key" --socket="$place/munge.sock" \
    --pid-file="$place/munged.pid" --log-file="$place/munged.log" --seed-file="$place/munge.seed"
wait_for "munged" test -S "$place/munge.sock"
daemon slurmctld slurmctld -D
start_node n1
start_node n2
is_up() { sinfo --noheader --format=%t --Node --nodes="$1" 2>/dev/null | grep -qxE 'idle|mix|alloc'; }
wait_for "first node" is_up n1
wait_for "second node" is_up n2
say "a controller and two nodes are up"

# submit RUN JOB SHARDS OPTION...: the numbers of the jobs, the array first, but for that of a map.
submit() {
    "$program" submit "$place/$2.toml" --out "$place/$1" --engine slurm --shards "$3" -- --partition=main "${@:4}" \
        2>>"$place/submit.log"
}
restarts() { scontrol show job "$1" | sed -n 's/.* Restarts=\([0-9]*\).*/\1/p' | paste -sd + | bc; }
running_on() { [ "$(squeue --noheader --states=R --nodelist="$1" --jobs="$2" 2>/dev/null | wc -l)" -ge 2 ]; }
# All at once, as a power cut does: nothing is left that could report the others.
lose_n1() {
    local all
    all=$(cat "$place/slurmd.n1.daemon"; tasks_of n1)
    kill -STOP $all 2>/dev/null || true
    kill -KILL $all 2>/dev/null || true
}
has_kept_a_part() { compgen -G "$place/$1/searches/*" >/dev/null; }
is_written() { [ -e "$place/$1/surface.parquet" ]; }

job "$place/short.toml" short 24
job "$place/long.toml" long 36
say "jobs of 24 and 36 seconds at $samples_per_second samples/s"

# Searches for rare events that take some ten seconds, and a map.
slow_inputs='"preload", "static_friction", "friction.kinetic_coefficient", "stiffness.contact_normal", "pad.mass"'
search_job() {
    cat >"$place/$1.toml" <<EOF
name = "$1"
[axes]
rotating_speed = $2
preload = 0.1
static_friction = $3
[random]
inputs = [$4]
relative_std = $5
[criterion]
kind = "time-domain"
disc = "$6"
[sampling]
seed = 2
$7
EOF
}
search_job importance 15.0 0.25 "$slow_inputs" 0.05 flexible $'method = "importance"\nrandomisations = 8\nparticles = 2000\nsamples = 1024'
search_job subset 15.0 0.25 "$slow_inputs" 0.05 flexible $'method = "subset"\nrandomisations = 4\nparticles = 500'
search_job boundary '{ from = 12.0, to = 18.0, points = 24 }' '[0.38, 0.40]' '"preload", "static_friction"' 0.02 rigid \
    $'evaluate = "boundary"\nsamples = 20_000'
searches="importance subset boundary"

# The task reaches its time limit: Slurm warns half a minute and more before it.
read -r limited _ < <(submit limited long 1 --time=1 --signal=B:USR1@50 --exclude=n1)
"$program" submit "$place/short.toml" --out "$place/whole-short" >/dev/null 2>&1 &
reference=$!

read -r lost _ < <(submit lost short 8)
wait_for "tasks on n1" running_on n1 "$lost"
sleep 1
lose_n1
say "n1 is lost with its tasks; $("$program" status "$place/lost" | head -n 1)"
wait_for "surface after the loss of a node" is_written lost
wait "$reference"
same "$place/lost" "$place/whole-short"
[ "$(restarts "$lost")" -ge 1 ] || fail "no task of n1 was started again"
say "a node was lost: $(restarts "$lost") restarts, the surface is that of a single process"

"$program" submit "$place/long.toml" --out "$place/whole-long" >/dev/null 2>&1 &
reference=$!
start_node n1
wait_for "two nodes" is_up n1
read -r twice _ < <(submit twice short 8)
wait_for "tasks on n1" running_on n1 "$twice"
sleep 1
kill -KILL "$(cat "$place/slurmd.n1.daemon")"
scontrol update nodename=n1 state=down reason=lost
orphans=$(tasks_of n1 | wc -w)
[ "$orphans" -ge 1 ] || fail "no task of n1 has survived its daemon"
say "the daemon of n1 is lost, and $orphans processes of its tasks go on"
wait_for "surface after the loss of a daemon" is_written twice
same "$place/twice" "$place/whole-short"
[ "$(restarts "$twice")" -ge 1 ] || fail "no task of n1 was started again"
say "tasks ran twice: $(restarts "$twice") restarts, the surface is that of a single process"

wait "$reference"
for name in $searches; do "$program" submit "$place/$name.toml" --out "$place/whole-$name" >/dev/null 2>&1; done
start_node n1
wait_for "two nodes" is_up n1
tasks=
for name in $searches; do
    read -r task _ < <(submit "lost-$name" "$name" 2 --nodelist=n1)
    tasks+=${tasks:+,}$task
done
# What Slurm sends before a time limit.
read -r warned _ < <(submit warned importance 1 --exclude=n1)
wait_for "searches on n1" running_on n1 "$tasks"
wait_for "part of the search on n2" has_kept_a_part warned
scancel --batch --signal=USR1 "$warned"
lose_n1
say "n1 is lost with the searches of $searches"
# It comes back, as after a power cut.
start_node n1
for name in $searches; do
    wait_for "surface of $name after the loss of a node" is_written "lost-$name"
    same "$place/lost-$name" "$place/whole-$name"
done
say "a node was lost with searches for rare events and a verdict map: the surfaces are those of a single process"

wait_for "surface of a search that was warned" is_written warned
same "$place/warned" "$place/whole-importance"
grep -h terminated "$place"/warned/slurm/shard-*.log >/dev/null || fail "no search was warned of its time limit"
[ "$(restarts "$warned")" -ge 1 ] || fail "no search was started again"
say "a search was warned of its time limit: $(restarts "$warned") restarts, the surface is that of a single process"

wait_for "surface after time limits" is_written limited
same "$place/limited" "$place/whole-long"
grep -h terminated "$place"/limited/slurm/shard-*.log >/dev/null || fail "no task has reached its time limit"
[ "$(restarts "$limited")" -ge 1 ] || fail "no task was started again"
say "time limits: $(restarts "$limited") restarts, the surface is that of a single process"
say "done"
