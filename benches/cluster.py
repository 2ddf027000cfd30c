"""Compares predicted with measured times of shards and merge, two processes with one thread each at a time, as on two
nodes with one processor. Started by `make bench-cluster`; needs two processors, Python alone, and some minutes.

One line each: what, number of shards, predicted seconds, measured seconds, measured over predicted, and the measured time
on processors, which other programs disturb less. Then the peak memory of a shard and of the merge. A batch system takes part in the prediction, but not here, so that its time is left out.
"""

import json
import os
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

NODES = 2

# Three inputs scatter, so that a sample costs more than its random numbers; 10 units of work in each of 1000 cells.
USUAL = """
name = "usual"
[axes]
rotating_speed = 15.0
preload = { from = 0.01, to = 0.30, points = 40 }
static_friction = { from = 0.25, to = 0.50, points = 25 }
[random]
inputs = ["preload", "static_friction", "friction.kinetic_coefficient"]
relative_std = 0.2
[criterion]
kind = "eigenvalue"
[sampling]
samples = 200_000
seed = 1
"""

# As many cells as a job may have, with few samples: what is not computing.
LARGE = """
name = "large"
[axes]
rotating_speed = 15.0
preload = { from = 0.01, to = 0.30, points = 1000 }
static_friction = { from = 0.25, to = 0.50, points = 1000 }
[random]
inputs = ["preload", "static_friction"]
relative_std = 0.2
[criterion]
kind = "eigenvalue"
[sampling]
samples = 20
seed = 1
"""


def run(*arguments):
    """Runs the program; returns its wall time and its time on processors in seconds, and its peak memory in MiB."""
    begun = time.monotonic()
    command = [str(argument) for argument in arguments]
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    message = process.stderr.read().decode()
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        sys.exit(f"{' '.join(command)} ended with {process.returncode}: {message}")
    # Kilobytes, but bytes on macOS.
    return time.monotonic() - begun, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / (2**20 if sys.platform == "darwin" else 2**10)


def compare(program, folder, name, job, numbers):
    """Runs a job in several numbers of shards, and prints what was predicted and what it took."""
    spec = folder / f"{name}.toml"
    spec.write_text(job)
    checked = subprocess.run(
        [program, "check", spec, "--nodes", str(NODES), "--threads", "1", "--json"],
        check=True, capture_output=True, cwd=folder,
    )
    cluster = json.loads(checked.stdout)["cluster"]
    print(name, "seconds of each step:", json.dumps(cluster["seconds"]))
    task = cluster["seconds"]["task"]
    surfaces = set()
    for predicted in cluster["shards"]:
        shards = predicted["shards"]
        if shards not in numbers:
            continue
        out = folder / f"{name}-{shards}"

        def shard(index):
            return run(program, "submit", spec, "--out", out, "--threads", 1, "--shard", f"{index}/{shards}")

        begun = time.monotonic()
        with ThreadPoolExecutor(NODES) as nodes:
            each = list(nodes.map(shard, range(1, shards + 1)))
        everything = time.monotonic() - begun
        merge, merge_busy, memory = run(program, "merge", out)
        rounds = -(-shards // NODES)
        busy = sum(seconds for _, seconds, _ in each)
        for what, before, took, on_processors in [
            ("a shard", predicted["shard"] - task, sum(seconds for seconds, _, _ in each) / shards, busy / shards),
            ("all shards", predicted["all"] - rounds * task, everything, busy),
            ("merge", predicted["merge"] - task, merge, merge_busy),
        ]:
            print(
                f"{name:6} {what:10} {shards:5} shards  {before:8.2f} s predicted  {took:8.2f} s measured"
                f"  {took / before:5.2f}  ({on_processors:.2f} s on processors)"
            )
        pieces = list((out / "shards").iterdir())
        size = sum(piece.stat().st_size for piece in pieces) / 2**20
        print(
            f"{name:6} {shards:5} shards: {len(pieces)} pieces ({predicted['pieces']} predicted), {size:.1f} MiB;"
            f" peak memory {max(memory for _, _, memory in each):.0f} MiB of a shard, {memory:.0f} MiB of the merge",
            flush=True,
        )
        surfaces.add((out / "surface.parquet").read_bytes())
    if len(surfaces) != 1:
        sys.exit(f"{name}: the surface depends on the number of shards")


def main():
    program = Path(sys.argv[1]).resolve()
    with tempfile.TemporaryDirectory(dir=".", prefix="bench-cluster-") as folder:
        folder = Path(folder).resolve()
        compare(program, folder, "usual", USUAL, [1, 10, 100, 1000])
        compare(program, folder, "large", LARGE, [1, 1000])


main()
