# What the tests of engines have in common: a temporary directory, daemons that end with the test, and messages.

test_name=$(basename "$0" .sh)
# A user of ssh and the daemons of Slurm must be able to enter it.
place=$(mktemp -d "${TMPDIR:-/tmp}/stickslip-$test_name.XXXXXX")
chmod 755 "$place"
trap clean_up EXIT
trap 'exit 1' INT TERM HUP

say() { echo "$test_name: $SECONDS s: $*"; }
skip() {
    say "skipped: $*"
    exit 0
}
fail() {
    say "FAILED: $*" >&2
    exit 1
}

is_root() { [ "$(id -u)" -eq 0 ] || skip "$1 needs root here"; }

# needs WHAT PACKAGE... -- PROGRAM...: installs the packages from Debian if a program is missing.
needs() {
    local what=$1 packages=()
    shift
    while [ "$1" != -- ]; do
        packages+=("$1")
        shift
    done
    shift
    # Daemons are not on the path of every user.
    PATH=$PATH:/usr/sbin:/sbin
    command -v "$@" >/dev/null && [ "$(command -v "$@" | wc -l)" -eq $# ] && return
    command -v apt-get >/dev/null || skip "$what needs ${packages[*]}, and there is no apt-get"
    say "installing ${packages[*]}"
    { apt-get update && DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends "${packages[@]}"; } \
        >"$place/apt.log" 2>&1 || skip "${packages[*]} cannot be installed: $(tail -n 1 "$place/apt.log")"
}

# daemon NAME COMMAND...: starts a daemon in a process group of its own.
daemon() {
    local name=$1
    shift
    setsid "$@" >>"$place/$name.log" 2>&1 </dev/null &
    echo "$!" >"$place/$name.daemon"
    disown
}

# wait_for WHAT COMMAND...: until the command succeeds; only what hangs takes half an hour.
wait_for() {
    local deadline=$((SECONDS + 1800)) what=$1
    shift
    until "$@"; do
        [ "$SECONDS" -lt "$deadline" ] || fail "no $what in time"
        sleep 0.2
    done
}

# family PROCESS...: the processes, and all that they have started.
family() {
    local parent child
    for parent in "$@"; do
        echo "$parent"
        for child in $(ps -o pid= --ppid "$parent"); do
            family "$child"
        done
    done
}

# with_variable NAME=VALUE PROCESS...: those of the processes that have this in their environment.
with_variable() {
    local line=$1 files
    shift
    if [ "$#" -eq 0 ]; then return; fi
    files=("${@/#//proc/}")
    { grep -lzxF "$line" "${files[@]/%//environ}" || true; } 2>/dev/null | cut -d / -f 3
}
# started_here: the processes that this test has started, at whatever distance, without itself.
started_here() { with_variable "STICKSLIP_TEST_PLACE=$place" $(cd /proc && echo [0-9]*) | grep -vx $$ || true; }
export STICKSLIP_TEST_PLACE=$place

# A test may have more to end.
before_clean_up() { :; }

clean_up() {
    local code=$?
    if [ "$code" -ne 0 ]; then
        tail -n 20 "$place"/*.log "$place"/*/*/*.log >&2 2>/dev/null || true
    fi
    before_clean_up
    # What daemons have started may have left their family, or have cleared its environment.
    kill -KILL $(family $(cat "$place"/*.daemon 2>/dev/null)) 2>/dev/null || true
    kill -KILL $(started_here) 2>/dev/null || true
    rm -rf "$place"
    return "$code"
}

# job FILE NAME SECONDS: writes a job that takes one thread about this long, as measured with a small one. Others may keep
# the processors busy, so that the time of the processor counts.
job() {
    if [ -z "${samples_per_second:-}" ]; then
        local TIMEFORMAT=%U seconds
        job_with "$place/trial.toml" trial 6000
        seconds=$({ time "$program" submit "$place/trial.toml" --out "$place/trial" --threads 1 &>"$place/trial.log"; } 2>&1)
        samples_per_second=$(awk -v seconds="$seconds" 'BEGIN { print int(30 * 6000 / seconds) }')
    fi
    job_with "$1" "$2" $((samples_per_second * $3 / 30 + 1))
}
job_with() {
    cat >"$1" <<EOF
name = "$2"
[axes]
rotating_speed = 15.0
preload = { from = 0.05, to = 0.30, points = 6 }
static_friction = { from = 0.28, to = 0.50, points = 5 }
[random]
inputs = ["preload", "static_friction"]
relative_std = 0.2
[criterion]
kind = "time-domain"
disc = "rigid"
[sampling]
samples = $3
EOF
}

# same RUN REFERENCE: fails unless the surfaces have the same bytes.
same() { cmp "$1/surface.parquet" "$2/surface.parquet" || fail "the surface of $1 is not that of a single process"; }

# The program under test is a copy: a Python package that is built meanwhile moves the program away for a moment.
program=$place/stickslip
wait_for "program" cp "$1" "$program"
