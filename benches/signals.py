"""How soon signals are answered in words, and how soon the program has ended: docs/faults.md.

Usage: python3 benches/signals.py PROGRAM

Each job is interrupted several times, a while after its work has begun. One line for each figure: name, value, unit. The
largest times count; the program promises two seconds.
"""

import random
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

# How often each job is interrupted, and the seconds between which its work goes on before.
SIGNALS = 5
EARLIEST, LATEST = 1.0, 3.0

STIFF_DISC = "[model.disc]\nyoungs_modulus = 1e13\nthickness = 0.05\n"
AXES = "rotating_speed = 15.0\npreload = 0.1\nstatic_friction = 0.39"
MANY_BRAKES = "rotating_speed = { from = 10.0, to = 20.0, points = 900_000 }\npreload = 0.1\nstatic_friction = 0.39"
FROM_REST = 'kind = "time-domain"\nstart = "rest"'
LONG_MOTION = FROM_REST + '\ndisc_modes = 24\nrecord = ["amplitude"]'


def job(axes: str, inputs: str, criterion: str, sampling: str, model: str = "") -> str:
    return (
        f'name = "job"\n{model}[axes]\n{axes}\n[random]\ninputs = [{inputs}]\nrelative_std = 0.1\n'
        f"[criterion]\n{criterion}\n[sampling]\n{sampling}\n"
    )


JOBS = {
    "eigenvalues": job(AXES, '"preload", "static_friction"', 'kind = "eigenvalue"', "samples = 1_000_000_000_000"),
    "motions": job(AXES, '"preload", "pad.mass"', FROM_REST, "samples = 10_000_000"),
    "a verdict map": job(AXES, '"preload", "static_friction"', FROM_REST, 'method = "exact"', STIFF_DISC),
    "a search for rare events": job(AXES, '"preload", "pad.mass", "disc.thickness"', FROM_REST, 'method = "subset"'),
    "900,000 brakes": job(MANY_BRAKES, '"preload"', FROM_REST, "samples = 1"),
    "a motion of many seconds": job(AXES, '"preload"', LONG_MOTION, "samples = 1000", STIFF_DISC),
    "modes of many seconds": job(AXES, '"disc.poissons_ratio"', LONG_MOTION, "samples = 1000", STIFF_DISC),
}


def interrupted(program: str, folder: Path, text: str, moment: float) -> tuple:
    """Seconds from a signal to the first words and to the end; none if the job ended before."""
    (folder / "job.toml").write_text(text)
    command = [program, "submit", "job.toml", "--out", f"run-{moment}"]
    process = subprocess.Popen(command, cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    time.sleep(moment)
    if process.poll() is not None:
        raise SystemExit(f"the job is too short for this benchmark:\n{text}")
    sent = time.monotonic()
    process.send_signal(signal.SIGINT)
    answered = next(time.monotonic() - sent for line in process.stderr if "interrupted" in line)
    process.stderr.read()
    code = process.wait()
    ended = time.monotonic() - sent
    if code != 130:
        raise SystemExit(f"it ends with {code}, not 130:\n{text}")
    return answered, ended


def main() -> None:
    program = str(Path(sys.argv[1]).resolve())
    chance = random.Random(1)
    for name, text in JOBS.items():
        with tempfile.TemporaryDirectory() as folder:
            moments = [chance.uniform(EARLIEST, LATEST) for _ in range(SIGNALS)]
            times = [interrupted(program, Path(folder), text, moment) for moment in moments]
        for what, values in zip(("answered", "ended"), zip(*times)):
            print(f"{f'signal to {name}, {what} after at most':<58} {max(values):>16.3f} s", flush=True)


if __name__ == "__main__":
    main()
