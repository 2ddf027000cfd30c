"""Limits: a full disk, and the sizes of files, memory, threads and open files that a system allows."""

import contextlib
import os
import shutil
import signal
import subprocess
import time
from typing import Iterable, Iterator

from common import (
    CANNOT_CREATE,
    DONE,
    INPUT_OUTPUT,
    STATED,
    Ended,
    Missed,
    Place,
    Row,
    Skipped,
    Suite,
    Try,
    check,
    need,
    need_root,
)
from kinds import NEW_RUNS, RUNS

# Codes of a run that a limit stops.
STOPPED = (CANNOT_CREATE, INPUT_OUTPUT)

PAGE = 4096

# Bytes of a disk that another program soon fills, and of one with room for everything.
SMALL, ROOM = 4 << 20, 64 << 20

# A user who has no other process.
OTHER = 61234


class SmallDisk:
    """A file system in memory, mounted where the run of a try lies, with so many bytes for what is written."""

    def __init__(self, place: Place, size: int) -> None:
        self.place, self.path = place, place.path / "disk"
        self.filler = self.path / "filler"
        self.path.mkdir()
        self.mount("-t", "tmpfs", "-o", f"size={ROOM}", "none", self.path)
        shutil.rmtree(place.run, ignore_errors=True)
        place.run = self.path / "run"
        place.prepare()
        there = os.statvfs(self.path)
        self.remount(f"size={(there.f_blocks - there.f_bfree) * there.f_frsize + size}")

    def mount(self, *words: object) -> None:
        done = subprocess.run(["mount", *map(str, words)], capture_output=True)
        if done.returncode != 0:
            raise Skipped(f"mount does not work here: {done.stderr.decode(errors='replace').strip()}")

    def remount(self, options: str) -> None:
        self.mount("-o", f"remount,{options}", self.path)

    def fill(self, but: int = 0) -> None:
        """Fills the disk with a file, but for some pages."""
        with contextlib.suppress(OSError), self.filler.open("wb", buffering=0) as file:
            while True:
                file.write(bytes(PAGE))
        os.truncate(self.filler, self.filler.stat().st_size - but * PAGE)

    def empty(self) -> None:
        """Takes the file away. A process that another try began meanwhile has it open too, until it has become the program of
        that try, and only then there is room."""
        taken, free = self.filler.stat().st_blocks * 512, self.free()
        self.filler.unlink()
        begun = time.monotonic()
        while self.free() - free < taken:
            check(time.monotonic() - begun < self.place.suite.limit, "what the file took does not become free")
            time.sleep(0.001)

    def free(self) -> int:
        there = os.statvfs(self.path)
        return there.f_bfree * there.f_frsize

    def __enter__(self) -> "SmallDisk":
        return self

    def __exit__(self, *_: object) -> None:
        subprocess.run(["umount", "-l", str(self.path)], check=True)


def on_disk(place: Place) -> Ended:
    """Runs the job on the small disk."""
    return place.begin().ended()


def stopped_or_done(place: Place, ended: Ended, where: str) -> bool:
    """Whether a limit stopped a run, which then has said where."""
    if ended.code == DONE:
        place.same_bytes()
        return False
    check(ended.code in STOPPED, f"it ends with {ended.code}, not 73 or 74: {ended.stderr.strip()!r}")
    ended.says("cannot ", where)
    return True


def finish_on_disk(place: Place) -> str:
    """Resumes a run where it is, on the small disk."""
    os.symlink(place.run, place.path / "run")
    return place.finish(STATED)


def disk_full(suite: Suite) -> Iterator[Try]:
    need("mount", "umount")
    need_root()
    for kind in suite.kinds("disk-full"):
        survived: list = []

        def act(place: Place) -> str:
            with SmallDisk(place, pages * PAGE) as disk:
                ended = on_disk(place)
                if stopped_or_done(place, ended, "disk/run"):
                    disk.remount(f"size={ROOM}")
                    return finish_on_disk(place)
                survived.append(pages)
                return place.same_bytes()

        stride = suite.many(5, 1)
        for pages in range(suite.chance("pages", kind).randint(1, stride), 1000, stride):
            yield Try(kind, f"{pages} pages", act)
            if survived:
                break
        for number in range(suite.many(2, 20)):
            yield Try(kind, f"filled {number}", filled)
        for left in range(0, 7, suite.many(2, 1)) if kind in RUNS else ():
            yield Try(kind, f"merge with {left} pages", lambda place: full_at_the_merge(place, left), small=True)


