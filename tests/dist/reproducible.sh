#!/bin/sh
# Whether the archive and the wheel in a folder are what another copy of the commit gives: in a folder with a longer path and
# without git, with crates unpacked elsewhere, another time zone, language and mask of permissions, and nothing in a cache.
#
#     tests/dist/reproducible.sh FOLDER TARGET
set -eu
cd "$(dirname "$0")/../.."
folder=$1
target=$2

if [ -n "$(git status --porcelain)" ]; then
    echo "test-reproducible: there are changes that are not committed, which the other copy would not have" >&2
    exit 1
fi

place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
copy=$place/a/folder/with/a/much/longer/path/than/that/of/most/repositories
mkdir -p "$copy" "$place/cargo/registry"
git archive HEAD | tar -x -C "$copy"
# Archives of crates are shared; what is unpacked from them is not.
for shared in cache index; do
    ln -s "${CARGO_HOME:-$HOME/.cargo}/registry/$shared" "$place/cargo/registry/$shared"
done

began=$(date +%s)
(
    umask 077
    export CARGO_HOME="$place/cargo" TZ=Pacific/Auckland LANG=de_DE.UTF-8
    export ZIG_GLOBAL_CACHE_DIR="$place/zig" ZIG_LOCAL_CACHE_DIR="$place/zig" XDG_CACHE_HOME="$place/cache"
    export STICKSLIP_COMMIT SOURCE_DATE_EPOCH
    STICKSLIP_COMMIT="$(git log -1 --date=short --format='%H (%cd)' | sed 's/^\(............\)[^ ]*/\1/')"
    SOURCE_DATE_EPOCH=$(git log -1 --format=%ct)
    make -C "$copy" --no-print-directory dist DIST_TARGET="$target"
)
echo "test-reproducible: the other copy took $(($(date +%s) - began)) s" >&2

differs=
for file in "$folder/stickslip-$target-v"*.tar.gz "$folder"/stickslip-*_"${target%%-*}".whl; do
    sha256sum "$file" "$copy/target/dist/$(basename "$file")"
    cmp "$file" "$copy/target/dist/$(basename "$file")" || differs=yes
done
if [ -n "$differs" ]; then
    kept=target/not-reproducible
    rm -rf $kept
    mkdir -p $kept
    cp "$copy"/target/dist/* $kept
    echo "test-reproducible: another copy of this commit gives other bytes; they are kept in $kept" >&2
    exit 1
fi
