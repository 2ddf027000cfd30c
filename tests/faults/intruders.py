"""Things that do not belong in a run: pieces of other runs, and pipes, links, directories in place of files."""

import os
import shutil
import socket
from pathlib import Path
from typing import Iterator

from common import CANNOT_CREATE, DONE, INPUT_OUTPUT, JOB, PIECES, SAME, STATED, Place, Row, Suite, Try, check
from kinds import RUNS

COMMANDS = ["status run", "plot run --out plot.svg", "verify run", "resume run"]
REFUSED = (JOB, CANNOT_CREATE, INPUT_OUTPUT)
HUGE = 3 << 30


def pipe(path: Path, _: bytes) -> None:
    os.mkfifo(path)


def endless_link(path: Path, _: bytes) -> None:
    path.symlink_to("/dev/zero")


def broken_link(path: Path, _: bytes) -> None:
    path.symlink_to("nowhere")


def looping_link(path: Path, _: bytes) -> None:
    path.symlink_to(path.name)


def sound_link(path: Path, content: bytes) -> None:
    aside = path.parent.parent / "aside"
    aside.write_bytes(content)
    path.symlink_to(aside)


def directory(path: Path, _: bytes) -> None:
    path.mkdir()


def endpoint(path: Path, _: bytes) -> None:
    # The name of a socket is short.
    parent = os.open(path.parent, os.O_DIRECTORY)
    try:
        with socket.socket(socket.AF_UNIX) as made:
            made.bind(f"/proc/self/fd/{parent}/{path.name}")
    finally:
        os.close(parent)


def nothing(path: Path, _: bytes) -> None:
    path.touch()


def zeros(path: Path, content: bytes) -> None:
    path.write_bytes(bytes(len(content)))


def huge(path: Path, content: bytes) -> None:
    path.write_bytes(content)
    os.truncate(path, HUGE)


THINGS = (pipe, endless_link, broken_link, looping_link, sound_link, directory, endpoint, nothing, zeros, huge)


def in_place_of_files(suite: Suite) -> Iterator[Try]:
    for kind in suite.kinds("things", RUNS):
        for state in ("whole", "half"):
            run = getattr(suite.reference(kind, True), state)
            names = [path.relative_to(run) for path in sorted(run.rglob("*"))]
            # One piece stands for all.
            names = [name for name in names if name.suffix != ".jsonl"]
            names += [sorted(run.glob(f"{folder}/*.jsonl"))[0].relative_to(run) for folder in PIECES
                      if any(run.glob(f"{folder}/*.jsonl"))]
            # A surface may be as large as a job makes it, and is read as a whole.
            pairs = [
                (name, thing)
                for name in names
                for thing in THINGS
                if not (thing is huge and name.name in ("surface.parquet", "limits.parquet", "run.lock"))
            ]
            for number in suite.steps(len(pairs), 14, suite.chance("things", kind, state)):
                name, thing = pairs[number]
                sort = name if name.parent == Path(".") else f"{name.parent}/*"
                label = f"{state}, {thing.__name__} as {sort}"
                yield Try(kind, label, lambda place: put_in_place(place, run, name, thing), small=True)


def put_in_place(place: Place, run: Path, name: Path, thing: object) -> str:
    """Puts a thing in place of a file: nothing hangs, and after it is taken away the result is the same."""
    place.copy_of(run)
    path = place.run / name
    kept = place.path / "kept"
    path.rename(kept)
    content = kept.read_bytes() if kept.is_file() else b""
    thing(path, content)
    outcome = SAME
    for words in COMMANDS:
        # A huge file is read only up to its limit.
        ended = place.stickslip(*words.split(), expect={DONE, *REFUSED})
        if ended.code != DONE:
            outcome = STATED
            check("run" in ended.stderr, f"it does not say where: {ended.stderr!r}")
        elif words == "resume run" and (place.run / "surface.parquet").is_file():
            place.same_bytes()
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path)
    elif path.exists() or path.is_symlink():
        path.unlink()
    shutil.move(kept, path)
    for aside in [*place.run.glob("*.damaged"), *place.run.glob("*/*.damaged")]:
        if aside.is_dir() and not aside.is_symlink():
            shutil.rmtree(aside)
        else:
            aside.unlink()
    # What was written meanwhile may not fit what lay aside; verify repairs that.
    place.stickslip("verify", "run", expect={DONE, INPUT_OUTPUT})
    if not (place.run / "surface.parquet").exists():
        place.stickslip("resume", "run")
    place.finish()
    return outcome


