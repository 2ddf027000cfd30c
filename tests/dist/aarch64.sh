#!/bin/sh
# The program of the wheel for aarch64 in a folder, in an emulator: it gives the pinned values, and writes the same bytes as
# that of the wheel for this machine.
#
#     tests/dist/aarch64.sh FOLDER
set -eu
cd "$(dirname "$0")/../.."

folder=$1
target=aarch64-unknown-linux-gnu
place=$PWD/target/aarch64
emulator="qemu-aarch64 -L /usr/aarch64-linux-gnu"
cargo=${CARGO:-cargo}

rm -rf "$place"
mkdir -p "$place"
# The program for a processor out of its wheel.
unpack() {
    python -B -c 'import sys, zipfile
files = zipfile.ZipFile(sys.argv[1])
[name] = [name for name in files.namelist() if name.endswith(".data/scripts/stickslip")]
sys.stdout.buffer.write(files.read(name))' "$folder"/stickslip-*_"$1".whl >"$place/$1"
    chmod 755 "$place/$1"
}

unpack aarch64
unpack "$(uname -m)"
cat >"$place/stickslip" <<END
#!/bin/sh
exec $emulator "$place/aarch64" "\$@"
END
chmod 755 "$place/stickslip"

says() { echo "test-aarch64: $(date +%T) $*" >&2; }

says "the program"
"$place/stickslip" --version
"$place/stickslip" --version | grep -x "target: *$target"
"$place/stickslip" --version | grep -x "instruction set: *NEON"

says "values that are pinned: eigenvalues, rigid and flexible discs, importance sampling and subsets"
for pins in "determinism result_columns_are_pinned" "time_domain result_columns_are_pinned" \
    "rare_events columns_of_rare_events_are_pinned"; do
    # shellcheck disable=SC2086 # the test file, and the test in it
    set -- $pins
    STICKSLIP_TEST_PROGRAM="$place/stickslip" "$cargo" test --locked -p stickslip --test "$1" -- --exact "$2" |
        tee "$place/tests.log"
    # A test that was renamed would pass unseen.
    grep -q '^test result: ok. 1 passed' "$place/tests.log"
done

says "the bytes of results, against the program of this machine"
job() {
    cat <<END
name = "$1"
[axes]
rotating_speed = 15.0
preload = { from = 0.05, to = 0.30, points = 4 }
static_friction = { from = 0.28, to = 0.50, points = 4 }
[random]
inputs = ["preload", "static_friction"]
relative_std = 0.2
[criterion]
$2
[sampling]
$3
END
}
time_domain='kind = "time-domain"
record = ["amplitude"]'
job rigid "$time_domain
disc = \"rigid\"
start = \"rest\"" 'samples = 200
seed = 5' >"$place/rigid.toml"
job flexible "$time_domain" 'samples = 20
seed = 5' >"$place/flexible.toml"
job importance 'kind = "eigenvalue"' 'method = "importance"
samples = 1024
seed = 5' >"$place/importance.toml"
cp jobs/fig14a.toml "$place"
for name in fig14a rigid flexible importance; do
    says "$name"
    "$place/stickslip" submit "$place/$name.toml" --out "$place/there/$name" >/dev/null
    "$place/$(uname -m)" submit "$place/$name.toml" --out "$place/here/$name" >/dev/null
    cmp "$place/here/$name/surface.parquet" "$place/there/$name/surface.parquet"
    (cd "$place/there/$name" && sha256sum surface.parquet)
done

# Those of these tests that an emulator finishes in reasonable time.
says "lanes against single samples, bit for bit"
lanes=lanes::batch::tests
CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_RUNNER=$emulator \
    cargo-zigbuild test --locked --release --target $target.2.17 -p stickslip-core --lib -- --exact \
    friction::shape::tests::lanes_have_the_bits_of_single_values \
    $lanes::every_lane_has_the_bits_of_its_own_brake \
    $lanes::every_friction_law_has_the_bits_of_the_scalar_code \
    $lanes::lanes_agree_at_the_horizon_and_in_breakdown_too \
    $lanes::discs_of_another_geometry_are_simulated_one_by_one_in_the_same_queue \
    $lanes::criteria_of_several_speeds_share_lanes \
    $lanes::a_queue_that_stops_drops_what_is_not_decided |
    tee "$place/tests.log"
grep -q '^test result: ok. 7 passed' "$place/tests.log"
says "done"
