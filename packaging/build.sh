#!/bin/sh
# Builds the wheel, and with it the program, for a target such as x86_64-unknown-linux-gnu into a folder:
#
#     packaging/build.sh TARGET FOLDER
#
# The same commit gives the same bytes wherever and whenever it is built: the sources of the program lie in the same place
# as far as the compiler sees, and time, language and permissions are fixed. SOURCE_DATE_EPOCH is the time that files
# carry. maturin and cargo-zigbuild must be on the path.
set -eu

target=$1
folder=$2
root=$(cd "$(dirname "$0")/.." && pwd -P)
sysroot=$(rustc --print sysroot)
compiler=$(rustc --version --verbose | sed -n 's/^commit-hash: //p')

# A path may hold spaces, so the flags are separated by what no path holds.
separator=$(printf '\037')
flags="--remap-path-prefix=$root=/stickslip"
flags="$flags$separator--remap-path-prefix=${CARGO_HOME:-$HOME/.cargo}=/cargo"
flags="$flags$separator--remap-path-prefix=$sysroot/lib/rustlib/src/rust=/rustc/$compiler"
# A build id would be a digest of paths that are not in the program.
flags="$flags$separator-Clink-arg=-Wl,--build-id=none"

umask 022
cd "$root"
unset RUSTFLAGS
export LC_ALL=C TZ=UTC CARGO_ENCODED_RUSTFLAGS="$flags" CARGO_INCREMENTAL=0
maturin build --release --locked --zig --compatibility manylinux2014 --target "$target" --out "$folder"
python -B packaging/wheel.py "$target" "$folder"/stickslip-*_"${target%%-*}".whl
