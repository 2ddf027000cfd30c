"""Damage: files of a run that are cut short or have a flipped bit."""

import random
from pathlib import Path
from typing import Iterator

from common import CANNOT_CREATE, DONE, INPUT_OUTPUT, JOB, PIECES, SAME, STATED, Place, Row, Suite, Try, check
from kinds import RUNS

SMALL = ("job.toml", "run.json", "digests.json", "run.lock")


def files(run: Path) -> list:
    """One file of each sort in a run."""
    found = [Path(name) for name in (*SMALL, "surface.parquet", "limits.parquet") if (run / name).exists()]
    for folder in PIECES:
        found += sorted(path.relative_to(run) for path in (run / folder).glob("*.jsonl"))[:1]
    return found


def damages(suite: Suite, size: int, is_small: bool, chance: random.Random) -> Iterator[str]:
    """The names of damages: every length and bit of a small file, every length and a bit of every byte of others."""
    for length in suite.steps(size, 3, chance):
        yield f"cut to {length}"
    if is_small:
        for bit in suite.steps(8 * size, 5, chance):
            yield f"bit {bit}"
    else:
        for byte in suite.steps(size, 5, chance):
            yield f"bit {8 * byte + chance.randrange(8)}"


def damage(path: Path, what: str) -> None:
    content = bytearray(path.read_bytes())
    number = int(what.split()[-1])
    if what.startswith("cut"):
        del content[number:]
    else:
        content[number // 8] ^= 1 << (number % 8)
    path.write_bytes(content)


def damaged(suite: Suite) -> Iterator[Try]:
    for kind in suite.kinds("damage", RUNS):
        reference = suite.reference(kind, True)
        for state, run in (("finished", reference.whole), ("unfinished", reference.half)):
            for file in files(run):
                size = (run / file).stat().st_size
                chance = suite.chance("damage", kind, state, file.name)
                # The same code reads the files of all kinds: every bit is flipped in those of one.
                is_small = file.name in SMALL and kind == "eigenvalue"
                sort = file.name if file.parent == Path(".") else f"{file.parent}/*"
                for what in damages(suite, size, is_small, chance):
                    label = f"{state}, {sort}, {what}"
                    yield Try(kind, label, lambda place: repaired(place, run, file, what), small=True)


def repaired(place: Place, run: Path, file: Path, what: str) -> str:
    """Damages a file of a run; the damage is named, and the run comes to the same result."""
    place.copy_of(run)
    sound = (place.run / file).read_bytes()
    damage(place.run / file, what)
    others = place.pieces() - {file}
    resumed = place.stickslip("resume", "run", "--threads", 1, expect={DONE, JOB, INPUT_OUTPUT})
    if resumed.code == DONE and file.name not in place.reference.results:
        place.same_bytes()
    verified = place.stickslip("verify", "run", expect={DONE, INPUT_OUTPUT})
    said = resumed.stderr + verified.stdout + verified.stderr
    is_lock = file.name == "run.lock"
    is_said = file.name in said or is_the_same(place, file, sound)
    check(is_lock or is_said, f"the damage to {file} is not said: {said!r}")
    if resumed.code != DONE:
        check(file.name in resumed.stderr, f"it is refused without the name of the file: {resumed.stderr!r}")
    if verified.code != DONE or resumed.code != DONE:
        # What verify cannot repair, the same job does. If the run is there and not finished, resume goes on with it.
        line = ["submit", "job.toml", "--out", "run", "--threads", 1]
        submitted = place.stickslip(*line, expect={DONE, CANNOT_CREATE})
        if submitted.code != DONE:
            place.stickslip("resume", "run", "--threads", 1)
    check(others <= place.pieces(), "sound pieces are gone")
    place.finish()
    return SAME if resumed.code == DONE else STATED


def is_the_same(place: Place, file: Path, sound: bytes) -> bool:
    """Whether a file has been written again as it was, or only its spaces differ."""
    now = (place.run / file).read_bytes()
    return now.split() == sound.split()


ROWS = [Row("damage", "truncated and flipped files", damaged)]