def full_at_the_merge(place: Place, pages: int) -> str:
    """All shards have finished, and there is room for some pages."""
    with SmallDisk(place, SMALL) as disk:
        for shard in ("1/2", "2/2"):
            place.stickslip("submit", "job.toml", "--out", "disk/run", "--threads", 1, "--shard", shard)
        disk.fill(but=pages)
        ended = place.start("merge", "disk/run").ended()
        disk.empty()
        if stopped_or_done(place, ended, "disk/run"):
            return finish_on_disk(place)
        return place.same_bytes()


def filled(place: Place) -> str:
    """Another program fills the disk in mid-run."""
    with SmallDisk(place, SMALL) as disk:
        running = place.begin()
        place.wait_for_work(running)
        place.wait(running)
        disk.fill()
        ended = running.ended()
        disk.empty()
        if stopped_or_done(place, ended, "disk/run"):
            return finish_on_disk(place)
        return place.same_bytes()


def file_size(suite: Suite) -> Iterator[Try]:
    need("prlimit")
    for kind in suite.kinds("file-size"):
        whole = suite.reference(kind, True).whole
        largest = max(map(len, suite.reference(kind, True).results.values()))
        near = [path.stat().st_size - less for path in whole.rglob("*") if path.is_file() for less in (0, 1)]
        sizes = sorted({0, 1, PAGE, *near, *range(0, largest + 1, suite.many(4000, 200))})

        def act(place: Place) -> str:
            before = ["prlimit", f"--fsize={size}"]
            ended = place.begin(threads=1, before=before).ended()
            if stopped_or_done(place, ended, "run"):
                return place.finish(STATED)
            return place.same_bytes()

        for size in sizes:
            yield Try(kind, f"{size} bytes", act, small=True)


def limited(place: Place, before: list, survived: list) -> str:
    """Runs with a limit. Whether it came to its end is noted."""
    ended = place.begin(threads=4, before=before).ended()
    said = ended.stderr.strip()
    # The system ends a program that it cannot load, without a word or with one of those that load it.
    is_loaded = not any(word in said for word in ("while loading shared", "prlimit:", "setpriv:"))
    if not is_loaded or ended.code in (-signal.SIGSEGV, -signal.SIGKILL, 127) and not said:
        raise Missed("the program was not loaded")
    if ended.code == DONE:
        survived.append(before)
        return place.same_bytes()
    # Without memory, the library of C may end the program itself, also while a thread says that there is none.
    if ended.code == -signal.SIGABRT and "Fatal glibc error" in said:
        return place.finish(STATED)
    check(ended.code in STOPPED, f"it ends with {ended.code}, not 73 or 74: {said!r}")
    check(said, "it says nothing")
    return place.finish(STATED)


def until_it_runs(kinds: list, values: Iterable, words: str, prefix: list) -> Iterator[Try]:
    """Runs with a growing limit, up to one with which it comes to its end."""
    for kind in kinds:
        survived: list = []
        for value in values:
            before = [*prefix, "prlimit", words.format(value)]
            yield Try(kind, words.format(value), lambda place: limited(place, before, survived), small=True)
            if survived:
                break


def memory(suite: Suite) -> Iterator[Try]:
    need("prlimit")
    # The least with which the program is loaded; then somewhat more, where one attempt works and the next does not.
    sizes = (int(8e6 * 1.02**step) for step in range(400))
    asked = (
        (size, subprocess.run(["prlimit", f"--as={size}", suite.program, "--version"], capture_output=True))
        for size in sizes
    )
    least = next(size for size, answer in asked if answer.returncode == 0)
    for kind in suite.kinds("memory"):
        for step in range(suite.many(16, 160)):
            size = int(least * (1 + step / suite.many(20, 200)))
            before = ["prlimit", f"--as={size}"]
            yield Try(kind, f"{size} bytes", lambda place: limited(place, before, []), small=True)


def descriptors(suite: Suite) -> Iterator[Try]:
    need("prlimit")
    yield from until_it_runs(suite.kinds("descriptors"), range(3, 64), "--nofile={}", [])


def threads(suite: Suite) -> Iterator[Try]:
    need("prlimit", "setpriv")
    need_root()
    prefix = ["setpriv", f"--reuid={OTHER}", f"--regid={OTHER}", "--clear-groups"]
    yield from until_it_runs(suite.kinds("threads", NEW_RUNS), range(1, 16), "--nproc={}", prefix)


ROWS = [
    Row("disk-full", "the disk is full", disk_full),
    Row("file-size", "limit on the size of files", file_size),
    Row("memory", "limit on memory", memory),
    Row("descriptors", "limit on open files", descriptors),
    Row("threads", "limit on threads", threads),
]