def foreign_pieces(suite: Suite) -> Iterator[Try]:
    for kind in suite.kinds("foreign", RUNS):
        others = [(other, seed) for other in RUNS for seed in (3, 4) if (other, seed) != (kind, 3)]
        for state in ("whole", "half"):
            for number in suite.steps(len(others), 3, suite.chance("foreign", kind, state)):
                other, seed = others[number]
                label = f"{state}, pieces of {other} with seed {seed}"
                yield Try(kind, label, lambda place: foreign(place, state, other, seed), small=True)
            for number in suite.steps(len(TRICKS), 3, suite.chance("tricks", kind, state)):
                trick = TRICKS[number]
                yield Try(kind, f"{state}, {trick.__name__}", lambda place: tricked(place, state, trick), small=True)


def foreign(place: Place, state: str, other: str, seed: int) -> str:
    """Pieces of another run are refused by what they say of their job; without them the run goes on."""
    place.copy_of(getattr(place.reference, state))
    place.write_job("other.toml", other, seed)
    place.stickslip("submit", "other.toml", "--out", "other", "--threads", 1)
    put = []
    for folder in PIECES:
        for piece in sorted((place.path / "other" / folder).glob("*.jsonl")):
            (place.run / folder).mkdir(exist_ok=True)
            put.append(place.run / folder / piece.name)
            shutil.copy(piece, put[-1])
    own = {path.name for path in getattr(place.reference, state).rglob("*.jsonl")}
    put = [path for path in put if path.name not in own]
    check(any(path.parent.name == "shards" for path in put), "there is nothing foreign")
    for words in ("status run", "resume run"):
        ended = place.stickslip(*words.split(), expect={JOB})
        ended.says("run/shards/", "another")
    for path in put:
        path.unlink()
    return place.finish(STATED)


def renamed(place: Place) -> Path:
    """A sound piece under the name of another content."""
    piece = sorted(place.run.glob("shards/*.jsonl"))[0]
    path = piece.with_name("0123456789abcdef0123456789abcdef.jsonl")
    shutil.copy(piece, path)
    return path


def copied(place: Place) -> Path:
    """A sound piece that lies there twice."""
    piece = sorted(place.run.glob("shards/*.jsonl"))[0]
    path = piece.with_name(f"{piece.stem} (1).jsonl")
    shutil.copy(piece, path)
    return path


def misplaced(place: Place) -> Path:
    """A sound piece among the tiles."""
    piece = sorted(place.run.glob("shards/*.jsonl"))[0]
    (place.run / "map").mkdir(exist_ok=True)
    path = place.run / "map" / piece.name
    shutil.copy(piece, path)
    return path


def surface_as_piece(place: Place) -> Path:
    """A surface among the pieces, as if it were one."""
    path = place.run / "shards" / "surface.jsonl"
    shutil.copy(place.reference.whole / "surface.parquet", path)
    return path


def unfinished(place: Place) -> Path:
    """What a killed process leaves behind."""
    path = place.run / "shards" / ".unfinished-00000000-1-0"
    path.write_bytes(b"PAR1")
    return path


TRICKS = (renamed, copied, misplaced, surface_as_piece, unfinished)


def tricked(place: Place, state: str, trick: object) -> str:
    """Pieces that are out of place are not counted."""
    place.copy_of(getattr(place.reference, state))
    path = trick(place)
    done = place.stickslip("status", "run").stderr
    check(trick in (unfinished, misplaced) or path.name in done, f"{path.name} is not named: {done!r}")
    place.stickslip("resume", "run")
    place.same_bytes()
    for left in (path, path.with_name(f"{path.name}.damaged")):
        left.unlink(missing_ok=True)
    place.finish()
    return SAME


ROWS = [
    Row("things", "pipes, links, directories in place of files", in_place_of_files),
    Row("foreign", "pieces of other runs, and out of place", foreign_pieces),
]
