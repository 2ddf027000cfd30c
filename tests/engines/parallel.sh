#!/usr/bin/env bash
# Runs a job over GNU parallel and ssh on two machines, which are two addresses of this one: daemons of ssh with keys and
# configuration of their own, for this test alone. One of them is lost in the middle. The surface must have the bytes of
# a run by a single process.
#
#   tests/engines/parallel.sh PROGRAM
set -euo pipefail
. "$(dirname "$0")/common.sh"

is_root "a daemon of ssh"
needs "a run on several machines" parallel openssh-server openssh-client -- parallel sshd ssh ssh-keygen

port=$((20000 + RANDOM % 10000))
ssh-keygen -q -t ed25519 -N '' -f "$place/host_key"
ssh-keygen -q -t ed25519 -N '' -f "$place/user_key"
mkdir -p /run/sshd
# An empty home: the user's startup files of the shell may do anything, and some take a minute for each login.
mkdir "$place/home"
for address in 127.0.0.1 127.0.0.2; do
    cat >"$place/sshd.$address.conf" <<EOF
ListenAddress $address
Port $port
HostKey $place/host_key
AuthorizedKeysFile $place/user_key.pub
PidFile none
StrictModes no
UsePAM no
PasswordAuthentication no
PermitRootLogin prohibit-password
SetEnv HOME=$place/home
EOF
    daemon "sshd.$address" "$(command -v sshd)" -D -e -f "$place/sshd.$address.conf"
done
cat >"$place/ssh.conf" <<EOF
Port $port
IdentityFile $place/user_key
IdentitiesOnly yes
UserKnownHostsFile $place/known_hosts
StrictHostKeyChecking accept-new
LogLevel ERROR
EOF
logs_in() { ssh -F "$place/ssh.conf" "$1" true 2>/dev/null; }
wait_for "login to the first machine" logs_in 127.0.0.1
wait_for "login to the second machine" logs_in 127.0.0.2
say "two daemons of ssh are up"

# A path that shells and parallel could misread.
run="$place/a 'run' of {} and \$(it)"
mkdir "$place/hosts of the test"
hosts="$place/hosts of the test/two"
printf 'ssh -F %s 127.0.0.%s\n' "$place/ssh.conf" 1 "$place/ssh.conf" 2 >"$hosts"

job "$place/shared.toml" shared 12
"$program" submit "$place/shared.toml" --out "$place/whole" >/dev/null 2>&1
say "a job of 12 seconds at $samples_per_second samples/s"

# Twice as many as two machines of these processors begin with, so that some are left when the first has ended.
shards=$((4 * $(nproc)))
"$program" submit "$place/shared.toml" --out "$run" --engine parallel --hosts "$hosts" --shards "$shards" --threads 1 \
    >"$place/submit.log" 2>&1 &
submitted=$!
ended() { tail -n +2 "$run/parallel/shard.log" 2>/dev/null | wc -l; }
some_are_done() { [ "$(ended)" -ge 1 ]; }
wait_for "shard" some_are_done
# The daemon, the sessions, and what runs in them.
kill -KILL $(family "$(cat "$place/sshd.127.0.0.2.daemon")") 2>/dev/null || true
[ "$(ended)" -lt "$shards" ] || fail "all shards had ended before a machine was lost"
say "the second machine is lost; $(ended) of $shards shards have ended"
wait "$submitted" || fail "submit has ended with $?"
same "$run" "$place/whole"
hosts_of() { awk -F '\t' -v host="$1" 'NR > 1 && index($2, host)' "$run/parallel/shard.log" | wc -l; }
say "$(hosts_of 127.0.0.1) shards ended on the first machine, $(hosts_of 127.0.0.2) on the second, the surface is that of a single process"
say "done"
