"""Directories that cannot be written, another user, the umask, no home, and a working directory that is gone."""

import os
from typing import Iterator

from common import (
    CANNOT_CREATE,
    DONE,
    INPUT_OUTPUT,
    SAME,
    STATED,
    Place,
    Row,
    Suite,
    Try,
    check,
    need,
    need_root,
)
from kinds import NEW_RUNS
from limits import OTHER, SMALL, SmallDisk

SUBMIT = ["submit", "job.toml", "--out", "run", "--threads", 1]

# Words of a refusal that come before any computing.
# Not the user whose processes are counted, as rows are made side by side.
ANOTHER = OTHER + 1
AS_OTHER = ["setpriv", f"--reuid={ANOTHER}", f"--regid={ANOTHER}", "--clear-groups"]


def refused(place: Place, words: list, before: list = (), code: int = CANNOT_CREATE) -> None:
    """Runs a command that is refused before anything is computed."""
    ended = place.stickslip(*words, before=before, expect={code})
    ended.says("cannot create", "run")
    for computed in ("samples in", "verdict map"):
        check(computed not in ended.stderr, f"it computed before it was refused: {ended.stderr!r}")


def read_only(place: Place) -> str:
    """A file system that is mounted for reading only."""
    with SmallDisk(place, SMALL) as disk:
        disk.remount("ro")
        refused(place, ["submit", "job.toml", "--out", "disk/run"])
        disk.remount("rw")
        place.stickslip("submit", "job.toml", "--out", "disk/run", "--threads", 1, "--shard", "1/2")
        disk.remount("ro")
        before = place.pieces()
        refused(place, ["resume", "disk/run"])
        place.stickslip("status", "disk/run")
        check(place.pieces() == before, "pieces have changed")
        disk.remount("rw")
        os.symlink(place.run, place.path / "run")
        place.finish()
        disk.remount("ro")
        # A finished run can be read and checked where it cannot be written.
        for words in ("status disk/run", "verify disk/run", "plot disk/run --out plot.svg"):
            place.stickslip(*words.split())
        disk.remount("rw")
        return STATED


def another_user(place: Place) -> str:
    """A user who may read the run, but not write in it."""
    place.path.chmod(0o755)
    refused(place, SUBMIT, AS_OTHER)
    place.stickslip(*SUBMIT, "--shard", "1/2")
    refused(place, ["resume", "run"], AS_OTHER)
    place.stickslip("status", "run", before=AS_OTHER)
    (place.run / "shards").chmod(0o777)
    refused(place, ["resume", "run"], AS_OTHER)
    return place.finish(STATED)


def files_of_another_user(place: Place) -> str:
    """Files of another user in a directory that both may write."""
    place.stickslip(*SUBMIT, "--shard", "1/2")
    for folder in (place.run, *(path for path in place.run.iterdir() if path.is_dir())):
        folder.chmod(0o777)
    place.stickslip("resume", "run", "--threads", 1, before=AS_OTHER)
    return place.finish(SAME)


def unreadable_job(place: Place) -> str:
    """A job that the user may not read."""
    (place.path / "job.toml").chmod(0)
    place.stickslip(*SUBMIT, before=AS_OTHER, expect={INPUT_OUTPUT}).says("cannot read", "job.toml")
    check(not place.run.exists(), "a directory was created")
    return place.finish(STATED)


def unreadable_pieces(place: Place) -> str:
    """Pieces that the user may not read are named and left out, or the run is refused; nothing of them is lost."""
    place.stickslip(*SUBMIT, "--shard", "1/2")
    for folder in (place.run, *(path for path in place.run.iterdir() if path.is_dir())):
        folder.chmod(0o777)
    pieces = sorted(place.run.glob("*/*.jsonl"))
    for piece in pieces:
        piece.chmod(0)
    ended = place.stickslip("resume", "run", "--threads", 1, before=AS_OTHER, expect={DONE, INPUT_OUTPUT})
    for piece in pieces:
        check(piece.name in ended.stderr or ended.code == INPUT_OUTPUT, f"{piece.name} is not named: {ended.stderr!r}")
        check(piece.exists(), f"{piece.name} was removed or set aside, although it is sound")
    return place.finish(SAME if ended.code == DONE else STATED)


