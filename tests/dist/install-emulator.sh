#!/bin/sh
# What `make test-aarch64` needs beside the tools of `make dist`: Rust's standard library for aarch64, an emulator, and a
# C library for the program in it. What is missing is installed, or named.
set -eu

target=aarch64-unknown-linux-gnu
library=/usr/aarch64-linux-gnu/lib/ld-linux-aarch64.so.1

if [ ! -d "$(rustc --print target-libdir --target $target)" ]; then
    rustup target add $target || {
        echo "test-aarch64: Rust's standard library for $target is missing; install it: rustup target add $target" >&2
        exit 1
    }
fi

packages=
command -v qemu-aarch64 >/dev/null || packages=qemu-user
[ -e $library ] || packages="$packages libc6-arm64-cross"
if [ -n "$packages" ]; then
    if [ "$(id -u)" != 0 ] || ! command -v apt-get >/dev/null; then
        echo "test-aarch64: no emulator of aarch64; as root on Debian: apt-get install $packages" >&2
        exit 1
    fi
    apt-get update
    # shellcheck disable=SC2086 # several words
    apt-get install -y --no-install-recommends $packages
fi