def masked(place: Place, mask: int) -> str:
    """A umask takes rights from the files, of the user too."""
    place.path.chmod(0o777)
    line = f"umask {mask:03o}; exec {' '.join(AS_OTHER)} \"$S\" {' '.join(map(str, SUBMIT))}"
    ended = place.shell(line, expect={DONE, CANNOT_CREATE, INPUT_OUTPUT})
    if ended.code == DONE:
        place.same_bytes()
        for path in place.run.rglob("*"):
            check(not path.stat().st_mode & mask, f"{path} has rights that the umask takes")
    else:
        ended.says("cannot ", "run")
    for path in (place.run, *place.run.rglob("*")):
        if path.is_dir():
            path.chmod(0o777)
    return place.finish(SAME if ended.code == DONE else STATED)


def no_home(place: Place) -> str:
    """An environment without variables."""
    place.stickslip(*SUBMIT, environment={})
    place.same_bytes()
    return place.finish(SAME)


def no_working_directory(place: Place) -> str:
    """The working directory is removed before the run begins."""
    line = 'mkdir gone; cd gone; rmdir ../gone; exec "$S" submit ../job.toml'
    ended = place.shell(line, expect={CANNOT_CREATE, INPUT_OUTPUT})
    ended.says("cannot ")
    (place.path / "runs").mkdir()
    # Whole paths do not need it.
    place.shell('mkdir gone; cd gone; rmdir ../gone; exec "$S" submit "$OLDPWD/job.toml" --out "$OLDPWD/run"')
    place.same_bytes()
    return place.finish(STATED)


def in_the_way(place: Place) -> str:
    """A file where the directory should be, and a directory that is no run."""
    place.run.write_text("mine")
    for words in (SUBMIT, ["submit", "job.toml", "--out", "run/run"], ["submit", "job.toml", "--out", "/proc/run"]):
        refused = place.stickslip(*words, expect={CANNOT_CREATE})
        refused.says("run")
        check("samples in" not in refused.stderr, f"it is refused after the work: {refused.stderr!r}")
    check(place.run.read_text() == "mine", "the file has changed")
    place.run.unlink()
    place.run.mkdir()
    (place.run / "mine").write_text("mine")
    place.stickslip(*SUBMIT, expect={CANNOT_CREATE}).says("not empty")
    (place.run / "mine").unlink()
    return place.finish(STATED)


def mounted(suite: Suite) -> Iterator[Try]:
    need("mount", "umount")
    need_root()
    for kind in suite.kinds("read-only", NEW_RUNS):
        yield Try(kind, "read-only", read_only, small=True)


def users(suite: Suite) -> Iterator[Try]:
    need("setpriv")
    need_root()
    for kind in suite.kinds("users", NEW_RUNS):
        for act in (another_user, files_of_another_user, unreadable_job, unreadable_pieces):
            yield Try(kind, act.__name__, act, small=True)
        for mask in (0o000, 0o022, 0o027, 0o077, 0o177, 0o222, 0o277, 0o400, 0o777):
            yield Try(kind, f"umask {mask:03o}", lambda place: masked(place, mask), small=True)


def places(suite: Suite) -> Iterator[Try]:
    for kind in suite.kinds("places", NEW_RUNS):
        for act in (no_home, no_working_directory, in_the_way):
            yield Try(kind, act.__name__, act, small=True)


ROWS = [
    Row("read-only", "a file system that is read-only", mounted),
    Row("users", "another user, no permission, umask", users),
    Row("places", "no home, no working directory, something in the way", places),
]
